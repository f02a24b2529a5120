"""One session is one family: the critical score."""

import math

import pytest
from scipy import stats
from scipy.special import ndtri

from analysis.comparison.family_of_tests import ALONE, Zero, critical_score, needed
from analysis.uncertainty.estimate import Estimate

# The critical score is the 95 % quantile of 10 000 draws: its probability has a standard deviation
# of sqrt(.05 .95/10000) = .0022, and with the density of a normal score there (2 phi(1.96) = .117 a
# unit) 4 of them are .075.
NEAR = 0.075


def apart(count: int) -> list[Zero]:
    return [Zero(Estimate(0.0, 1.0, math.inf), {}) for _ in range(count)]


def same(count: int) -> list[Zero]:
    return [Zero(Estimate(0.0, 2.0, math.inf), {"sensitivity": -2.0}) for _ in range(count)]


@pytest.mark.parametrize("count", [1, 2, 10, 100])
def test_independent_tests_have_sidaks_score(count: int) -> None:
    assert critical_score(apart(count)) == pytest.approx(
        -ndtri((1 - 0.95 ** (1 / count)) / 2), abs=NEAR
    )


def test_one_draw_of_the_instruments_counts_once() -> None:
    """Forty conditions that differ by nothing but their names are one test, and so with the chain's
    share.
    """
    assert critical_score(same(40)) == pytest.approx(ALONE, abs=NEAR)
    assert critical_score(same(3), same(40)) == pytest.approx(ALONE, abs=NEAR)


def test_of_the_chain_a_share_may_miss() -> None:
    """Of 20 independent conditions two may: the third largest of them is beyond its score p in 5 %
    of the draws.
    """
    p = -ndtri(stats.beta.ppf(0.05, 3, 18) / 2)
    assert needed(20) == 18
    # the critical score is never below that of a single test
    assert critical_score([], apart(20)) == pytest.approx(max(ALONE, p), abs=NEAR)


def test_one_side_counts_on_its_side() -> None:
    below, above = (Zero(Estimate(x, 1.0, math.inf), {}, one_sided=True).score for x in (-3.0, 3.0))
    assert (below, above) == (pytest.approx(3.0), pytest.approx(-3.0))


def test_a_score_is_as_rare_whatever_its_degrees_of_freedom() -> None:
    for nu in (1.0, 4.0, 50.0, math.inf):
        t = Estimate(0.0, 1.0, nu).factor(0.95)
        assert Zero(Estimate(t, 1.0, nu), {}).score == pytest.approx(ALONE)
