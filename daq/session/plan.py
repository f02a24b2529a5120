"""A session's content as plain values: the plan from which a recorder is created, and the values
that a record returns.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from daq.chain.channel import ChannelInfo

__all__ = [
    "CHUNK",
    "RUN_NAME",
    "SCHEMA",
    "ChannelSignal",
    "RunInfo",
    "RunPlan",
    "SessionError",
    "SessionPlan",
    "WriteError",
    "block_dtype",
    "run_info",
    "status_dtype",
]

SCHEMA = "rig/session/1"

RUN_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*", re.ASCII)
"""Allowed names of runs: files are named after them."""

CHUNK = 16384  # samples; hardware.md, record format


class SessionError(Exception):
    """A session file cannot be written or read as requested; the message is one sentence."""


class WriteError(SessionError):
    """The disk or the folder failed during writing; everything flushed before is kept."""


@dataclass(frozen=True)
class RunPlan:
    """One run (condition x repeat) for which a session has room.

    name: group name, e.g. "run_0001". order: place in the randomised order of execution, from 1.
    samples: per channel, including settling. settle_samples: samples before the measured part.
    blocks: largest number of blocks. t0: ISO 8601 time of drive time 0. rate (Hz), ledger_cycles:
    only where they differ from the session's.
    """

    name: str
    condition: str
    repeat: int
    order: int
    samples: int
    settle_samples: int
    blocks: int
    t0: str = ""
    title: str = ""
    rate: float | None = None
    ledger_cycles: int | None = None


@dataclass(frozen=True)
class SessionPlan:
    """Everything in a session file except the samples, fixed when the file is created.

    protocol_text: the protocol file, verbatim; protocol: the same, parsed. conditions: one mapping
    each, with "id". documents, truth_documents: JSON values by name ("prediction", "rig",
    "provenance"...), the latter for simulated sessions only. ledger_columns: names, J per cycle
    each, with ledger_cycles rows per run. scalars: names of the floats stored at the end of every
    run. attrs: further root attributes.
    """

    rate: float
    channels: tuple[ChannelInfo, ...]
    runs: tuple[RunPlan, ...]
    conditions: tuple[Mapping[str, Any], ...]
    protocol_text: str
    protocol: Mapping[str, Any]
    documents: Mapping[str, Any] = field(default_factory=dict)
    truth_documents: Mapping[str, Any] = field(default_factory=dict)
    ledger_columns: tuple[str, ...] = ()
    ledger_cycles: int = 0
    scalars: tuple[str, ...] = ()
    attrs: Mapping[str, str | int | float] = field(default_factory=dict)
    synthetic: bool = True
    schema: str = SCHEMA


@dataclass(frozen=True)
class RunInfo:
    """A run as a record shows it. samples: number valid so far, of `planned`; flags: sticky `Flag`
    bits over the run.
    """

    name: str
    condition: str
    repeat: int
    order: int
    samples: int
    settle_samples: int
    complete: bool
    flags: int
    planned: int
    rate: float
    t0: str
    title: str


@dataclass(frozen=True, eq=False)
class ChannelSignal:
    """Samples of one channel in engineering units (certified sensitivity). flags: `Flag` bits of
    the blocks read.
    """

    samples: npt.NDArray[np.float64]
    rate: float
    unit: str
    flags: int


status_dtype = np.dtype(
    [("samples", "<u8"), ("blocks", "<u4"), ("complete", "u1"), ("flags", "<u2")]
)


def block_dtype(channels: int) -> np.dtype[np.void]:
    """Return the row type of a run's `blocks` table."""
    per_channel = (channels,)
    return np.dtype(
        [
            ("start", "<u8"),
            ("count", "<u4"),
            ("flags", "<u2", per_channel),
            ("clipped", "<u4", per_channel),
        ]
    )


def run_info(plan: RunPlan, status: Any) -> RunInfo:
    """Return the state of a run from its plan (with its own rate) and its status row."""
    return RunInfo(
        name=plan.name,
        condition=plan.condition,
        repeat=plan.repeat,
        order=plan.order,
        samples=int(status["samples"]),
        settle_samples=plan.settle_samples,
        complete=bool(status["complete"]),
        flags=int(status["flags"]),
        planned=plan.samples,
        rate=float(plan.rate or 0.0),
        t0=plan.t0,
        title=plan.title,
    )
