"""The document `prediction` of a session: plain numbers, so that a laboratory can supply its own."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Any

from analysis.session.former_names import prediction_today
from analysis.session.prediction import Curve, Given, SessionPrediction
from analysis.session.record import AnalysisError
from daq.documents.classes import built, shape_of
from daq.documents.shapes import Each, Keys, List, Number, deviations

__all__ = ["PREDICTION", "PredictionEntry", "entries_of"]

Energies = Annotated[tuple[float, ...], List(Number(), least=1)]
Relative = Annotated[float | None, Number(0.0, 1e3)]
Ratios = Annotated[tuple[float, ...], List(Number(0.0, 1e6))]


@dataclass(frozen=True, slots=True, kw_only=True)
class PredictionEntry:
    """The prediction of one condition: W_T at accelerations (m/s^2), and W_f and W_c where they are
    known; J per cycle.

    u_rel, u_levels, u_settling : relative standard uncertainties of the numerics, of interpolation
        between levels, and of the difference between the record and the predicted steady state
    model : W_T over its nominal value, for draws of the model's parameters
    refills : the same for refilled beds
    """

    acceleration: Annotated[tuple[float, ...], List(Number(0.0, above=True), least=1)]
    W_T: Energies
    W_f: Energies = ()
    W_c: Energies = ()
    model: Ratios = ()
    refills: Ratios = ()
    u_rel: Relative = None
    u_levels: Relative = None
    u_settling: Relative = None
    W_T_as_printed: Given = None
    bound: Given = None
    period: Given = None
    periodic_share: Given = None

    def curves(self) -> SessionPrediction:
        """Return the prediction as curves."""
        a = self.acceleration
        absent = [0.0] * len(a)
        return SessionPrediction(
            total=Curve.of(a, self.W_T),
            friction=Curve.of(a, self.W_f or absent),
            collision=Curve.of(a, self.W_c or absent),
            u_rel=float(self.u_rel or 0.0),
            u_levels=float(self.u_levels or 0.0),
            u_settling=float(self.u_settling or 0.0),
        )


PREDICTION = Keys(
    {
        "conditions": Each(
            replace(shape_of(PredictionEntry), as_long=("acceleration", "W_T", "W_f", "W_c"))
        )
    }
)
"""Schema of the session's document `prediction`."""


def entries_of(document: Mapping[str, Any] | None) -> dict[str, PredictionEntry]:
    """Return the entries of a prediction by condition. AnalysisError with the first deviation."""
    if not document:
        return {}
    document = prediction_today(document)
    for sentence in deviations(document, PREDICTION, "prediction"):
        raise AnalysisError(f"the session's document {sentence}")
    return {name: built(PredictionEntry, entry) for name, entry in document["conditions"].items()}
