"""Numbers taken over several conditions: errors that are common to all of them stay common."""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from analysis.results.agreement_row import LineRow
from analysis.results.condition import Result
from analysis.results.predicted_on_record import Recorded
from analysis.uncertainty.budget import RESOLUTION, SCATTER, combine, own_parts
from analysis.uncertainty.estimate import Estimate
from analysis.uncertainty.straight_line import Errors, fitted

__all__ = ["Fit", "energy_ratio", "line_through", "propagated", "recorded_ratio"]

Array = NDArray[np.float64]

UNLIKELY = 1e-3
"""Probability of a chi^2 below which no straight line is stated."""


@dataclass(frozen=True, slots=True)
class Fit:
    """Straight line through W_exp against W_T. slope: 1; intercept: J per cycle; chi2 of dof
    degrees of freedom.
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
        """Return the report's entry; where no line is likely, chi^2 alone: its numbers would state
        a U they lack.
        """
        if not self.is_likely:
            return LineRow(None, None, None, None, self.chi2, self.dof)
        slope, intercept = self.slope, self.intercept
        return LineRow(slope.value, slope.U, intercept.value, intercept.U, self.chi2, self.dof)


def energy_ratio(results: Sequence[Result]) -> Estimate | None:
    """Sum of W_exp over sum of W_T of the conditions with a W_T above 0; None where there is none."""
    told = [(r, r.W_T.value) for r in results if r.W_T is not None and r.W_T.value > 0]
    if not told:
        return None
    total = math.fsum(w for _, w in told)
    ratio = math.fsum(r.W_exp.value for r, _ in told) / total
    return propagated(ratio, [(r, 1 / total, -ratio / total) for r, _ in told])


def recorded_ratio(results: Sequence[Result]) -> Estimate | None:
    """As energy_ratio, with the predictions on the recorded waveforms; None where there are none."""
    told = [(r, r.recorded) for r in results if r.recorded is not None and r.recorded.W_T.value > 0]
    if not told:
        return None
    total = math.fsum(found.W_T.value for _, found in told)
    ratio = math.fsum(r.W_exp.value for r, _ in told) / total
    return propagated(ratio, [(found, 1 / total, -ratio / total) for _, found in told])


def propagated(value: float, weights: Sequence[tuple[Result | Recorded, float, float]]) -> Estimate:
    """Uncertainty of a number with derivatives (to W_exp, to W_T) for each condition.

    Lines of a source that is shared between conditions add with their signs; the others add in
    quadrature, and so does the scatter between a condition's runs, of the very combination that is
    asked for.
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
    """Line through W_exp against W_T of conditions, errors in both, common calibration kept common;
    through the origin where asked for. None for fewer than two conditions (and a point more than
    parameters), or one W_T in all of them.

    The covariance weighs the points; the uncertainty is that of the budget, propagated through the
    fit. Scatter is pooled over the conditions as a relative one: a weight from four runs of its own
    would be noise. Parts of W_exp are taken at the ratio of the energies and not at each W_exp,
    which would give points that came out low more weight and pull the slope down (Peelle's puzzle;
    D'Agostini, Nucl. Instrum. Methods A 346, 306 (1994)).
    """
    told = [(r, r.W_T.value) for r in results if r.W_T is not None and r.W_T.value > 0]
    if len(told) < (2 if origin else 3):
        return None
    x, y = np.array([w for _, w in told]), np.array([r.W_exp.value for r, _ in told])
    if np.ptp(x) <= RESOLUTION * x.max():
        return None
    try:
        found = fitted(x, y, _errors([r for r, _ in told], x, y), origin)
    except (
        ValueError,
        ArithmeticError,
        np.linalg.LinAlgError,
    ):  # points so far from a line that the search runs away
        return None
    rows = list(zip((r for r, _ in told), found.to_y, found.offset_to_y, strict=True))
    return Fit(
        propagated(found.slope, [(r, float(d), -found.slope * float(d)) for r, d, _ in rows]),
        propagated(found.intercept, [(r, float(d), -found.slope * float(d)) for r, _, d in rows]),
        found.chi2,
        found.dof,
    )


def _errors(results: Sequence[Result], x: Array, y: Array) -> Errors:
    """Errors of the W_T (x) and of the W_exp (y); J."""
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
    """Covariance of a run's (W_T, W_exp), relative to their means, pooled over conditions; zeros
    for single runs.
    """
    total, nu = np.zeros((2, 2)), 0
    for result in results:
        pairs = np.array(result.pairs)[:, ::-1]
        apart = pairs / pairs.mean(axis=0) - 1
        total += apart.T @ apart
        nu += len(pairs) - 1
    return total / nu if nu else total
