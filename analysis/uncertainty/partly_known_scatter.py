"""A linear law fitted to runs whose scatter is only partly known.

The instruments' noise is known from their sheets. What comes to it is not: a scatter that grows
with the level, with the energy itself, or between the two, of a size that a handful of residuals
tell poorly. Taking weights from the residuals and then believing them makes u too small. So the
unknown law is integrated out: every shape and size of the further variance counts as much as the
residuals bear it out (their restricted likelihood; Harville, J. Am. Stat. Assoc. 72, 320 (1977)),
under Jeffreys' prior of a variance added to known ones. Where noise explains the residuals, few
runs do; where they tell of nothing but themselves it is Student's t.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.uncertainty.estimate import LEVEL, UNBOUNDED, Estimate, coverage_factor

__all__ = ["coefficient"]

Array = NDArray[np.float64]

BELOW, ABOVE = 0.03, 1e6
"""Sizes of the further variance, from this fraction of the known to so many squared residuals: the
restricted likelihood of one degree of freedom leaves 0.1 % beyond."""
STEP = 0.35  # of ln(variance): a residual variance of 10 degrees of freedom is known to 0.45
POINTS = 60  # of the finer grid, where the likelihood is narrower
HALVED = 1e-12  # of the interval's half-width: how well it is found
NEGLIGIBLE = 14.0  # of ln(weight) below the highest


def coefficient(
    design: Array, values: Array, known: Array, shapes: Sequence[Array], which: int
) -> Estimate:
    """Return coefficient `which` of values = design @ coefficients.

    design: (runs, unknowns), of full rank, more runs than unknowns; known: (runs,) variances of
    `values`; shapes: (runs,) each, what a further variance may grow like, all of the same mean.
    """
    scale = np.sqrt(known + shapes[0] * float((known / shapes[0]).mean()))
    base, triangle = np.linalg.qr(design / scale[:, None])
    start = base.T @ (values / scale)
    base, load = base * scale[:, None], np.linalg.solve(triangle.T, np.eye(len(triangle))[which])
    residual = values - base @ start
    smallest = BELOW * min(float((known / shape).min()) for shape in shapes)
    squares = np.maximum(known, residual**2)
    largest = ABOVE * max(float((squares / shape).max()) for shape in shapes)
    count = max(POINTS, math.ceil(math.log(largest / smallest) / STEP))
    sizes = np.linspace(math.log(smallest), math.log(largest), count)
    log_weight, mean, variance = _under(sizes, base, residual, known, shapes, load)
    heavy = np.flatnonzero((log_weight > log_weight.max() - NEGLIGIBLE).any(axis=0))
    if len(heavy) < POINTS // 2:
        ends = sizes[max(heavy[0] - 1, 0)], sizes[min(heavy[-1] + 1, count - 1)]
        sizes = np.linspace(*ends, POINTS)
        log_weight, mean, variance = _under(sizes, base, residual, known, shapes, load)
    weight = np.exp(log_weight - log_weight.max())
    return _as_student(float(load @ start), weight.ravel(), mean.ravel(), variance.ravel())


def _under(
    sizes: Array, base: Array, residual: Array, known: Array, shapes: Sequence[Array], load: Array
) -> tuple[Array, Array, Array]:
    """Of every (shape, ln size) of the further variance: ln of its weight, and the coefficient's
    mean (beside the start's) and variance under it."""
    runs, unknowns = base.shape
    products = (base[:, :, None] * base[:, None, :]).reshape(runs, -1)
    found = []
    for shape in shapes:
        weight = 1 / (known + np.exp(sizes)[:, None] * shape)
        normal = (weight @ products).reshape(-1, unknowns, unknowns)
        right = weight @ (base * residual[:, None])
        covariance = np.linalg.inv(normal)
        solution = np.einsum("gij,gj->gi", covariance, right)
        left = weight @ residual**2 - np.einsum("gi,gi->g", solution, right)
        likelihood = 0.5 * (np.log(weight).sum(axis=1) - np.linalg.slogdet(normal)[1] - left)
        jeffreys = 0.5 * np.log(((shape * weight) ** 2).sum(axis=1)) + sizes  # of ln(size)
        spread = np.einsum("i,gij,j->g", load, covariance, load)
        found.append((likelihood + jeffreys, solution @ load, spread))
    log_weight, mean, variance = (np.stack(each) for each in zip(*found, strict=True))
    return log_weight, mean, variance


def _as_student(start: float, weight: Array, mean: Array, variance: Array) -> Estimate:
    """Return a mixture of normals as an Estimate: its mean and 95 % interval, and the degrees of
    freedom from how far the mixture leaves 1/variance open (2/nu, relative, for Student's t)."""
    from scipy.special import ndtr

    weight = weight / weight.sum()
    kept = weight > 1e-9
    weight, mean, spread = weight[kept] / weight[kept].sum(), mean[kept], np.sqrt(variance[kept])
    center = float(weight @ mean)
    precision = float(weight @ spread**-2)
    openness = float(weight @ (spread**-2 / precision - 1) ** 2)
    nu = 2 / openness if openness > 2 / UNBOUNDED else math.inf

    def inside(half: float) -> float:
        return float(
            weight
            @ (ndtr((half - mean + center) / spread) - ndtr((-half - mean + center) / spread))
        )

    # halved, not scipy.optimize's root: importing that takes longer than all other numbers of a
    # report
    least, most = 0.0, 2 * float(np.max(np.abs(mean - center) + 2 * spread))
    while most - least > HALVED * most:
        half = (least + most) / 2
        least, most = (half, most) if inside(half) < LEVEL else (least, half)
    return Estimate(start + center, most / coverage_factor(nu), nu)
