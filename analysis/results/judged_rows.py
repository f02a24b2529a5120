"""Rows of the report about judged items: claims, null tests, references."""

from dataclasses import dataclass
from typing import Annotated

from daq.documents.shapes import Number, Text

__all__ = ["CaseRow", "ClaimRow", "NullRow", "ReferenceRow"]

Judged = Annotated[str, Text(("holds", "does not hold", "undecided", "imposed"))]
AtLeastZero = Annotated[float, Number(0.0)]
Size = Annotated[float | None, Number(0.0)]


@dataclass(frozen=True, slots=True)
class CaseRow:
    """One case of a claim; ties: values that do not differ significantly from the best."""

    at: str
    found: str
    verdict: Judged
    why: str
    ties: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ClaimRow:
    """A claim with its finding, and its cases where there are several."""

    claim: str
    test: str
    found: str
    verdict: Judged
    why: str
    ties: tuple[str, ...]
    cases: tuple[CaseRow, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class NullRow:
    """A null test (analysis.comparison.null_tests.NullTest): angle dphi, rad; gain: of a loop-back,
    relative.
    """

    null: Annotated[str, Text(("locked", "carried", "loop-back"))]
    bed_mass: AtLeastZero
    frequency: AtLeastZero
    levels: Annotated[int, Number(0, whole=True)]
    dphi: float | None
    U_dphi: Size
    k: Size
    nu: Size
    gain: float | None = None
    U_gain: Size = None
    verdict: Judged
    why: str


@dataclass(frozen=True, slots=True)
class ReferenceRow:
    """A reference (analysis.comparison.family_of_tests.Reference)."""

    reference: str
    of: str
    unit: str
    value: float | None
    expected: float | None
    U: Size
    verdict: Judged
    why: str
