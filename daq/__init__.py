"""Data acquisition of a particle-damper test rig: volts, codes, clocks and session files.

Nothing here knows about grains. The public names load their modules on first use, because h5py
takes a while to import.
"""

import importlib
from typing import TYPE_CHECKING

from daq.caches import place_caches

if TYPE_CHECKING:
    from daq.chain.block import Block, Flag
    from daq.session.plan import RunPlan, SessionError, SessionPlan
    from daq.session.record import Record, open_session
    from daq.session.writer import Recorder

__all__ = [
    "Block",
    "Flag",
    "Record",
    "Recorder",
    "RunPlan",
    "SessionError",
    "SessionPlan",
    "open_session",
]

_HOME = {
    "Block": "daq.chain.block",
    "Flag": "daq.chain.block",
    "Record": "daq.session.record",
    "Recorder": "daq.session.writer",
    "RunPlan": "daq.session.plan",
    "SessionError": "daq.session.plan",
    "SessionPlan": "daq.session.plan",
    "open_session": "daq.session.record",
}

place_caches()


def __getattr__(name: str) -> object:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'daq' has no attribute {name!r}")
    return getattr(importlib.import_module(home), name)
