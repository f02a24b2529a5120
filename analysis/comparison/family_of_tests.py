"""Control of the family-wise error of a session: a healthy rig fails its tests in at most 5 % of
sessions.

Each test alone would be wrong in 5 %; some fail nearly always together, because all rest on one
draw of the same sensors. So the critical value is that of the largest score of them all. The tests
are modelled as normal scores, correlated through the instruments that they have in common, and 5 %
of the joint draws exceed the critical value. An error that is not known to be common counts as
independent: among two-sided tests that makes the critical value larger, never smaller (Sidak, J.
Am. Stat. Assoc. 62, 626 (1967)).
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from analysis.results.condition import Result
from analysis.results.judged_rows import ReferenceRow
from analysis.uncertainty.budget_line import Line
from analysis.uncertainty.estimate import Estimate, coverage_factor

__all__ = [
    "ALONE",
    "CHAIN_SHARE",
    "FAILS",
    "Reference",
    "Zero",
    "chain_tests",
    "common",
    "critical_score",
    "needed",
    "sign_tests",
]

LEVEL = 0.95  # probability that a healthy rig passes all tests
ALONE = coverage_factor(math.inf, LEVEL)  # critical score of a single test
CHAIN_SHARE = 0.9  # fraction of the conditions that must agree with the rig's own ledger
FAILS = "does not hold"
DRAWS = 10_000  # joint draws: the 5 % at the critical score are good to 0.2 % (one sigma)
SEED = 1  # of the draws: equal sessions have equal verdicts
TOGETHER = 64  # tests in one matrix product, so that memory does not grow with their number


@dataclass(frozen=True, slots=True)
class Zero:
    """A quantity that must be zero.

    found : its estimate
    shared : standard uncertainties from inputs that other tests have in common, signed, by the
        input's name, in the unit of `found`
    one_sided : the quantity must only not be negative
    """

    found: Estimate
    shared: Mapping[str, float]
    one_sided: bool = False

    @property
    def score(self) -> float:
        """Normal deviate with the same p as this value: comparable whatever the degrees of freedom."""
        from scipy.special import ndtri

        score = -float(ndtri(self.found.p() / 2))
        return math.copysign(score, -self.found.value) if self.one_sided else score


@dataclass(frozen=True, slots=True)
class Reference:
    """A reference: "rigid mass" (kg), "dashpot" (J per cycle, mean over the levels), "phase" (rad)
    or "signs" (nothing measured).

    verdict : holds within U, undecided beyond it, until `judged` compares it with the whole family
    tested : the quantities that it adds to the family of tests
    """

    reference: str
    of: str
    unit: str
    value: float | None
    expected: float | None
    U: float | None
    verdict: str
    why: str
    tested: tuple[Zero, ...] = ()

    def judged(self, limit: float) -> "Reference":
        """Return the reference with the verdict "does not hold" where a score exceeds the critical
        one, `limit`.
        """
        return (
            replace(self, verdict=FAILS)
            if any(test.score > limit for test in self.tested)
            else self
        )

    def row(self) -> ReferenceRow:
        """Return the report's entry."""
        return ReferenceRow(
            self.reference,
            self.of,
            self.unit,
            self.value,
            self.expected,
            self.U,
            self.verdict,
            self.why,
        )


def common(lines: Iterable[Line]) -> dict[str, float]:
    """Return the contributions to W_exp (J) of those budget lines that all conditions have in
    common, by source.
    """
    return {line.source: line.part for line in lines if line.shared}


def chain_tests(results: Sequence[Result]) -> tuple[Zero, ...]:
    """Return the tests of W_exp against the rig's own ledger, one for each condition that has a
    ledger.
    """
    return tuple(Zero(r.chain, common(r.lines)) for r in results if r.chain is not None)


def sign_tests(results: Sequence[Result]) -> tuple[Zero, ...]:
    """Return the tests that the dissipated energy of every condition is not negative."""
    return tuple(Zero(r.W_exp, common(r.lines), one_sided=True) for r in results)


def critical_score(tests: Sequence[Zero], chain: Sequence[Zero] = ()) -> float:
    """Return the score that a healthy rig exceeds in 5 % of sessions.

    It exceeds it where any of `tests` does, or where fewer than CHAIN_SHARE of the tests `chain`
    stay within it. At least ALONE, the critical score of a single test.
    """
    rng = np.random.default_rng(SEED)
    names = sorted({name for test in (*tests, *chain) for name in test.shared})
    # A score is the sum of its loads on the common inputs and of a remainder of its own; its variance
    # is 1.
    inputs = np.ascontiguousarray(rng.standard_normal((DRAWS, len(names))).T)

    def drawn(family: Sequence[Zero]) -> Iterator[NDArray[np.float64]]:
        for first in range(0, len(family), TOGETHER):
            some = family[first : first + TOGETHER]
            loads = np.array([[test.shared.get(name, 0.0) for name in names] for test in some])
            loads /= np.array([test.found.u or 1.0 for test in some])[:, None]
            own = np.sqrt(np.maximum(0.0, 1.0 - (loads * loads).sum(axis=1)))
            for test, score, alone in zip(some, loads @ inputs, own, strict=True):
                rng.standard_normal(out=normals)
                np.multiply(normals, alone, out=normals)
                score += normals
                yield np.negative(score, out=score) if test.one_sided else np.abs(score, out=score)

    normals = np.empty(DRAWS)
    most = np.full(DRAWS, -np.inf)
    for score in drawn(tests):
        np.maximum(most, score, out=most)
    if chain:
        scores = np.empty((len(chain), DRAWS), np.float32)
        above = np.zeros(DRAWS, np.int64)
        for row, score in zip(scores, drawn(chain), strict=True):
            row[:] = score
            above += row > most
        # The chain fails when more than `may_miss` of its scores exceed the bound: that is the score
        # of rank may_miss + 1 from above, in each draw.
        may_miss = len(chain) - needed(len(chain))
        # Only draws in which it exceeds the largest of the other tests are sorted.
        counts = np.flatnonzero(above > may_miss)
        largest = np.partition(scores[:, counts], -1 - may_miss, axis=0)[-1 - may_miss]
        most[counts] = np.maximum(most[counts], largest)
    return max(ALONE, float(np.quantile(most, LEVEL))) if tests or chain else ALONE


def needed(count: int) -> int:
    """Return how many of `count` conditions must agree with the ledger."""
    return math.ceil(CHAIN_SHARE * count - 1e-9)
