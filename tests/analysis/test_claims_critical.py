"""Critical values and adjusted p values against tables and another implementation."""

import math

import numpy as np
import pytest
from scipy import stats

from analysis.multiple import beaten, best_critical, holm, one_sided_p

DUNNETT = {  # one-sided, 5 %: 1, 2, 3 means against a control (Dunnett 1955, table 1a, two decimals)
    5: (2.02, 2.44, 2.68),
    10: (1.81, 2.15, 2.34),
    20: (1.72, 2.03, 2.19),
    math.inf: (1.64, 1.92, 2.06),
}


@pytest.mark.parametrize("nu", DUNNETT)
def test_critical_values_are_the_tabulated_ones(nu):
    found = [best_critical([4] * (k + 2), 0, nu, 0.05) for k in range(3)]
    assert found == pytest.approx(DUNNETT[nu], abs=0.0055)  # the table's rounding


def test_two_means_are_a_t_test():
    for nu, level in ((3, 0.05), (8, 0.0125), (30, 0.05)):
        assert best_critical([4, 7], 0, nu, level) == pytest.approx(stats.t.isf(level, nu))


def test_many_means_and_few_degrees_of_freedom():
    """Against the definition, 4e6 draws: the level's own error is 1e-4, five of which are allowed."""
    rng = np.random.default_rng(4)
    for k, nu, level in ((9, 3, 0.05), (6, 21, 0.025)):
        d = best_critical([4] * (k + 1), 0, nu, level)
        top = np.full(4_000_000, -np.inf)
        own = rng.standard_normal(top.size)
        for _ in range(k):
            np.maximum(top, rng.standard_normal(top.size), out=top)
        s = np.sqrt(rng.chisquare(nu, top.size) / nu)
        assert np.mean((top - own) / np.sqrt(2) > d * s) == pytest.approx(level, abs=5e-4)


def test_unequal_counts_agree_with_scipy():
    """Differences to one mean are a multivariate t, correlated by that mean: beyond our critical value lies the level,
    within scipy's quadrature error."""
    counts = np.array([3, 4, 6, 5])
    nu = int(counts.sum()) - counts.size
    d = best_critical(counts.tolist(), 0, nu, 0.05)
    share = np.sqrt(counts[1:] / (counts[1:] + counts[0]))
    shape = np.outer(share, share)
    np.fill_diagonal(shape, 1.0)
    inside = stats.multivariate_t.cdf([d] * 3, shape=shape, df=nu, random_state=np.random.default_rng(2))
    assert 1 - inside == pytest.approx(0.05, abs=1e-3)


def test_holm_by_hand():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx((0.03, 0.06, 0.06))
    assert holm([0.5, 0.9]) == (1.0, 1.0)
    assert holm([]) == ()


def test_p_values_are_students():
    assert one_sided_p(2.0, 9.0) == pytest.approx(stats.t.sf(2.0, 9))
    assert one_sided_p(2.0, math.inf) == pytest.approx(stats.norm.sf(2.0))


def test_the_best_is_in_the_set_that_is_not_beaten():
    """Coverage 95 % where all are equal, the least favourable case; 400 draws, band of 0.1 %."""
    rng = np.random.default_rng(3)
    k, n, nu = 5, 4, 15
    lost = 0
    for _ in range(400):
        samples = rng.standard_normal((k, n))
        s = math.sqrt(float(samples.var(axis=1, ddof=1).mean()))
        lost += beaten(samples.mean(axis=1).tolist(), [n] * k, s, nu, 0.05)[0]
    assert stats.binom.ppf(0.001, 400, 0.05) <= lost <= stats.binom.ppf(0.999, 400, 0.05)


def test_one_mean_is_not_beaten():
    assert beaten([1.0], [4], 0.1, 3, 0.05) == (False,)
