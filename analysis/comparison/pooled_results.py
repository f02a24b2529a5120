"""Results pooled over the conditions of a session: ratio of energies, lines, mean offset, three
comparisons.

Errors that conditions have in common are propagated as fully correlated.

The three comparisons answer different questions and are never mixed. chain: W_exp against the
simulation's own ledger tests the instruments and the analysis. prediction: against W_T as the model
gives it, with the uncertainty of level and numerics. model: against W_T with the uncertainty of the
model's unmeasured parameters; made only where the record does not come from the model itself.
"""

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from analysis.results.condition import Result
from analysis.results.recorded_waveform import Recorded
from analysis.results.session_rows import AgreementRow, ComparisonRow, LineRow
from analysis.session.prediction_entry import PredictionEntry
from analysis.session.setting import Setting
from analysis.uncertainty.budget import RESOLUTION, SCATTER, combine, own_parts
from analysis.uncertainty.estimate import Estimate
from analysis.uncertainty.straight_line import Errors, fitted

__all__ = [
    "Fit",
    "ModelColumns",
    "agreement_row",
    "comparisons",
    "energy_ratio",
    "inside_bands",
    "is_mechanism_shared",
    "line_through",
    "model_columns",
    "predictions_named",
    "propagated",
    "recorded_ratio",
]

Array = NDArray[np.float64]

INSIDE = (0.025, 0.975)  # quantiles of a 95 % interval
SEVEN = 0.07  # offset of W_exp from W_T that the paper reports
BOX_LOSSES = ("W_noise", "W_air", "W_gas", "W_mount")  # ledger columns of what is not in the bed

OWN_MECHANISM = {"grains"}  # beds with other physics than the model of W_T

UNLIKELY = 1e-3
"""Probability of a larger chi^2 below which no straight line is stated."""


@dataclass(frozen=True, slots=True)
class Fit:
    """A straight line through W_exp against W_T.

    slope : dimensionless
    intercept : J per cycle
    chi2, dof : chi^2 of the residuals and its degrees of freedom
    """

    slope: Estimate
    intercept: Estimate
    chi2: float
    dof: int

    @property
    def is_likely(self) -> bool:
        """Whether a true line would show a chi^2 as large as this in at least UNLIKELY of all
        cases.
        """
        return self.dof == 0 or float(chdtrc(self.dof, self.chi2)) >= UNLIKELY

    def row(self) -> LineRow:
        """Return the report's entry; where no line is likely, chi^2 alone.

        The uncertainty of such a line would be too small.
        """
        if not self.is_likely:
            return LineRow(None, None, None, None, self.chi2, self.dof)
        slope, intercept = self.slope, self.intercept
        return LineRow(slope.value, slope.U, intercept.value, intercept.U, self.chi2, self.dof)


def energy_ratio(results: Sequence[Result]) -> Estimate | None:
    """Return sum W_exp / sum W_T over the conditions with W_T above 0; None where there is none."""
    predicted = [(r, r.W_T.value) for r in results if r.W_T is not None and r.W_T.value > 0]
    if not predicted:
        return None
    total = math.fsum(w for _, w in predicted)
    ratio = math.fsum(r.W_exp.value for r, _ in predicted) / total
    return propagated(ratio, [(r, 1 / total, -ratio / total) for r, _ in predicted])


def inside_bands(results: Sequence[Result]) -> tuple[str, str, str]:
    """Return found, verdict and reason of a claim about W_exp/W_T where no ratio is known: of bands
    of W_T none is taken.
    """
    bands = [result.inside for result in results if result.inside is not None]
    if not bands:
        return "", "undecided", "no predicted energy to compare with"
    found = f"inside {sum(bands)} of {len(bands)} bands"
    return found, "undecided", "W_T is a band, of which no ratio is taken"


def recorded_ratio(results: Sequence[Result]) -> Estimate | None:
    """Return the same ratio with W_T predicted on the recorded waveforms; None where there is none."""
    predicted = [(r, r.recorded) for r in results if r.recorded is not None]
    predicted = [(r, found) for r, found in predicted if found.W_T.value > 0]
    if not predicted:
        return None
    total = math.fsum(found.W_T.value for _, found in predicted)
    ratio = math.fsum(r.W_exp.value for r, _ in predicted) / total
    return propagated(ratio, [(found, 1 / total, -ratio / total) for _, found in predicted])


def propagated(value: float, weights: Sequence[tuple[Result | Recorded, float, float]]) -> Estimate:
    """Return a number with the uncertainty that follows from its derivatives to W_exp and W_T of
    each condition.

    weights: (condition, derivative to W_exp, derivative to W_T). Budget lines that conditions have
    in common add with their signs; the others add in quadrature. The scatter between a condition's
    runs is that of the weighted combination, run by run.
    """
    shared: dict[str, float] = defaultdict(float)
    nu: dict[str, float] = {}
    parts: list[tuple[float, float]] = []
    for result, d_exp, d_T in weights:
        parts += own_parts(result.lines, result.pairs, d_exp, d_T)
        for line in (line for line in result.lines if line.shared):
            shared[line.source] += d_exp * line.part + d_T * line.part_T
            nu[line.source] = line.nu
    return combine(value, [*parts, *((part, nu[source]) for source, part in shared.items())])


def line_through(results: Sequence[Result], origin: bool = False) -> Fit | None:
    """Return the line through W_exp against W_T of the conditions, with errors in both.

    origin: force the line through the origin. None for fewer than three conditions (two through the
    origin), or where W_T is the same in all.

    The points are weighted with their covariance; the uncertainty is that of the budget, propagated
    through the fit. The scatter is pooled over the conditions as a relative one: four runs are too
    few for a weight of their own. Relative errors of W_exp are taken of the fitted energy and not
    of each W_exp: otherwise points that came out low get more weight, which pulls the slope down
    (Peelle's puzzle; D'Agostini, Nucl. Instrum. Methods A 346, 306 (1994)).
    """
    predicted = [(r, r.W_T.value) for r in results if r.W_T is not None and r.W_T.value > 0]
    if len(predicted) < (2 if origin else 3):
        return None
    x, y = np.array([w for _, w in predicted]), np.array([r.W_exp.value for r, _ in predicted])
    if np.ptp(x) <= RESOLUTION * x.max():
        return None
    try:
        found = fitted(x, y, _errors([r for r, _ in predicted], x, y), origin)
    except (ValueError, ArithmeticError, np.linalg.LinAlgError):
        # The points lie so far from a line that the iteration diverges.
        return None
    rows = list(zip((r for r, _ in predicted), found.to_y, found.offset_to_y, strict=True))
    return Fit(
        propagated(found.slope, [(r, float(d), -found.slope * float(d)) for r, d, _ in rows]),
        propagated(found.intercept, [(r, float(d), -found.slope * float(d)) for r, _, d in rows]),
        found.chi2,
        found.dof,
    )


def _errors(results: Sequence[Result], x: Array, y: Array) -> Errors:
    """Return the errors of W_T (x) and W_exp (y), J, with their common sources."""
    expected = y.sum() / x.sum() * x
    relative = _pooled(results)
    runs = np.array([len(result.runs) for result in results])
    own_x = relative[0, 0] * x * x / runs
    own_y = relative[1, 1] * expected * expected / runs + (RESOLUTION * expected) ** 2
    own_xy = relative[0, 1] * x * expected / runs
    common: dict[str, Array] = defaultdict(lambda: np.zeros((2, x.size)))
    for i, result in enumerate(results):
        for line in result.lines:
            part_x, part_y = line.part_T, line.part * expected[i] / y[i]
            if line.shared:
                common[line.source][:, i] += part_x, part_y
            elif line.source != SCATTER:
                own_x[i] += part_x**2
                own_y[i] += part_y**2
                own_xy[i] += part_x * part_y
    of_x, of_y = np.array(list(common.values())).reshape(-1, 2, x.size).transpose(1, 2, 0)
    return Errors(own_x, own_y, own_xy, of_x, of_y)


def _pooled(results: Sequence[Result]) -> Array:
    """Return the covariance of a run's (W_T, W_exp), (2, 2), relative to their means, pooled over
    conditions.

    Zeros where every condition has a single run.
    """
    total, nu = np.zeros((2, 2)), 0
    for result in results:
        pairs = np.array(result.pairs)[:, ::-1]
        apart = pairs / pairs.mean(axis=0) - 1
        total += apart.T @ apart
        nu += len(pairs) - 1
    return total / nu if nu else total


def agreement_row(results: Sequence[Result]) -> AgreementRow:
    """Return the report's `agreement`: energy-weighted ratio, lines through W_exp against W_T, mean
    offset.
    """
    comparable = [r for r in results if r.comparable]
    ratio = energy_ratio(comparable)
    on_waveform = [
        (r, r.recorded.W_T) for r in results if r.recorded is not None and r.comparable_recorded
    ]
    recorded = recorded_ratio([r for r, _ in on_waveform])
    predicted = [(r, r.W_T) for r in results if r.W_T is not None and r.W_T.value > 0]
    slope = line = None
    if ratio is not None:
        predicted = [(r, W_T) for r, W_T in predicted if r.comparable]
        slope, line = line_through(comparable, origin=True), line_through(comparable)
    known = line or slope  # two conditions have only the line through the origin
    if known is not None and not known.is_likely:
        # W_exp is no linear function of W_T: the stated U of a slope would be too small.
        slope = None
    offsets = (
        [r.W_exp.value / r.W_T.value - 1 for r in comparable if r.W_T is not None]
        if ratio is not None
        else []
    )
    return AgreementRow(
        ratio=ratio.value if ratio else None,
        U_ratio=ratio.U if ratio else None,
        k=ratio.k if ratio else None,
        nu=ratio.nu if ratio else None,
        slope=slope.slope.value if slope else None,
        U_slope=slope.slope.U if slope else None,
        line=line.row() if line else None,
        mean_offset=math.fsum(offsets) / len(offsets) if offsets else None,
        n=len(offsets),
        put_in=_put_in(predicted),
        ratio_recorded=recorded.value if recorded else None,
        U_ratio_recorded=recorded.U if recorded else None,
        put_in_recorded=_put_in(on_waveform),
        bands=sum(result.band is not None for result in results),
        inside=sum(result.inside is True for result in results),
    )


def is_mechanism_shared(seen: Sequence[Setting], entries: Mapping[str, PredictionEntry]) -> bool:
    """Return whether every bed dissipates by the mechanism behind W_T; where the prediction does
    not say, every bed but resolved grains does.
    """
    for setting in seen:
        entry = entries.get(setting.id)
        told = entry.shares_mechanism if entry is not None else None
        if told is False or (told is None and setting.bed in OWN_MECHANISM):
            return False
    return True


def predictions_named(results: Sequence[Result]) -> str | None:
    """Return the names of what W_T is of: of the conditions that dissipate, where any does."""
    known = [result for result in results if result.prediction is not None]
    telling = [r for r in known if r.band is not None or r.predicted.W_T != 0.0]
    names = dict.fromkeys(str(result.prediction) for result in telling or known)
    return ", ".join(names) or None


def _put_in(predicted: Sequence[tuple[Result, Estimate]]) -> float | None:
    """Return the losses that the rig file adds to the bed's, as a fraction of the predicted energy;
    None without truth or W_T.
    """
    total = math.fsum(W_T.value for _, W_T in predicted)
    found = [result.ledger_mean(column) for result, _ in predicted for column in BOX_LOSSES]
    known = [value for value in found if value is not None]
    return math.fsum(known) / total if known and total > 0 else None


@dataclass(frozen=True, slots=True)
class ModelColumns:
    """The columns of a condition for the comparison `model`.

    W_T_low, W_T_high : 95 % interval of W_T over the model's parameters, J
    E_n_model : E_n score with half the width of that interval as U of W_T
    """

    W_T_low: float | None = None
    W_T_high: float | None = None
    E_n_model: float | None = None


def model_columns(result: Result) -> ModelColumns:
    """Return the columns of a condition for the comparison `model`; None in all without draws of
    the parameters.
    """
    if result.W_T is None or result.difference is None or not result.model:
        return ModelColumns()
    low, high = (result.W_T.value * float(q) for q in np.quantile(result.model, INSIDE))
    U = math.hypot(result.difference.U, (high - low) / 2)
    return ModelColumns(low, high, result.difference.value / U if U else None)


def comparisons(results: Sequence[Result]) -> tuple[ComparisonRow, ...]:
    """Return one row for each of the three comparisons.

    A row states what W_exp is compared with, in how many conditions, in how many |E_n| <= 1, and
    why the comparison was not made or what it cannot show.
    """
    scored = [(result, model_columns(result).E_n_model) for result in results]
    model = [(result, E) for result, E in scored if E is not None]
    none = "" if results else "no run states an energy"
    last = _entry(
        "model",
        "W_T with friction, restitution and clearance as uncertain as they are",
        [E for _, E in model],
        none or "the record comes from the model itself, or no spread of W_T was given",
    )
    return (
        _entry(
            "chain",
            "the rig's own ledger",
            _scores([r.chain for r in results]),
            none or "the record holds no truth",
        ),
        _entry(
            "prediction",
            "W_T as predicted",
            [
                *_scores([r.difference for r in results if r.comparable]),
                *(0.0 if r.inside else math.inf for r in results if r.inside is not None),
            ],
            none or "nothing is predicted that stands out of the detection limit",
        ),
        replace(last, why=_telling([result for result, _ in model])) if model else last,
    )


def _scores(differences: Sequence[Estimate | None]) -> list[float]:
    """Return the E_n scores of differences; those without uncertainty are left out."""
    return [d.value / d.U for d in differences if d is not None and d.U]


def _entry(name: str, against: str, scores: Sequence[float], why: str) -> ComparisonRow:
    """Return the row of a comparison with its scores; why: the reason where there are none."""
    return ComparisonRow(
        comparison=name, against=against, n=len(scores), within=sum(abs(E) <= 1 for E in scores),
        why="" if scores else f"not made: {why}",
    )  # fmt: skip


def _telling(results: Sequence[Result]) -> str:
    """Return in words the smallest offset that the comparison `model` could detect.

    A draw of the parameters is the same in all conditions, so that their energies are summed draw
    by draw.
    """
    W_T = np.array([result.W_T.value for result in results if result.W_T is not None])
    total = W_T @ np.array([result.model for result in results]) / W_T.sum()
    low, high = (float(q) - 1 for q in np.quantile(total, INSIDE))
    text = f"unmeasured parameters change W_T by {100 * low:+.0f} % to {100 * high:+.0f} % (95 %)"
    if (high - low) / 2 > SEVEN:
        return f"{text}: 7 % cannot test this model without measured friction"
    return text
