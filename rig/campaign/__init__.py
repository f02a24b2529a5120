"""The composition root, the only place that sees all three packages."""

from rig.campaign.recording import Progress
from rig.campaign.replaying import replay
from rig.campaign.running import run
from rig.campaign.setup import Campaign

__all__ = ["Campaign", "Progress", "replay", "run"]
