"""The composition root, the only place that sees all three packages; names load their module on first use."""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rig.campaign.recording import Progress
    from rig.campaign.replaying import replay
    from rig.campaign.running import run
    from rig.campaign.setup import Campaign
    from rig.campaign.watching import Look

__all__ = ["Campaign", "Look", "Progress", "replay", "run"]

_HOME = {
    "Campaign": "rig.campaign.setup",
    "Look": "rig.campaign.watching",
    "Progress": "rig.campaign.recording",
    "replay": "rig.campaign.replaying",
    "run": "rig.campaign.running",
}


def __getattr__(name: str) -> object:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'rig.campaign' has no attribute {name!r}")
    return getattr(importlib.import_module(home), name)
