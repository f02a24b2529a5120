"""Lines with errors in both axes: published data, the likelihood itself, and what a common calibration does."""

import math

import numpy as np
import pytest
from claim_data import result
from scipy import optimize, stats

from analysis.ratio import line_through
from analysis.straight_line import fitted

PEARSON = (
    np.array([0.0, 0.9, 1.8, 2.6, 3.3, 4.4, 5.2, 6.1, 6.5, 7.4]),
    np.array([5.9, 5.4, 4.4, 4.6, 3.5, 3.7, 2.8, 2.8, 2.4, 1.5]),
)
YORK = np.array([1000, 1000, 500, 800, 200, 80, 60, 20, 1.8, 1.0]), np.array([1, 1.8, 4, 8, 20, 20, 70, 70, 100, 500.0])


def test_pearson_s_data_with_york_s_weights():
    """York et al., Am. J. Phys. 72, 367 (2004), table II: slope and intercept to their nine digits."""
    x, y = PEARSON
    found = fitted(x, y, np.diag(1 / YORK[0]), np.diag(1 / YORK[1]), np.zeros((10, 10)))
    assert found.slope == pytest.approx(-0.480533407, abs=1e-9)
    assert found.intercept == pytest.approx(5.47991022, abs=1e-8)
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx([0.0579850090, 0.294970735], rel=1e-5)
    assert found.chi2 == pytest.approx(11.8663531941, rel=1e-9)
    assert found.dof == 8


def positive(rng, n):
    """A covariance matrix with correlations of every sign."""
    root = rng.standard_normal((n, n))
    return 0.02 * (root @ root.T / n + 0.3 * np.eye(n))


@pytest.mark.parametrize("origin", [False, True])
def test_the_line_is_the_most_likely_one(origin):
    """Full covariance of all x and y: against a minimiser over the slope, the intercept and every true x."""
    rng = np.random.default_rng(5)
    m = 6
    V = positive(rng, 2 * m)
    true = np.linspace(1, 4, m)
    x, y = np.split(np.concatenate([true, 1.3 * true]) + np.linalg.cholesky(V) @ rng.standard_normal(2 * m), 2)
    found = fitted(x, y, V[:m, :m], V[m:, m:], V[:m, m:], origin)
    root = np.linalg.cholesky(np.linalg.inv(V)).T

    def apart(q):
        slope, intercept, at = q[0], 0.0 if origin else q[1], q[2:]
        return root @ np.concatenate([x - at, y - slope * at - intercept])

    best = optimize.least_squares(apart, [1.0, 0.0, *x], xtol=1e-14, ftol=1e-14, gtol=1e-14)
    # a minimum found from its value is good to the root of rounding, 1e-8, times the curvature of this one
    assert found.slope == pytest.approx(best.x[0], abs=1e-6)
    assert found.intercept == pytest.approx(0.0 if origin else best.x[1], abs=1e-6)
    assert found.chi2 == pytest.approx(2 * best.cost, rel=1e-9)


def test_derivatives_are_those_of_the_fit():
    """`to_y` against a finite change of one y, for errors small against the spread of the points (first order)."""
    rng = np.random.default_rng(6)
    x = np.linspace(1, 4, 5)
    y = 1.1 * x + 0.2 + 1e-4 * rng.standard_normal(5)
    V = 1e-8 * np.eye(5)
    base, h = fitted(x, y, V, V, 0 * V), 1e-5
    for i in range(5):
        moved = fitted(x, y + h * np.eye(5)[i], V, V, 0 * V)
        # second order: residual over spread, 1e-4
        assert (moved.slope - base.slope) / h == pytest.approx(base.to_y[i], abs=1e-3)
        assert (moved.intercept - base.intercept) / h == pytest.approx(base.offset_to_y[i], abs=1e-3)


def test_too_few_points_and_no_covariance():
    one = np.ones(1)
    with pytest.raises(ValueError, match="1 points do not tell"):
        fitted(one, one, np.eye(1), np.eye(1), np.zeros((1, 1)))
    with pytest.raises(ValueError, match="not positive definite"):
        fitted(PEARSON[0], PEARSON[1], *np.zeros((3, 10, 10)))


def test_lines_through_conditions_cover_the_true_slope():
    """400 sessions of six conditions, a calibration of 3 % common to all and refills that scatter by 5 %: the intervals
    of slope and intercept hold the truth in 95 %, within the 99.9 % binomial band, and the slope is not pulled down."""
    rng = np.random.default_rng(12)
    W_T = np.geomspace(0.01, 1.0, 6)
    hit, slopes, count = np.zeros(3), [], 400
    for _ in range(count):
        factor = 1.07 * (1 + 0.03 * rng.standard_normal())
        rows = [result(w * factor * (1 + 0.05 * rng.standard_normal(4)), W_T=float(w), scale=0.03) for w in W_T]
        through, line = line_through(rows, origin=True), line_through(rows)
        slopes.append(through.slope.value)
        hit += (
            abs(through.slope.value - 1.07) <= through.slope.U,
            abs(line.slope.value - 1.07) <= line.slope.U,
            abs(line.intercept.value) <= line.intercept.U,
        )
    low, high = stats.binom.ppf([0.0005, 0.9995], count, 0.95)
    assert ((low <= hit) & (hit <= high)).all(), hit
    # the mean of 400 slopes, each uncertain by the root of 3 %^2 + 5 %^2/24: four of its own standard deviations
    assert np.mean(slopes) == pytest.approx(
        1.07, abs=4 * 1.07 * math.hypot(0.03, 0.05 / math.sqrt(24)) / math.sqrt(count)
    )


def test_no_line_through_one_prediction():
    rows = [result([1.0, 1.1], W_T=1.0), result([1.2, 1.1], W_T=1.0), result([1.2, 1.1], W_T=1.0)]
    assert line_through(rows) is None
    assert line_through(rows[:1], origin=True) is None
