"""A straight line through points with errors in both coordinates, any of them correlated.

Generalised least squares, the problem of ISO/TS 28037:2010 clause 10; for independent points it is
York's (Am. J. Phys. 72, 367 (2004)). scipy.odr is deprecated, and ODRPACK takes no covariance
between points, which instruments common to all conditions cause. That covariance has low rank, so
that no matrix of points by points is ever formed: time and memory grow with the number of points.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Errors", "StraightLine", "fitted"]

Array = NDArray[np.float64]

STEPS = 200  # most Gauss-Newton steps
ENOUGH = 1e-12  # relative change of the slope at which the iteration has converged
ROUNDED = 1e-6
"""Relative change of the slope below which a step that is no smaller than the last one is round-off (of
the inverses), and ends the iteration too."""


@dataclass(frozen=True, eq=False)
class Errors:
    """Errors of m points: each point's own, and those that r common sources make in all of them.

    own_x, own_y, own_xy : variances of x and of y and their covariance, (m,)
    common_x, common_y : change of x and of y per standard deviation of each source, (m, r)
    """

    own_x: Array
    own_y: Array
    own_xy: Array
    common_x: Array
    common_y: Array

    def x_with(self, slope: float, dual: Array) -> Array:
        """Return the covariance of x with y - slope x, (m, m), times `dual`, (m,)."""
        common = self.common_x @ ((self.common_y - slope * self.common_x).T @ dual)
        return np.asarray((self.own_xy - slope * self.own_x) * dual + common)


class Weight:
    """The inverse of the covariance of y - slope x.

    That covariance is R (1 + B B^T) R with R diagonal and B of low rank; with the singular values s
    of B and its left vectors Q the inverse is R^-1 (1 - Q Q^T + Q (1 + s^2)^-1 Q^T) R^-1
    (Woodbury's, in the form that does not cancel: an error in common can be hundreds of times a
    point's own).
    """

    def __init__(self, errors: Errors, slope: float) -> None:
        """Factor the inverse for the errors of the points and a slope."""
        variance = errors.own_y - 2 * slope * errors.own_xy + slope**2 * errors.own_x
        if not np.all(variance > 0):
            raise ValueError(
                "a point has no error of its own: the covariance is not positive definite"
            )
        self._root = np.sqrt(variance)[:, None]
        common = (errors.common_y - slope * errors.common_x) / self._root
        self._Q, s, _ = np.linalg.svd(common, full_matrices=False)
        self._shrink = 1 / np.sqrt(1 + s**2)[:, None]

    def whitened(self, columns: Array) -> Array:
        """Return columns, (m, n), as (m + r, n), such that scalar products of the results contain
        the inverse.
        """
        scaled = columns / self._root
        along = self._Q.T @ scaled
        return np.concatenate([scaled - self._Q @ along, self._shrink * along])

    def dual(self, whitened: Array) -> Array:
        """Return the inverse times columns, (m, n), from the result of `whitened` for these
        columns.
        """
        m = len(self._root)
        apart = whitened[:m]
        return np.asarray((apart + self._Q @ (self._shrink * whitened[m:])) / self._root)


@dataclass(frozen=True, eq=False)
class StraightLine:
    """The line y = slope x + intercept.

    intercept : 0 for a line forced through the origin
    covariance : of (slope, intercept), or of the slope alone (1, 1)
    to_y : derivatives of the slope with respect to each y; those with respect to each x are -slope
        times them
    offset_to_y : the same of the intercept (zeros through the origin)
    chi2 : sum of squares weighted with the inverse covariance
    dof : its degrees of freedom where the line is true
    """

    slope: float
    intercept: float
    covariance: Array
    to_y: Array
    offset_to_y: Array
    chi2: float
    dof: int


def fitted(x: Array, y: Array, errors: Errors, origin: bool = False) -> StraightLine:
    """Return the line through points x, y, (m,).

    origin: force it through the origin. ValueError for fewer points than the line has parameters,
    or a point without an error of its own.
    """
    m, count = len(x), 1 if origin else 2
    if m < count:
        raise ValueError(f"{m} points do not determine a line with {count} parameters")
    slope, intercept = float(y @ x / (x @ x)) if origin else float(np.polyfit(x, y, 1)[0]), 0.0
    last = math.inf
    ones = np.ones((m, 1))
    for _ in range(STEPS):
        weight = Weight(errors, slope)
        rest = weight.whitened((y - slope * x)[:, None])
        level = weight.whitened(ones)
        if not origin:
            # the best intercept for this slope
            intercept = float((level.T @ rest).item() / (level.T @ level).item())
            rest -= intercept * level
        # x corrected by its expected error, given the residual: the nearest point of the line
        at = x - errors.x_with(slope, weight.dual(rest)[:, 0])
        on_line = weight.whitened(at[:, None])
        design = on_line if origin else np.hstack([on_line, level])
        covariance = np.asarray(np.linalg.inv(design.T @ design), dtype=np.float64)
        to_y = covariance @ weight.dual(design).T
        change = float((covariance[:1] @ (design.T @ rest)).item())
        slope += change
        if abs(change) <= ENOUGH * abs(slope) or last <= abs(change) <= ROUNDED * abs(slope):
            break
        last = abs(change)
    return StraightLine(
        slope=slope,
        intercept=intercept,
        covariance=covariance,
        to_y=to_y[0],
        offset_to_y=np.zeros(m) if origin else to_y[1],
        chi2=float((rest.T @ rest).item()),
        dof=m - count,
    )
