"""Faults of the measurement chain that a protocol asks for: kind, channel, time and size
(docs/acquisition.md).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from rig.units import Quantity

Kind = Literal[
    "dropout", "cable_open", "stuck", "spike", "bias", "drift", "noise", "gain_step", "clock_slip"
]  # fmt: skip
Recorded = Literal["force", "acceleration", "current", "voltage"]

SIZES = {
    "spike": Quantity("number", -2.0, 2.0),
    "bias": Quantity("number", -2.0, 2.0),
    "drift": Quantity("number", -2.0, 2.0),
    "noise": Quantity("number", 0.0, 1.0, above=True),
    "gain_step": Quantity("number", -1.0, 10.0),
    "clock_slip": Quantity("number", 1, 1000, whole=True),
}
"""Kind -> allowed `size`. Of spike, bias, drift and noise it is a fraction of the input range, of
gain_step a relative change, of clock_slip whole samples. Kinds without an entry have no size.
"""


@dataclass(frozen=True)
class Fault:
    """One fault. `start`: cycles from the start of the drive. `duration`: cycles; null lasts to the
    end of the run (of a spike: one sample). `repeat`: the only repeat of each condition that has
    the fault; null for all repeats.
    """

    kind: Kind
    channel: Recorded
    start: Annotated[float, Quantity("cycles", 0.0, 1e7)]
    duration: Annotated[float | None, Quantity("cycles", 0.0, 1e7, above=True)] = None
    size: Annotated[float, Quantity("number", -1e4, 1e4)] = 0.0
    repeat: Annotated[int | None, Quantity("number", 1, 10000)] = None
