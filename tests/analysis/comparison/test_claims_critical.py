"""Adjusted p values, tests of two means and moderated variances, against what is known exactly."""

import math

import numpy as np
import pytest
from scipy import special, stats

from analysis.uncertainty.moderated_variance import prior_of
from analysis.uncertainty.multiple_comparisons import beaten, holm, one_sided_p, welch


def test_holm_by_hand():
    assert holm([0.01, 0.04, 0.03]) == pytest.approx((0.03, 0.06, 0.06))
    assert holm([0.5, 0.9]) == (1.0, 1.0)
    assert holm([]) == ()


def test_p_values_are_students():
    assert one_sided_p(2.0, 9.0) == pytest.approx(stats.t.sf(2.0, 9))
    assert one_sided_p(2.0, math.inf) == pytest.approx(stats.norm.sf(2.0))


def test_two_means_are_a_welch_test():
    """scipy's own, from the same two samples."""
    rng = np.random.default_rng(1)
    one, other = rng.normal(9, 1, 4), rng.normal(0, 5, 7)
    means = [(float(x.mean()), float(x.var(ddof=1) / len(x)), len(x) - 1.0) for x in (one, other)]
    found = stats.ttest_ind(one, other, equal_var=False, alternative="greater")
    assert one_sided_p(*welch(*means)) == pytest.approx(found.pvalue, rel=1e-9)
    assert beaten(means) == pytest.approx((1 - found.pvalue, found.pvalue), abs=1e-9)


DUNNETT = {1: 1.645, 2: 1.92, 3: 2.06, 5: 2.23, 9: 2.42}
"""One-sided 5 % values of k means against a control, infinite degrees of freedom (J. Am. Stat.
Assoc. 50, 1096).
"""


@pytest.mark.parametrize("k", DUNNETT)
def test_means_that_scatter_alike_are_dunnetts(k):
    """The table has two decimals: .005, at a density of .15 below p = 5 %."""
    clearest = (DUNNETT[k] * math.sqrt(2), 1.0, math.inf)
    p = beaten([(0.0, 1.0, math.inf), clearest, *[(0.0, 1.0, math.inf)] * (k - 1)])
    assert p[0] == pytest.approx(0.05, abs=0.005 * 0.15)


def test_means_that_scatter_differently_agree_with_their_definition():
    """1e6 draws: 2e-4 of a p of 5 %, five of which are allowed. One that scatters much and is below
    five others is judged by hardly more than a single test, one that scatters little by
    Bonferroni's."""
    rng, many = np.random.default_rng(4), 1_000_000
    for s in ([7.0, 1.0, 1.0, 0.7, 1.0, 1.0], [0.1, 1.0, 1.0, 0.7, 1.0, 1.0]):
        own, top = s[0] * rng.standard_normal(many), np.full(many, -np.inf)
        for other in s[1:]:
            np.maximum(
                top, (other * rng.standard_normal(many) - own) / math.hypot(other, s[0]), out=top
            )
        clear = float(np.quantile(top, 0.95))
        means = [(0.0, s[0] ** 2, math.inf), (clear * math.hypot(s[0], s[1]), s[1] ** 2, math.inf)]
        means += [(0.0, other**2, math.inf) for other in s[2:]]
        assert beaten(means)[0] == pytest.approx(0.05, abs=1e-3)
        single = stats.norm.sf(clear)
        assert single > 0.03 if s[0] > 1 else single < 0.011


def test_variances_of_one_prior_are_not_worth_more_than_all_refills():
    assert welch((1.0, 0.5, 30.0), (0.0, 0.5, 30.0)) == pytest.approx((1.0, 60.0))
    assert welch((1.0, 0.5, 30.0), (0.0, 0.5, 30.0), 30.0) == (1.0, 30.0)


@pytest.mark.parametrize("spread", [1, 4, 9])
def test_the_best_is_in_the_set_that_is_not_beaten(spread):
    """Coverage of at least 95 % where all are equal, the least favourable case, and one scatters
    more than the others; 400 draws, band of 0.1 %."""
    rng = np.random.default_rng(3)
    k, n, lost = 5, 4, 0
    s = np.array([1, 1, 1, 1, spread])[:, None]
    for _ in range(400):
        samples = s * rng.standard_normal((k, n))
        means = [(float(x.mean()), float(x.var(ddof=1)) / n, n - 1.0) for x in samples]
        lost += beaten(means)[0] <= 0.05
    assert lost <= stats.binom.ppf(0.999, 400, 0.05)


def test_one_mean_is_not_beaten():
    assert beaten([(1.0, 0.1, 3.0)]) == (1.0,)


def test_equal_variances_are_pooled_and_unequal_ones_are_not():
    """As drawn from s0^2 nu0/chi^2(nu0), of 4000 variances: s0 and nu0 come back. ln s^2 has the
    variance psi'(nu/2) + psi'(nu0/2), known to sqrt(2/4000) of itself (its kurtosis makes it half
    as much again): for nu0 = 6 that is .048 of psi'(3) = .395, or 12 % and of nu0 about as much;
    three of them are allowed."""
    rng = np.random.default_rng(5)
    nu, many = 3.0, 4000
    alike = prior_of([(float(v), nu) for v in 7 * rng.chisquare(nu, 12) / nu])
    assert alike.variance == pytest.approx(7, rel=3 * math.sqrt(2 / 36))
    nu0 = 6.0
    true = 7 * nu0 / rng.chisquare(nu0, many)
    found = prior_of([(float(v), nu) for v in true * rng.chisquare(nu, many) / nu])
    assert found.nu == pytest.approx(nu0, rel=0.36)
    assert found.variance == pytest.approx(7, rel=0.15)
    variance, dof = found.moderated(0.0, nu, 1.0)
    assert dof == pytest.approx(found.nu + nu)
    assert variance == pytest.approx(found.nu * found.variance / (found.nu + nu))


def test_a_variance_counts_for_at_least_its_own():
    prior = prior_of([(1.0, 3.0)] * 8)  # exactly alike: less than chance would make them differ
    assert math.isinf(prior.nu)
    assert prior.moderated(0.5, 3.0) == (1.0, 24.0)
    assert prior.moderated(4.0, 3.0) == (4.0, 24.0)
    assert prior.moderated(0.0, 0.0, 9.0) == (9.0, 24.0)


def test_a_variance_of_which_nothing_is_expected_counts_for_at_least_the_mean_of_all():
    """Of two far apart with many degrees of freedom each nearly counts for itself."""
    prior = prior_of([(1.0, 30.0), (99.0, 30.0)])
    assert prior.moderated(1.0, 30.0, 1.0)[0] < 2
    assert prior.moderated(1.0, 30.0)[0] == 50.0


def test_the_prior_solves_its_equation():
    """psi'(nu0/2) is what the logarithms vary beyond psi'(nu/2): of two variances a factor e^2
    apart it is 2 - psi'.
    """
    prior = prior_of([(1.0, 30.0), (math.e**2, 30.0)])
    assert special.polygamma(1, prior.nu / 2) == pytest.approx(
        2 - special.polygamma(1, 15), rel=1e-6
    )
