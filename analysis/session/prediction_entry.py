"""The document `prediction` of a session: plain numbers, so that a laboratory can supply its own."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

from analysis.session.former_names import prediction_today
from analysis.session.prediction import Curve, Given, SessionPrediction
from analysis.session.record import AnalysisError
from daq.documents.classes import built, shape_of
from daq.documents.shapes import Each, Keys, List, Number, Text, deviations

__all__ = ["NAMES", "PREDICTION", "VARIANTS", "PredictionEntry", "VariantEntry", "entries_of"]

NAMES = ("layers", "column", "as_printed", "own", "band")
"""Predictions that W_T may be of."""

VARIANTS = ("as_printed", "layers", "column")
"""Predictions that are reported beside it."""

Energies = Annotated[tuple[float, ...], List(Number(), least=1)]
Stated = Annotated[tuple[float, ...] | None, List(Number(), least=1)]
Relative = Annotated[float | None, Number(0.0, 1e3)]
Ratios = Annotated[tuple[float, ...], List(Number(0.0, 1e6))]


@dataclass(frozen=True, slots=True, kw_only=True)
class VariantEntry:
    """Another prediction of a condition: W_T (J) at the accelerations of its entry, or None and why
    it is not stated; relative standard uncertainties as in `PredictionEntry`.
    """

    W_T: Stated
    why: str = ""
    u_rel: Relative = None
    u_levels: Relative = None
    u_settling: Relative = None
    u_stated: Relative = None

    def curves(self, accelerations: tuple[float, ...]) -> SessionPrediction | None:
        """Return the prediction as curves over the accelerations (m/s^2); None if not stated."""
        if self.W_T is None:
            return None
        absent = Curve.of(accelerations, [0.0] * len(accelerations))
        return SessionPrediction(
            total=Curve.of(accelerations, self.W_T),
            friction=absent,
            collision=absent,
            u_rel=float(self.u_rel or 0.0),
            u_levels=float(self.u_levels or 0.0),
            u_settling=float(self.u_settling or 0.0),
            u_stated=float(self.u_stated or 0.0),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictionEntry:
    """The prediction of one condition: W_T at accelerations (m/s^2), and W_f and W_c where they are
    known; J per cycle.

    u_rel, u_levels, u_settling : relative standard uncertainties of the numerics, of interpolation
        between levels, and of the difference between the record and the predicted steady state
    u_stated : the same of the formula itself
    prediction : name of what W_T is of
    shares_mechanism : whether the bed's energy comes from the mechanism of W_T
    W_T : None for a band from W_T_low to W_T_high, and where it is not stated
    why : reason that it is not stated
    variants : other predictions by name
    model : W_T over its nominal value, for draws of the model's parameters
    refills : the same for refilled beds
    """

    acceleration: Annotated[tuple[float, ...], List(Number(0.0, above=True), least=1)]
    W_T: Stated
    W_f: Energies = ()
    W_c: Energies = ()
    model: Ratios = ()
    refills: Ratios = ()
    u_rel: Relative = None
    u_levels: Relative = None
    u_settling: Relative = None
    u_stated: Relative = None
    prediction: Annotated[str | None, Text(NAMES)] = None
    shares_mechanism: bool | None = None
    why: str = ""
    W_T_low: Stated = None
    W_T_high: Stated = None
    variants: Mapping[str, VariantEntry] = field(default_factory=dict)
    W_T_as_printed: Given = None
    bound: Given = None
    period: Given = None
    periodic_share: Given = None

    def curves(self) -> SessionPrediction | None:
        """Return the prediction as curves; None for a band, and where W_T is not stated."""
        a = self.acceleration
        if self.W_T is None:
            return None
        absent = [0.0] * len(a)
        return SessionPrediction(
            total=Curve.of(a, self.W_T),
            friction=Curve.of(a, self.W_f or absent),
            collision=Curve.of(a, self.W_c or absent),
            u_rel=float(self.u_rel or 0.0),
            u_levels=float(self.u_levels or 0.0),
            u_settling=float(self.u_settling or 0.0),
            u_stated=float(self.u_stated or 0.0),
        )

    def others(self) -> dict[str, SessionPrediction]:
        """Return the variants that are stated as curves, by name."""
        found = {name: one.curves(self.acceleration) for name, one in self.variants.items()}
        return {name: curves for name, curves in found.items() if curves is not None}

    def band(self, levels: Sequence[float]) -> tuple[float, float] | None:
        """Return the band of W_T as means over runs at their levels (m/s^2), J; None without one,
        and where a level is beyond the table.
        """
        if self.W_T_low is None or self.W_T_high is None:
            return None
        low, high = (Curve.of(self.acceleration, edge) for edge in (self.W_T_low, self.W_T_high))
        if not all(high.reaches(level) for level in levels):
            return None
        n = len(levels)
        return math.fsum(map(low, levels)) / n, math.fsum(map(high, levels)) / n


LISTS = ("acceleration", "W_T", "W_f", "W_c", "W_T_low", "W_T_high")
PREDICTION = Keys({"conditions": Each(replace(shape_of(PredictionEntry), as_long=LISTS))})
"""The session's document."""


def entries_of(document: Mapping[str, Any] | None) -> dict[str, PredictionEntry]:
    """Return the entries of a prediction by condition. AnalysisError with the first deviation."""
    if not document:
        return {}
    document = prediction_today(document)
    for sentence in deviations(document, PREDICTION, "prediction"):
        raise AnalysisError(f"the session's document {sentence}")
    entries = {
        name: built(PredictionEntry, entry) for name, entry in document["conditions"].items()
    }
    for name, entry in entries.items():
        for variant, one in entry.variants.items():
            if one.W_T is not None and len(one.W_T) != len(entry.acceleration):
                where = f"prediction.conditions.{name}"
                raise AnalysisError(
                    f"the session's document {where}.acceleration, variants.{variant}.W_T are not equally long"
                )
    return entries
