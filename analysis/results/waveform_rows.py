"""Rows of the report about the example condition: its waveforms and W of every cycle."""

from dataclasses import dataclass
from typing import Annotated

from daq.documents.classes import LEFT_OUT, AtLeast
from daq.documents.shapes import Number

__all__ = ["RunCycles", "Waveforms"]


@dataclass(frozen=True, slots=True)
class RunCycles:
    """W of each cycle of a run, J."""

    run: str
    W_cycles: Annotated[tuple[float, ...], AtLeast(1)]


@dataclass(frozen=True, slots=True)
class Waveforms:
    """The mean cycle of a condition's first run, and W of each cycle of all its runs.

    force, acceleration : phasors (peak, real and imaginary part, N and m/s^2) of harmonics 1, 2,
        ...
    cycles_each : number of cycles that each value of W is the mean of; the last value of a run may
        be of fewer
    """

    condition: str
    run: str
    frequency: float
    force: tuple[tuple[float, float], ...]
    acceleration: tuple[tuple[float, float], ...]
    thd_force: float | None
    thd_acceleration: float | None
    runs: tuple[RunCycles, ...]
    cycles_each: Annotated[int, Number(1, whole=True), LEFT_OUT] = 1
