"""Straight line through points with errors in both coordinates, any of them correlated.

Generalised least squares with a full covariance matrix, the problem of ISO/TS 28037:2010 clause 10; for points that are
independent of each other it is York's (Am. J. Phys. 72, 367 (2004)). scipy.odr is deprecated, and ODRPACK takes no
covariance between points, which is what instruments that all conditions share make.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["StraightLine", "fitted"]

Array = NDArray[np.float64]

STEPS = 200
ENOUGH = 1e-12  # relative change of the slope at which a step ends the search
ROUNDED = 1e-6  # below it a change that is no smaller than the last one is round-off (of the inverses), and ends it too


@dataclass(frozen=True, eq=False)
class StraightLine:
    """y = slope x + intercept. intercept: 0 where the line is led through the origin.

    covariance: of (slope, intercept), or of the slope alone (1, 1). to_y: derivatives of the slope with respect to
    each y, those with respect to each x are -slope times them; offset_to_y: the same of the intercept (zeros through
    the origin). chi2: sum of squares weighted with the covariance, of dof degrees of freedom where the line is true.
    """

    slope: float
    intercept: float
    covariance: Array
    to_y: Array
    offset_to_y: Array
    chi2: float
    dof: int


def fitted(x: Array, y: Array, V_x: Array, V_y: Array, V_xy: Array, origin: bool = False) -> StraightLine:
    """The line through points x, y, (m,), with covariances V_x of the x, V_y of the y and V_xy of x (rows) with y.

    origin: lead it through the origin. ValueError for fewer points than the line has parameters, or a covariance of
    y - slope x that is not positive definite.
    """
    m, count = len(x), 1 if origin else 2
    if m < count:
        raise ValueError(f"{m} points do not tell a line with {count} parameters")
    slope, intercept = float(y @ x / (x @ x)) if origin else float(np.polyfit(x, y, 1)[0]), 0.0
    last = math.inf
    for _ in range(STEPS):
        # of y - slope x, and how much of that residual is x's own error: x less that is where the point lies
        V = V_y - slope * (V_xy + V_xy.T) + slope**2 * V_x
        weight = _inverse(V)
        if not origin:  # the intercept that belongs to this slope
            ones = weight.sum(axis=0)
            intercept = float(ones @ (y - slope * x) / ones.sum())
        residual = y - slope * x - intercept
        at = x - (V_xy - slope * V_x) @ weight @ residual
        design = at[:, None] if origin else np.stack([at, np.ones(m)], axis=1)
        covariance = np.asarray(np.linalg.inv(design.T @ weight @ design), dtype=np.float64)
        to_y = covariance @ design.T @ weight
        change = float(to_y[0] @ residual)
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
        chi2=float(residual @ weight @ residual),
        dof=m - count,
    )


def _inverse(V: Array) -> Array:
    try:
        np.linalg.cholesky(V)
    except np.linalg.LinAlgError as error:
        raise ValueError("the covariance of the points is not positive definite") from error
    return np.asarray(np.linalg.inv(V))
