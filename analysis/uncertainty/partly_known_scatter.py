"""Linear regression of runs whose scatter is only partly known.

The instruments' noise is known from their data sheets. The further scatter is not: it may grow with
the level, with the energy, or in between, and a handful of residuals determines its size poorly.
Weights taken from the residuals and then treated as known make u too small. So the unknown law is
integrated out: every shape and size of the further variance is weighted with its restricted
likelihood (Harville, J. Am. Stat. Assoc. 72, 320 (1977)), under Jeffreys' prior of a variance added
to known ones. Where noise explains the residuals, a few runs suffice; where only the residuals say
anything, the result is Student's t.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.uncertainty.estimate import LEVEL, UNBOUNDED, Estimate, coverage_factor

__all__ = ["coefficient"]

Array = NDArray[np.float64]

BELOW, ABOVE = 0.03, 1e6
"""Range of sizes of the further variance: from this fraction of the known one to this multiple of
the squared residuals. The restricted likelihood of one degree of freedom has 0.1 % beyond it.
"""
STEP = 0.35  # grid of ln(variance): a residual variance of 10 degrees of freedom is known to 0.45
POINTS = 60  # of the finer grid for a narrower likelihood
HALVED = 1e-12  # relative tolerance of the interval's half-width
NEGLIGIBLE = 14.0  # ln(weight) below the highest at which a grid point no longer counts


def coefficient(
    design: Array, values: Array, known: Array, shapes: Sequence[Array], which: int
) -> Estimate:
    """Return coefficient `which` of values = design @ coefficients.

    design: (runs, unknowns), of full rank, more runs than unknowns; known: (runs,) variances of
    `values`; shapes: (runs,) each, proportions in which a further variance may grow, all with the
    same mean.
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
    """Return ln of the weight of every (shape, ln size) of the further variance, and under it the
    coefficient's mean and variance.

    The mean is relative to that of the starting solution.
    """
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
    """Return a mixture of normals as an Estimate: its mean and 95 % interval.

    The degrees of freedom follow from the relative variance of 1/variance over the mixture: 2/nu
    for Student's t.
    """
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

    # Bisection, not scipy.optimize: importing that takes longer than computing the whole report.
    least, most = 0.0, 2 * float(np.max(np.abs(mean - center) + 2 * spread))
    while most - least > HALVED * most:
        half = (least + most) / 2
        least, most = (half, most) if inside(half) < LEVEL else (least, half)
    return Estimate(start + center, most / coverage_factor(nu), nu)
