"""Resolution and length of each simulation where a tolerance chose them: the document `fidelity`."""

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
    """Numbers of cycles computed.

    auto : with the chosen resolution
    written : with the values in the protocol
    resolved : at full resolution
    planning : to find the choice, once
    """

    auto: float
    written: float
    resolved: float
    planning: Told = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ChosenFidelity:
    """The choice for one condition and its predicted error, relative to W.

    rows, settle, record : rows per layer, cycles to settle and to record
    met, why : whether the tolerance is met; if not, why
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
    """The choices of a session and their cost; rows_share: fraction of the tolerance that the
    number of rows may use up.
    """

    mode: Annotated[str | None, LEFT_OUT] = None
    tolerance: Annotated[float, Number(1e-9, 1e9)]
    rows_share: float
    conditions: tuple[ChosenFidelity, ...]
    cycles: CycleCounts
    row_cycles: CycleCounts
    not_met: tuple[str, ...]
