"""A sweep as the report has it: force and acceleration against frequency."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from daq.documents.shapes import Number

__all__ = ["SweepCurve"]


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepCurve:
    """The sweep of one run with its flags and its uses of the exciter's limits (1: at it), SI:
    fundamentals (peak) at the mean frequency of each cycle, or of `cycles_each` cycles together;
    phase by which force leads acceleration, rad; apparent mass Re(F A*)/|A|^2, kg; rate, Hz/s;
    shift: what the rate makes of force and acceleration, over the largest one."""

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
