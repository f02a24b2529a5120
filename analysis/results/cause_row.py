"""A cause of an offset in the report, with what distinguishes it from others."""

from dataclasses import dataclass
from typing import Annotated

from daq.documents.shapes import Number, Text

__all__ = ["CauseRow", "Growth", "Span"]

Size = Annotated[float | None, Number(0.0)]
From = Annotated[str | None, Text(("run", "computed"))]


@dataclass(frozen=True, slots=True)
class Growth:
    """Exponents with which a cause grows; None where the run cannot tell."""

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
    """share: of W_T, weighted with energy; empty and locked: energy left in the empty box and in a
    locked bed over the largest W_T at the same level, from the run or computed;
    over_first_principles: the loss's coefficient over its size by first principles, None for other
    causes and where nobody computed it."""

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
