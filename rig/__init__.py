"""The stand of the particle-damper test rig; names load their module on first use."""

import importlib
from typing import TYPE_CHECKING

from daq.caches import place_caches

if TYPE_CHECKING:
    from rig.beds.bed import Reaction
    from rig.beds.registry import BEDS
    from rig.beds.stack import bed_mass, nominal
    from rig.campaign.replaying import replay
    from rig.campaign.resolve import campaign_of
    from rig.campaign.running import run
    from rig.campaign.setup import Campaign
    from rig.catalog.entries import Rig
    from rig.catalog.rigfile import dump_rig, load_rig
    from rig.drive.waveform import Sampling, Waveform, viscous_energy
    from rig.errors import InputError
    from rig.grid import conditions
    from rig.model import Prediction, predict
    from rig.protocol import dump_protocol, load_protocol
    from rig.scene import Condition, Protocol
    from rig.stand import Stand

__all__ = [
    "BEDS",
    "Campaign",
    "Condition",
    "InputError",
    "Prediction",
    "Protocol",
    "Reaction",
    "Rig",
    "Sampling",
    "Stand",
    "Waveform",
    "bed_mass",
    "campaign_of",
    "conditions",
    "dump_protocol",
    "dump_rig",
    "load_protocol",
    "load_rig",
    "nominal",
    "predict",
    "replay",
    "run",
    "viscous_energy",
]

_HOME = {
    "BEDS": "rig.beds.registry",
    "Campaign": "rig.campaign.setup",
    "Condition": "rig.scene",
    "InputError": "rig.errors",
    "Prediction": "rig.model",
    "Protocol": "rig.scene",
    "Reaction": "rig.beds.bed",
    "Rig": "rig.catalog.entries",
    "Sampling": "rig.drive.waveform",
    "Stand": "rig.stand",
    "Waveform": "rig.drive.waveform",
    "bed_mass": "rig.beds.stack",
    "campaign_of": "rig.campaign.resolve",
    "conditions": "rig.grid",
    "dump_protocol": "rig.protocol",
    "dump_rig": "rig.catalog.rigfile",
    "load_protocol": "rig.protocol",
    "load_rig": "rig.catalog.rigfile",
    "nominal": "rig.beds.stack",
    "predict": "rig.model",
    "replay": "rig.campaign.replaying",
    "run": "rig.campaign.running",
    "viscous_energy": "rig.drive.waveform",
}

place_caches()


def __getattr__(name: str) -> object:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'rig' has no attribute {name!r}")
    return getattr(importlib.import_module(home), name)
