"""The composition root, the only place that sees all three packages."""

from rig.campaign.recording import Progress
from rig.campaign.replaying import replay
from rig.campaign.running import run
from rig.campaign.setup import Campaign
from rig.campaign.watching import Look

__all__ = ["Campaign", "Look", "Progress", "replay", "run"]
