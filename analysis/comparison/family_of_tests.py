"""One session is one family of tests: a healthy rig fails any of them, together, in at most 5 % of
the sessions.

Each test alone would be wrong in 5 %, some nearly always together, because all see one draw of the
same sensors. So the critical value is that of the largest of them all: tests are normal scores that
share what the instruments share, and the share of joint draws in which the largest exceeds it is 5
%. What is not known to be shared counts as apart: among two-sided tests that makes the critical
value larger, never smaller (Sidak, J. Am. Stat. Assoc. 62, 626 (1967)).
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

LEVEL = 0.95
ALONE = coverage_factor(math.inf, LEVEL)  # critical score of a single test
CHAIN_SHARE = 0.9  # share of the conditions that must agree with the rig's own ledger
FAILS = "does not hold"
DRAWS = 10_000  # the probability at the critical score is good to 0.2 % (one sigma)
SEED = 1
TOGETHER = 64  # tests whose loads meet the draws in one product


@dataclass(frozen=True, slots=True)
class Zero:
    """What must be zero; one_sided: what must not be negative. shared: its standard uncertainties
    from inputs that other tests share, signed, by the input's name, in the unit of `found`."""

    found: Estimate
    shared: Mapping[str, float]
    one_sided: bool = False

    @property
    def score(self) -> float:
        """The normal deviate as rare as this value: comparable whatever the degrees of freedom."""
        from scipy.special import ndtri

        score = -float(ndtri(self.found.p() / 2))
        return math.copysign(score, -self.found.value) if self.one_sided else score


@dataclass(frozen=True, slots=True)
class Reference:
    """A reference: "rigid mass" (kg), "dashpot" (J per cycle, mean over the levels), "phase" (rad)
    or "signs" (nothing measured). verdict: holds within U, undecided beyond, until the family of
    all tests says that it does not hold (judged); tested: what it puts into that family."""

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
        """The same, that does not hold where a score is beyond the family's critical one."""
        return (
            replace(self, verdict=FAILS)
            if any(test.score > limit for test in self.tested)
            else self
        )

    def row(self) -> ReferenceRow:
        """The report's entry."""
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
    """Of a budget's lines what all conditions share: contribution to W_exp (J) by source."""
    return {line.source: line.part for line in lines if line.shared}


def chain_tests(results: Sequence[Result]) -> tuple[Zero, ...]:
    """W_exp against the rig's own ledger, of every condition that has one."""
    return tuple(Zero(r.chain, common(r.lines)) for r in results if r.chain is not None)


def sign_tests(results: Sequence[Result]) -> tuple[Zero, ...]:
    """The dissipated energy of every condition is not negative."""
    return tuple(Zero(r.W_exp, common(r.lines), one_sided=True) for r in results)


def critical_score(tests: Sequence[Zero], chain: Sequence[Zero] = ()) -> float:
    """Score that all tests of a healthy rig stay within in 95 % of the sessions, and CHAIN_SHARE of
    the chain's do.
    """
    rng = np.random.default_rng(SEED)
    names = sorted({name for test in (*tests, *chain) for name in test.shared})
    inputs = np.ascontiguousarray(rng.standard_normal((DRAWS, len(names))).T)

    def drawn(family: Sequence[Zero]) -> Iterator[NDArray[np.float64]]:
        for first in range(0, len(family), TOGETHER):
            some = family[first : first + TOGETHER]
            loads = np.array([[test.shared.get(name, 0.0) for name in names] for test in some])
            loads /= np.array([test.found.u or 1.0 for test in some])[:, None]
            own = np.sqrt(np.maximum(0.0, 1.0 - (loads * loads).sum(axis=1)))
            for test, score, alone in zip(some, loads @ inputs, own, strict=True):
                score += alone * rng.standard_normal(DRAWS)
                yield -score if test.one_sided else np.abs(score)

    most = np.full(DRAWS, -np.inf)
    for score in drawn(tests):
        np.maximum(most, score, out=most)
    if chain:
        scores = np.empty((len(chain), DRAWS), np.float32)
        for row, score in zip(scores, drawn(chain), strict=True):
            row[:] = score
        may_miss = len(chain) - needed(len(chain))
        np.maximum(most, np.partition(scores, -1 - may_miss, axis=0)[-1 - may_miss], out=most)
    return max(ALONE, float(np.quantile(most, LEVEL))) if tests or chain else ALONE


def needed(count: int) -> int:
    """Of so many conditions those that must agree with the ledger."""
    return math.ceil(CHAIN_SHARE * count - 1e-9)
