"""The acquisition of a particle-damper test rig: volts, codes, clocks and session files. It knows no grain.

Names load their module on first use: h5py takes a while.
"""

import importlib
from typing import TYPE_CHECKING

from daq.caches import place_caches

if TYPE_CHECKING:
    from daq.block import Block, Flag
    from daq.session import Recorder
    from daq.session_plan import RunPlan, SessionError, SessionPlan
    from daq.session_record import Record, open_session

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
    "Block": "daq.block",
    "Flag": "daq.block",
    "Record": "daq.session_record",
    "Recorder": "daq.session",
    "RunPlan": "daq.session_plan",
    "SessionError": "daq.session_plan",
    "SessionPlan": "daq.session_plan",
    "open_session": "daq.session_record",
}

place_caches()


def __getattr__(name: str) -> object:
    home = _HOME.get(name)
    if home is None:
        raise AttributeError(f"module 'daq' has no attribute {name!r}")
    return getattr(importlib.import_module(home), name)
