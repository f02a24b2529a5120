"""The comparison of two sessions: its fields are the keys of comparison.json, whose meanings are in
docs/report.md.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from analysis.session.record import AnalysisError
from daq.documents.classes import DocumentError, from_document, to_document
from daq.documents.shapes import List, Number, Text

__all__ = [
    "SCHEMA",
    "ComparedPair",
    "ComparedSession",
    "Comparison",
    "OverallDifference",
    "RankOrder",
    "Unmatched",
]

SCHEMA = "rig/comparison/1"
AtLeastZero = Annotated[float, Number(0.0)]
Size = Annotated[float | None, Number(0.0)]
Share = Annotated[float, Number(0.0, 1.0)]
Count = Annotated[int, Number(0, whole=True)]
One = Annotated[int, Number(1, whole=True)]
Tau = Annotated[float | None, Number(-1.0, 1.0)]
TAU = Number(-1.0, 1.0, null=True)


@dataclass(frozen=True, slots=True)
class ComparedSession:
    """One of the two sessions."""

    name: str
    protocol: str
    synthetic: bool
    verdict: Annotated[str, Text(("passes", "fails"))]
    beds: tuple[str, ...]
    drives: tuple[str, ...]
    conditions: Count
    ratio: float | None
    U_ratio: Size


@dataclass(frozen=True, slots=True)
class ComparedPair:
    """Two conditions with equal settings.

    difference : W of B less W of A, J per cycle
    relative : the difference over W of A; None where one of the two is below the detection limit or
        its U
    not_compared : settings that one of the two does not state
    """

    A: str
    B: str
    material: str
    density: Size
    diameter: Size
    fill: Size
    frequency: Size
    acceleration_set: Size
    not_compared: tuple[str, ...]
    bed_A: str
    bed_B: str
    acceleration_A: Size
    acceleration_B: Size
    W_A: float
    U_A: AtLeastZero
    W_B: float
    U_B: AtLeastZero
    difference: float
    U_difference: AtLeastZero
    E_n: float | None
    p: Share
    relative: float | None
    U_relative: Size
    runs_A: One
    runs_B: One
    p_holm: Share
    significant: bool


@dataclass(frozen=True, slots=True)
class Unmatched:
    """A condition of session A or B without a match, and why."""

    session: Annotated[str, Text(("A", "B"))]
    id: str
    why: str


@dataclass(frozen=True, slots=True)
class OverallDifference:
    """Sum of W_B over sum of W_A, less 1, over n pairs."""

    relative: float
    U: AtLeastZero
    k: AtLeastZero
    nu: Size
    n: One


@dataclass(frozen=True, slots=True)
class RankOrder:
    """Kendall's tau over n pairs with its 95 % interval, and the rank orders of two conditions
    each.

    orders : number of orders
    opposite : number of orders that differ between the sessions
    decided_opposite : opposite orders in which both differences exceed their U
    """

    n: Count
    tau: Tau
    interval: Annotated[tuple[float, float] | None, List(TAU, 2, 2)]
    orders: Count
    opposite: Count
    decided_opposite: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Comparison:
    """The comparison of two sessions."""

    schema: Annotated[str, Text((SCHEMA,))]
    sessions: tuple[ComparedSession, ComparedSession]
    matched_by: tuple[str, ...]
    same_instruments: bool
    pairs: tuple[ComparedPair, ...]
    alone: tuple[Unmatched, ...]
    overall: OverallDifference | None
    ranks: RankOrder

    def document(self) -> dict[str, Any]:
        """Return comparison.json as a plain dict."""
        return to_document(self)

    @classmethod
    def of(cls, document: Mapping[str, Any], name: str = "comparison.json") -> "Comparison":
        """Return the comparison that a comparison.json holds. AnalysisError with the first key that
        is missing or wrong.
        """
        try:
            return from_document(cls, document)
        except DocumentError as error:
            raise AnalysisError(f"{name}: {error}") from error
