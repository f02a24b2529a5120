"""How finely and how long each condition was simulated, where a tolerance decided it (document
`fidelity`).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from daq.documents.classes import LEFT_OUT
from daq.documents.shapes import Number

__all__ = ["ChosenFidelity", "CycleCounts", "Fidelity"]

Lengths = tuple[float | None, float | None, float | None]
"""Rows per layer, cycles to settle and to record."""
Told = Annotated[float | None, Number(), LEFT_OUT]


@dataclass(frozen=True, slots=True)
class CycleCounts:
    """Cycles that were run, as written and fully resolved; planning: to find the choice, once."""

    auto: float
    written: float
    resolved: float
    planning: Told = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ChosenFidelity:
    """What was chosen for a condition, and the error that it predicts, relative to W; why the
    tolerance is not met.
    """

    id: str
    tolerance: Told = None
    rows: float | None
    settle: float | None
    record: float | None
    written: Lengths
    resolved: Lengths
    error_rows: float | None
    error_window: float | None
    error_noise: float | None
    scatter: Told = None
    scatter_resolved: Told = None
    averaged: Told = None
    skipped: tuple[str, ...]
    row_cycles: Annotated[Mapping[str, float] | None, LEFT_OUT] = None
    error: float | None
    met: bool
    why: str | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Fidelity:
    """The choices of a session and what they cost; rows_share: part of the tolerance that rows may
    take.
    """

    mode: Annotated[str | None, LEFT_OUT] = None
    tolerance: Annotated[float, Number(1e-9, 1e9)]
    rows_share: float
    conditions: tuple[ChosenFidelity, ...]
    cycles: CycleCounts
    row_cycles: CycleCounts
    not_met: tuple[str, ...]
