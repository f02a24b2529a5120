"""Rows of the report about all conditions together: agreement, comparisons, causes of an offset."""

from dataclasses import dataclass
from typing import Annotated

from daq.documents.shapes import Number, Text

__all__ = ["AgreementRow", "CauseRow", "ComparisonRow", "Growth", "LineRow", "Span"]

Size = Annotated[float | None, Number(0.0)]
Count = Annotated[int, Number(0, whole=True)]
From = Annotated[str | None, Text(("run", "computed"))]


@dataclass(frozen=True, slots=True)
class LineRow:
    """A straight line through W_exp against W_T; chi^2 alone where no line is likely."""

    slope: float | None
    U_slope: float | None
    intercept: float | None
    U_intercept: float | None
    chi2: float
    dof: Annotated[int, Number()]


@dataclass(frozen=True, slots=True, kw_only=True)
class AgreementRow:
    """The agreement of all conditions.

    ratio, slope, line, mean_offset : see `analysis.comparison.pooled_results`; mean_offset is that
        of n conditions
    put_in : losses that the rig file adds, as a fraction of the predicted energy
    ratio_recorded, put_in_recorded : the same with W_T on the recorded waveforms
    bands, inside : number of conditions whose W_T is a band, and of those with W_exp in it
    """

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
    bands: Count = 0
    inside: Count = 0


@dataclass(frozen=True, slots=True)
class ComparisonRow:
    """One of the three comparisons: W_exp against what, the number of conditions and of those
    within U, and the limits of the comparison.
    """

    comparison: str
    against: str
    n: Count
    within: Count
    why: str


@dataclass(frozen=True, slots=True)
class Growth:
    """Exponents with which a cause grows; None where the session cannot show them."""

    acceleration: float | None
    mass: float | None
    fill: float | None


@dataclass(frozen=True, slots=True)
class Span:
    """Least and largest value over the conditions."""

    low: Size
    high: Size


@dataclass(frozen=True, slots=True)
class CauseRow:
    """A candidate cause of an offset, with the marks that distinguish it.

    share : fraction of W_T, weighted with energy
    empty, locked : energy in the empty box and with a locked bed over the largest W_T at the same
        level
    empty_from, locked_from : "run" where it was observed, "computed" from the closed form
    over_first_principles : the loss's coefficient over its value by first principles; None for
        other causes and where the session does not state it
    """

    cause: str
    law: str
    words: str
    in_run: bool
    grows_with: Growth
    share: float | None
    empty: float | None
    empty_from: From
    locked: float | None
    locked_from: From
    over_first_principles: Span | None
    note: str
