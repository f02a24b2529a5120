"""Lines with errors in both axes: published data, the likelihood itself, and what a common
calibration does.
"""

import math
import tracemalloc

import mpmath
import numpy as np
import pytest
from claim_data import result
from scipy import optimize, stats

from analysis.comparison.pooled_results import line_through
from analysis.uncertainty.straight_line import Errors, fitted

PEARSON = (
    np.array([0.0, 0.9, 1.8, 2.6, 3.3, 4.4, 5.2, 6.1, 6.5, 7.4]),
    np.array([5.9, 5.4, 4.4, 4.6, 3.5, 3.7, 2.8, 2.8, 2.4, 1.5]),
)
YORK = (
    np.array([1000, 1000, 500, 800, 200, 80, 60, 20, 1.8, 1.0]),
    np.array([1, 1.8, 4, 8, 20, 20, 70, 70, 100, 500.0]),
)


def independent(of_x, of_y):
    """Errors of points that have nothing in common."""
    return Errors(of_x, of_y, 0 * of_x, *np.zeros((2, len(of_x), 0)))


def test_pearson_s_data_with_york_s_weights():
    """York et al., Am. J. Phys. 72, 367 (2004), table II: slope and intercept to their nine digits."""
    x, y = PEARSON
    found = fitted(x, y, independent(1 / YORK[0], 1 / YORK[1]))
    assert found.slope == pytest.approx(-0.480533407, abs=1e-9)
    assert found.intercept == pytest.approx(5.47991022, abs=1e-8)
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx(
        [0.0579850090, 0.294970735], rel=1e-5
    )
    assert found.chi2 == pytest.approx(11.8663531941, rel=1e-9)
    assert found.dof == 8


def positive(rng, n):
    """A covariance matrix with correlations of every sign."""
    root = rng.standard_normal((n, n))
    return 0.02 * (root @ root.T / n + 0.3 * np.eye(n))


def as_sources(V):
    """Errors with the joint covariance V, (2m, 2m): half of its least eigenvalue is each
    coordinate's own.
    """
    m = len(V) // 2
    own = np.full(m, np.linalg.eigvalsh(V)[0] / 2)
    common = np.linalg.cholesky(V - own[0] * np.eye(2 * m))
    return Errors(own, own, 0 * own, common[:m], common[m:])


@pytest.mark.parametrize("origin", [False, True])
def test_the_line_is_the_most_likely_one(origin):
    """Full covariance of all x and y: against a minimiser over the slope, the intercept and every
    true x.
    """
    rng = np.random.default_rng(5)
    m = 6
    V = positive(rng, 2 * m)
    true = np.linspace(1, 4, m)
    x, y = np.split(
        np.concatenate([true, 1.3 * true]) + np.linalg.cholesky(V) @ rng.standard_normal(2 * m), 2
    )
    found = fitted(x, y, as_sources(V), origin)
    root = np.linalg.cholesky(np.linalg.inv(V)).T

    def apart(q):
        slope, intercept, at = q[0], 0.0 if origin else q[1], q[2:]
        return root @ np.concatenate([x - at, y - slope * at - intercept])

    best = optimize.least_squares(apart, [1.0, 0.0, *x], xtol=1e-14, ftol=1e-14, gtol=1e-14)
    # a minimum found from its value is good to the root of rounding, 1e-8, times the curvature of
    # this one
    assert found.slope == pytest.approx(best.x[0], abs=1e-6)
    assert found.intercept == pytest.approx(0.0 if origin else best.x[1], abs=1e-6)
    assert found.chi2 == pytest.approx(2 * best.cost, rel=1e-9)


def test_derivatives_are_those_of_the_fit():
    """`to_y` against a finite change of one y, for errors small against the spread of the points
    (first order).
    """
    rng = np.random.default_rng(6)
    x = np.linspace(1, 4, 5)
    y = 1.1 * x + 0.2 + 1e-4 * rng.standard_normal(5)
    errors = independent(*np.full((2, 5), 1e-8))
    base, h = fitted(x, y, errors), 1e-5
    for i in range(5):
        moved = fitted(x, y + h * np.eye(5)[i], errors)
        # second order: residual over spread, 1e-4
        assert (moved.slope - base.slope) / h == pytest.approx(base.to_y[i], abs=1e-3)
        assert (moved.intercept - base.intercept) / h == pytest.approx(
            base.offset_to_y[i], abs=1e-3
        )


def test_too_few_points_and_no_covariance():
    one = np.ones(1)
    with pytest.raises(ValueError, match="1 points do not determine"):
        fitted(one, one, independent(one, one))
    with pytest.raises(ValueError, match="not positive definite"):
        fitted(*PEARSON, independent(*np.zeros((2, 10))))


def with_matrices(x, y, errors, origin):
    """Slope, intercept and chi2 of the same line from the full covariance, inverted with 40 digits."""
    exact = mpmath.mp.clone()
    exact.dps = 40
    m = len(x)
    X, Y = exact.matrix(x), exact.matrix(y)
    C_x, C_y = exact.matrix(errors.common_x), exact.matrix(errors.common_y)
    V_x, V_y, V_xy = (
        exact.diag([exact.mpf(float(v)) for v in own]) + one * other.T
        for own, one, other in (
            (errors.own_x, C_x, C_x),
            (errors.own_y, C_y, C_y),
            (errors.own_xy, C_x, C_y),
        )
    )
    ones = exact.matrix([1] * m)
    slope, intercept = exact.mpf(fitted(x, y, errors, origin).slope), exact.mpf(0)
    for _ in range(4):  # from 12 digits on, a few more each
        weight = exact.inverse(V_y - slope * (V_xy + V_xy.T) + slope**2 * V_x)
        if not origin:
            intercept = (ones.T * weight * (Y - slope * X))[0] / (ones.T * weight * ones)[0]
        residual = Y - slope * X - intercept * ones
        at = X - (V_xy - slope * V_x) * weight * residual
        design = at if origin else exact.matrix([[at[i], 1] for i in range(m)])
        covariance = exact.inverse(design.T * weight * design)
        slope += (covariance * design.T * weight * residual)[0]
    return [
        float(v) for v in (slope, intercept, (residual.T * weight * residual)[0], covariance[0, 0])
    ]


@pytest.mark.parametrize("origin", [False, True])
def test_low_rank_is_the_full_covariance(origin):
    """An error in common of 3 % beside own ones of 0.01 to 1 %, as instruments make them: the parts
    in common are up to 300 times a point's own, which costs an inverse half of its digits (1e5 in
    the covariance) and this form none."""
    rng = np.random.default_rng(9)
    m, r = 8, 3
    x = np.geomspace(1e-3, 1.0, m)
    own = 10 ** rng.uniform(-4, -2, m)
    common = 0.03 * rng.standard_normal((m, r))
    y = 1.07 * x * (1 + common @ rng.standard_normal(r) + own * rng.standard_normal(m))
    errors = Errors(
        (0.3 * own * x) ** 2, (own * y) ** 2, 0.1 * own**2 * x * y,
        x[:, None] * (common + 0.01), y[:, None] * common,
    )  # fmt: skip
    found = fitted(x, y, errors, origin)
    slope, intercept, chi2, variance = with_matrices(x, y, errors, origin)
    # chi2 and the variance follow the slope, which the search leaves within 1e-12 of itself
    assert found.slope == pytest.approx(slope, rel=1e-12)
    assert found.intercept == pytest.approx(intercept, rel=1e-10, abs=1e-12 * x.mean())
    assert found.chi2 == pytest.approx(chi2, rel=1e-10)
    assert found.covariance[0, 0] == pytest.approx(variance, rel=1e-10)


def test_memory_of_a_line_grows_as_its_points():
    """Twice the points, twice the peak: a matrix of points by points would be 32 MB for 2000, and
    four times that.
    """
    rng = np.random.default_rng(3)
    peaks = []
    for m in (1000, 2000):
        x, common = np.geomspace(1e-3, 1.0, m), 0.03 * rng.standard_normal((m, 12))
        y = 1.07 * x * (1 + common @ rng.standard_normal(12) / 12)
        errors = Errors(
            (1e-3 * x) ** 2, (1e-3 * x) ** 2, 0 * x, x[:, None] * common, y[:, None] * common
        )
        tracemalloc.start()
        fitted(x, y, errors)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < 2.2 * peaks[0]  # a tenth for what does not hang on the points


def test_lines_through_conditions_cover_the_true_slope():
    """400 sessions of six conditions, a calibration of 3 % common to all and refills that scatter
    by 5 %: the intervals of slope and intercept hold the truth in 95 %, within the 99.9 % binomial
    band, and the slope is not pulled down."""
    rng = np.random.default_rng(12)
    W_T = np.geomspace(0.01, 1.0, 6)
    hit, slopes, count = np.zeros(3), [], 400
    for _ in range(count):
        factor = 1.07 * (1 + 0.03 * rng.standard_normal())
        rows = [
            result(w * factor * (1 + 0.05 * rng.standard_normal(4)), W_T=float(w), scale=0.03)
            for w in W_T
        ]
        through, line = line_through(rows, origin=True), line_through(rows)
        slopes.append(through.slope.value)
        hit += (
            abs(through.slope.value - 1.07) <= through.slope.U,
            abs(line.slope.value - 1.07) <= line.slope.U,
            abs(line.intercept.value) <= line.intercept.U,
        )
    low, high = stats.binom.ppf([0.0005, 0.9995], count, 0.95)
    assert ((low <= hit) & (hit <= high)).all(), hit
    # the mean of 400 slopes, each uncertain by the root of 3 %^2 + 5 %^2/24: four of its own
    # standard deviations
    assert np.mean(slopes) == pytest.approx(
        1.07, abs=4 * 1.07 * math.hypot(0.03, 0.05 / math.sqrt(24)) / math.sqrt(count)
    )


def test_no_line_through_one_prediction():
    rows = [result([1.0, 1.1], W_T=1.0), result([1.2, 1.1], W_T=1.0), result([1.2, 1.1], W_T=1.0)]
    assert line_through(rows) is None
    assert line_through(rows[:1], origin=True) is None
