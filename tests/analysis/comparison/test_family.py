"""One session is one family: the critical score."""

import math

import numpy as np
import pytest
from scipy import stats
from scipy.special import ndtri

from analysis.comparison.family_of_tests import (
    ALONE,
    DRAWS,
    LEVEL,
    SEED,
    Zero,
    critical_score,
    needed,
)
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


@pytest.mark.parametrize("load", [0.0, 0.6, 0.9])
@pytest.mark.parametrize("tests", [0, 1, 4, 30])
def test_the_chain_counts_wherever_it_is_the_largest(tests: int, load: float) -> None:
    """The score is the quantile over all draws with the chain sorted whole, although only draws in
    which it exceeds the other tests are sorted. With one to four other tests it does in some of
    the draws.
    """
    chain = [Zero(Estimate(0.0, 1.0, math.inf), {"sensitivity": load}) for _ in range(40)]
    others = apart(tests)
    rng = np.random.default_rng(SEED)
    shared = rng.standard_normal((DRAWS, 1))[:, 0]
    first = [np.abs(rng.standard_normal(DRAWS)) for _ in others]
    scores = [
        np.abs(load * shared + math.sqrt(1 - load * load) * rng.standard_normal(DRAWS))
        for _ in chain
    ]
    kept = np.sort(scores, axis=0)[needed(len(chain)) - 1]
    expected = np.quantile(np.max([*first, kept], axis=0), LEVEL)
    # the chain's scores are kept in single precision
    assert critical_score(others, chain) == pytest.approx(max(ALONE, expected), rel=1e-6)


def test_one_side_counts_on_its_side() -> None:
    below, above = (Zero(Estimate(x, 1.0, math.inf), {}, one_sided=True).score for x in (-3.0, 3.0))
    assert (below, above) == (pytest.approx(3.0), pytest.approx(-3.0))


def test_a_score_is_as_rare_whatever_its_degrees_of_freedom() -> None:
    for nu in (1.0, 4.0, 50.0, math.inf):
        t = Estimate(0.0, 1.0, nu).factor(0.95)
        assert Zero(Estimate(t, 1.0, nu), {}).score == pytest.approx(ALONE)
