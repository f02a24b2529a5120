"""A sweep in the report: force and acceleration against frequency."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from daq.documents.shapes import Number

__all__ = ["SweepCurve"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepCurve:
    """The sweep of one run, SI units.

    flags, use : of the run; utilisation of the exciter's limits (1: at the limit)
    rate : sweep rate, Hz/s
    cycles_each : number of cycles that are averaged to a point
    frequency : mean frequency of each point
    force, acceleration : fundamentals (peak)
    force_phase : phase by which force leads acceleration, rad
    M_eff : apparent mass Re(F A*)/|A|^2, kg
    shift_force, shift_acceleration : estimated error by the finite sweep rate, relative to the
        largest value
    """

    run: str
    flags: tuple[str, ...]
    use: Mapping[str, float]
    condition: str
    bed: str
    fill: Annotated[float | None, Number(0.0)]
    from_: float
    to: float
    rate: float
    cycles_each: Annotated[int, Number(1, whole=True)]
    frequency: tuple[float, ...]
    force: tuple[float, ...]
    acceleration: tuple[float, ...]
    force_phase: tuple[float, ...]
    M_eff: tuple[float, ...]
    shift_force: float | None
    shift_acceleration: float | None
