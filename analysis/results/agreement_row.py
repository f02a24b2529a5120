"""What the report says of all conditions together: ratio, line and the three comparisons."""

from dataclasses import dataclass
from typing import Annotated

from daq.documents.shapes import Number

__all__ = ["AgreementRow", "ComparisonRow", "LineRow"]

Size = Annotated[float | None, Number(0.0)]
Count = Annotated[int, Number(0, whole=True)]


@dataclass(frozen=True, slots=True)
class LineRow:
    """A straight line through W_exp against W_T; where none is likely chi^2 alone."""

    slope: float | None
    U_slope: float | None
    intercept: float | None
    U_intercept: float | None
    chi2: float
    dof: Annotated[int, Number()]


@dataclass(frozen=True, slots=True, kw_only=True)
class AgreementRow:
    """Energy-weighted ratio of W_exp and W_T with its U, slope through the origin, line, mean
    offset of n conditions; put_in: losses that the rig file adds, as a fraction of the predicted
    energy; `.._recorded`: with W_T on the recorded waveforms."""

    ratio: float | None
    U_ratio: Size
    k: Size
    nu: Size
    slope: float | None
    U_slope: Size
    line: LineRow | None = None
    mean_offset: float | None
    n: Count
    put_in: float | None
    ratio_recorded: float | None
    U_ratio_recorded: Size
    put_in_recorded: float | None = None


@dataclass(frozen=True, slots=True)
class ComparisonRow:
    """One of the three comparisons: W_exp against what, of n conditions how many within U, and what
    it cannot tell.
    """

    comparison: str
    against: str
    n: Count
    within: Count
    why: str
