"""The stand of the particle-damper test rig; names load their module on first use."""

import importlib
from typing import TYPE_CHECKING

from daq.caches import place_caches

if TYPE_CHECKING:
    from rig.beds.bed import Reaction
    from rig.beds.janssen_stack import bed_mass, nominal
    from rig.beds.registry import BEDS
    from rig.campaign.campaign import Campaign
    from rig.campaign.replayer import replay
    from rig.campaign.resolve import campaign_of
    from rig.campaign.runner import run
    from rig.catalog.entries import Rig
    from rig.catalog.rig_file import dump_rig, load_rig
    from rig.drive.waveform import Sampling, Waveform, viscous_energy
    from rig.errors import InputError
    from rig.prediction.model import Prediction, predict
    from rig.protocol.grid import conditions
    from rig.protocol.load import dump_protocol, load_protocol
    from rig.protocol.spec import Condition, Protocol
    from rig.stand.prescribed import Stand

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
    "Campaign": "rig.campaign.campaign",
    "Condition": "rig.protocol.spec",
    "InputError": "rig.errors",
    "Prediction": "rig.prediction.model",
    "Protocol": "rig.protocol.spec",
    "Reaction": "rig.beds.bed",
    "Rig": "rig.catalog.entries",
    "Sampling": "rig.drive.waveform",
    "Stand": "rig.stand.prescribed",
    "Waveform": "rig.drive.waveform",
    "bed_mass": "rig.beds.janssen_stack",
    "campaign_of": "rig.campaign.resolve",
    "conditions": "rig.protocol.grid",
    "dump_protocol": "rig.protocol.load",
    "dump_rig": "rig.catalog.rig_file",
    "load_protocol": "rig.protocol.load",
    "load_rig": "rig.catalog.rig_file",
    "nominal": "rig.beds.janssen_stack",
    "predict": "rig.prediction.model",
    "replay": "rig.campaign.replayer",
    "run": "rig.campaign.runner",
    "viscous_energy": "rig.drive.waveform",
}

place_caches()


def __getattr__(name: str) -> object:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'rig' has no attribute {name!r}")
    return getattr(importlib.import_module(home), name)
