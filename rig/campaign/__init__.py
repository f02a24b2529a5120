"""The composition root, the only place that sees all three packages."""

from rig.campaign.running import Progress, run
from rig.campaign.setup import Campaign

__all__ = ["Campaign", "Progress", "run"]
