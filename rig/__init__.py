"""The stand of the particle-damper test rig; names load their module on first use."""

import importlib
from typing import TYPE_CHECKING

from daq.caches import place_caches

if TYPE_CHECKING:
    from rig.campaign import run
    from rig.model import predict
    from rig.protocol import load_protocol

__all__ = ["load_protocol", "predict", "run"]

_HOME = {"load_protocol": "rig.protocol", "predict": "rig.model", "run": "rig.campaign"}

place_caches()


def __getattr__(name: str) -> object:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'rig' has no attribute {name!r}")
    return getattr(importlib.import_module(home), name)
