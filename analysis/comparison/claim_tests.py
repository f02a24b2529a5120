"""Statistical tests of claims: each one takes the levels of one case and returns a finding.

`holds` is tested at LEVEL. `does not hold` is tested at LEVEL divided by the number of cases,
because one case is enough to contradict a claim (Bonferroni). If neither test rejects, the claim is
`undecided`.
"""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from analysis.comparison.pooled_results import energy_ratio, inside_bands
from analysis.results.condition import Result
from analysis.uncertainty.budget import RESOLUTION, combine
from analysis.uncertainty.estimate import Estimate, effective_dof
from analysis.uncertainty.moderated_variance import Prior, prior_of
from analysis.uncertainty.multiple_comparisons import Mean, beaten, holm, one_sided_p, welch

__all__ = ["LEVEL", "TESTS", "Finding", "Level", "Question", "Scatter"]

LEVEL = 0.05  # of significance
HOLDS, FAILS, OPEN = "holds", "does not hold", "undecided"
QUADRATIC = 2.0  # exponent of everything linear: W of a dashpot, of a phase error
FEWEST_LEVELS = 3  # of a straight line that can contradict its own scatter


@dataclass(frozen=True, slots=True)
class Finding:
    """The outcome of one case.

    ties : values that do not differ significantly from the best
    """

    found: str
    verdict: str
    why: str
    ties: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Level:
    """One value of the field that a claim is about, and its conditions (several where a mean is
    claimed).
    """

    label: str
    results: tuple[Result, ...]


@dataclass(frozen=True, slots=True)
class Question:
    """What is claimed of the levels.

    values : the values that the claim names
    limits : margins, fixed beforehand
    cases : number of cases of the claim
    scatter : of all conditions of the session; None: estimated from the levels themselves
    """

    values: tuple[str, ...]
    limits: tuple[float, ...]
    cases: int
    scatter: "Scatter | None" = None

    @property
    def against(self) -> float:
        """Significance level of the test that contradicts the claim."""
        return LEVEL / self.cases


@dataclass(frozen=True, slots=True)
class Scatter:
    """Scatter of ln W of single runs: each condition's own variance, shrunk towards the expected
    one.

    is_expected : variances are expected in the proportions that the prediction's refills give;
        otherwise equal ones are expected
    levels : variance of ln of the level reached, pooled over all conditions: a property of the
        drive
    """

    prior: Prior
    is_expected: bool
    levels: float

    @classmethod
    def of(cls, results: Iterable[Result]) -> "Scatter | None":
        """Return the scatter of the conditions of a session; None without repeats.

        Conditions in which nothing can slide count only where there are no others: a refill changes
        nothing in them, so that their scatter says nothing about that of the others.
        """
        repeated = [r for r in results if r.is_seen and len(r.runs) > 1]
        counted = [r for r in repeated if not r.setting.is_still] or repeated
        if not counted:
            return None
        levels = _of_levels(counted)
        expected = [_expected(r, levels) for r in counted]
        known = [variance for variance in expected if variance is not None]
        scales = known if len(known) == len(counted) else [1.0] * len(counted)
        own = map(_own_variance, counted)
        prior = prior_of(
            [(variance / scale, nu) for (variance, nu), scale in zip(own, scales, strict=True)]
        )
        return cls(prior, len(known) == len(counted), levels)

    def run(self, result: Result) -> tuple[float, float]:
        """Return the variance of ln W of a condition's run, and its degrees of freedom."""
        return self.prior.moderated(
            *_own_variance(result), _expected(result, self.levels) if self.is_expected else None
        )


def _own_variance(result: Result) -> tuple[float, float]:
    """Return the variance of ln W between the runs of a condition, and its degrees of freedom.

    (0, 0) for a single run and for energies below the detection limit.
    """
    if len(result.runs) < 2 or not result.is_seen:
        return 0.0, 0.0
    variance = _variance([math.log(run.energy.W) for run in result.runs])
    # No two runs are known to agree better than the arithmetic does.
    return max(variance, RESOLUTION**2), len(result.runs) - 1.0


def _of_levels(results: Iterable[Result]) -> float:
    """Return the variance of ln of the level between the runs of a condition, pooled over
    conditions.
    """
    square, nu = 0.0, 0
    for result in results:
        levels = [run.energy.level for run in result.runs]
        if min(levels) > 0:
            square += _variance([math.log(level) for level in levels]) * (len(levels) - 1)
            nu += len(levels) - 1
    return square / nu if nu else 0.0


def _expected(result: Result, of_levels: float) -> float | None:
    """Return the expected variance of ln W of a run; None where no refills were predicted.

    It is the sum of the variance between the prediction's refills, of the scatter of the levels (W
    goes as a^n) and of the instruments' noise.
    """
    total = result.W_T.value if result.W_T is not None else None
    if result.setting.is_still:
        total = 0.0
    if total is None or (total and len(result.refills) < 2):
        return None
    W = math.exp(result.log_energy)
    between_refills = _variance(result.refills) * (total / W) ** 2 if total else 0.0
    noise = math.fsum((run.u_noise / W) ** 2 for run in result.runs) / len(result.runs)
    n = result.predicted.exponent or QUADRATIC
    return between_refills + noise + n**2 * of_levels + RESOLUTION**2


def _variance(values: Sequence[float]) -> float:
    mean = math.fsum(values) / len(values)
    return math.fsum((value - mean) ** 2 for value in values) / (len(values) - 1)


@dataclass(frozen=True, slots=True)
class Logs:
    """Means of ln W of the levels.

    most : degrees of freedom of all conditions together
    seen : the energy exceeds the detection limit. Where it does not, the mean is an upper limit:
        such a level can be beaten but cannot beat another
    s : standard deviation of a run in the least and in the most scattering condition
    """

    means: tuple[Mean, ...]
    most: float
    seen: tuple[bool, ...]
    s: tuple[float, float]

    def exceeds(self, one: int, other: int) -> float:
        """Return p of the one-sided test that level `one` is above level `other`."""
        if not self.seen[one]:
            return 1.0
        return one_sided_p(*welch(self.means[one], self.means[other], self.most))


def logs(levels: Sequence[Level], scatter: Scatter | None = None) -> Logs | None:
    """Return the means of ln W of the levels; None without repeats.

    scatter: of the session; None: estimated from the levels.
    """
    flat = [result for level in levels for result in level.results]
    common = scatter or Scatter.of(flat)
    if common is None or not any(nu for _, nu in map(_own_variance, flat)):
        return None
    run = {id(result): common.run(result) for result in flat}
    means = []
    for level in levels:
        m = len(level.results)
        parts = [(run[id(r)][0] / len(r.runs) / m**2, run[id(r)][1]) for r in level.results]
        nu = effective_dof([(math.sqrt(variance), nu) for variance, nu in parts])
        mean = math.fsum(result.log_energy for result in level.results) / m
        means.append(
            (mean, math.fsum(variance for variance, _ in parts), min(nu, common.prior.most))
        )
    spread = [math.sqrt(variance) for variance, _ in run.values()]
    seen = tuple(all(result.is_seen for result in level.results) for level in levels)
    return Logs(tuple(means), common.prior.most, seen, (min(spread), max(spread)))


def _without_scatter(levels: Sequence[Level]) -> Finding:
    """Return the undecided finding that says why nothing can be compared."""
    if len(levels) < 2:
        why = f"only one value was measured, {levels[0].label}: nothing to compare it with"
    elif any(len(result.runs) > 1 for level in levels for result in level.results):
        why = "no repeated condition exceeds the detection limit"
    else:
        why = "no condition was repeated: nothing says what a difference means"
    return Finding("", OPEN, why)


def optimum(levels: Sequence[Level], question: Question) -> Finding:
    """Test that the values named are the only ones not beaten by another.

    Multiple comparisons with the best (`analysis.uncertainty.multiple_comparisons.beaten`).
    """
    found = logs(levels, question.scatter)
    if found is None:
        return _without_scatter(levels)
    labels = [level.label for level in levels]
    # A level is (mean, variance, nu): tuples compare by the mean.
    top = max(range(len(labels)), key=found.means.__getitem__)
    p = beaten(found.means, found.most)
    left = tuple(label for label, of in zip(labels, p, strict=True) if of > LEVEL)
    named = [
        of <= question.against
        for label, of in zip(labels, p, strict=True)
        if label in question.values
    ]
    why = f"{_listed(left)} {'is' if len(left) == 1 else 'are'} not beaten by another of {len(labels)} values"
    why += f" ({_scatter(found)}){_predicted_best(levels)}"
    if len(labels) < 2 or not named or not found.seen[top]:
        return Finding(labels[top], OPEN, f"too little to compare with: {why}", left)
    if set(left) <= set(question.values):
        return Finding(labels[top], HOLDS, why, left if len(left) > 1 else ())
    return Finding(labels[top], FAILS if all(named) else OPEN, why, left if len(left) > 1 else ())


def _predicted_best(levels: Sequence[Level]) -> str:
    """Return where the prediction is largest, in words; "" where it is not known or zero
    throughout.
    """
    totals = [
        [r.W_T.value for r in level.results if r.W_T is not None and r.W_T.value > 0]
        for level in levels
    ]
    known = [
        (math.fsum(map(math.log, total)) / len(total), level.label)
        for total, level in zip(totals, levels, strict=True)
        if total and len(total) == len(level.results)
    ]
    return f"; W_T is largest at {max(known)[1]}" if known else ""


def rising(levels: Sequence[Level], question: Question) -> Finding:
    """Test that ln W rises in each step (one-sided tests of neighbours, Holm)."""
    return _steps(levels, question, 1)


def falling(levels: Sequence[Level], question: Question) -> Finding:
    """Test that ln W falls in each step (one-sided tests of neighbours, Holm)."""
    return _steps(levels, question, -1)


def _steps(levels: Sequence[Level], question: Question, sign: int) -> Finding:
    """Test that ln W rises (sign 1) or falls (sign -1) in each step."""
    found = logs(levels, question.scatter)
    if found is None:
        return _without_scatter(levels)
    pairs = [(i, i + 1) for i in range(len(levels) - 1)]
    if not pairs or not set(question.values) <= {level.label for level in levels}:
        return Finding("", OPEN, "not all values named were measured")
    up = holm([found.exceeds(j, i) for i, j in pairs])
    down = holm([found.exceeds(i, j) for i, j in pairs])
    marks = [_mark(*p) for p in zip(up, down, strict=True)]
    order = levels[0].label + "".join(
        f" {m} {level.label}" for m, level in zip(marks, levels[1:], strict=True)
    )
    for_it, against = (up, down) if sign > 0 else (down, up)
    sure = sum(p <= LEVEL for p in for_it)
    contrary = sum(p <= question.against for p in against)
    why = f"{sure} of {len(pairs)} steps {'rise' if sign > 0 else 'fall'} for sure, {contrary} the other way"
    why += f" (largest p {max(for_it):.2g}, Holm; {_scatter(found)})"
    return Finding(order, _verdict(sure == len(pairs), contrary > 0), why)


def _mark(up: float, down: float) -> str:
    """Return the sign between two levels: < or > where p of that direction is at most LEVEL, else ~."""
    if up <= LEVEL:
        return "<"
    return ">" if down <= LEVEL else "~"


def _verdict(holds: bool, fails: bool) -> str:
    """Return the verdict of a case whose tests for and against the claim have these outcomes."""
    if holds:
        return HOLDS
    return FAILS if fails else OPEN


def nonlinear(levels: Sequence[Level], question: Question) -> Finding:
    """Test that n = dlnW/dlna differs from 2 by more than the margin.

    n is the slope of a straight line through ln W over ln a of all runs of the levels that are
    seen.
    """
    seen = [level for level in levels if all(result.is_seen for result in level.results)]
    runs = [run for level in seen for result in level.results for run in result.runs]
    if len(seen) < FEWEST_LEVELS:
        why = f"{len(seen)} levels stand out of the detection limit, {FEWEST_LEVELS} are needed"
        return Finding("", OPEN, why)
    x, y = np.log([[run.energy.level, run.energy.W] for run in runs]).T
    x = x - x.mean()
    if not x.any():
        return Finding("", OPEN, "all levels have the same acceleration")
    n = float(x @ y) / float(x @ x)
    rest = y - y.mean() - n * x
    nu = float(len(runs) - 2)
    slope = Estimate(n, math.sqrt(max(float(rest @ rest) / nu, RESOLUTION**2) / float(x @ x)), nu)
    (margin,) = question.limits
    off = abs(n - QUADRATIC)
    verdict = _verdict(off - slope.U > margin, off + _t(slope, question) < margin)
    why = f"n - 2 = {n - QUADRATIC:.3f} with U = {slope.U:.2g} over {len(seen)} levels; margin {margin:g}"
    return Finding(f"n = {n:.2f}", verdict, why)


def nearly_zero(levels: Sequence[Level], question: Question) -> Finding:
    """Test that |W| lies below the margin times W of the other condition, with its whole interval.

    An equivalence test: a wide interval leaves the claim undecided, and never makes it hold.
    """
    if len(levels) != 2 or any(len(level.results) != 1 for level in levels):
        return Finding("", OPEN, "not both conditions were measured")
    low, full = (level.results[0].W_exp for level in levels)
    (margin,) = question.limits
    allowed = margin * full.value
    gap = combine(allowed - abs(low.value), [*low.parts(), *full.parts(margin)])
    verdict = _verdict(gap.value > _t(gap), -gap.value > _t(gap, question))
    why = f"W = {1e3 * low.value:.3g} mJ with U = {1e3 * low.U:.2g} mJ; {100 * margin:g} % of full is "
    return Finding(
        f"{100 * low.value / full.value:.2g} % of full", verdict, f"{why}{1e3 * allowed:.3g} mJ"
    )


def offset_within(levels: Sequence[Level], question: Question) -> Finding:
    """Test that sum W_exp / sum W_T - 1 lies between the limits, with its whole interval.

    An equivalence test, as for `nearly_zero`.
    """
    results = [result for level in levels for result in level.results]
    if (ratio := energy_ratio(results)) is None:
        return Finding(*inside_bands(results))
    low, high = question.limits
    offset = ratio.value - 1
    inside = min(offset - low, high - offset)
    verdict = _verdict(inside > _t(ratio), -inside > _t(ratio, question))
    why = (
        f"U = {100 * ratio.U:.2g} % (k = {ratio.k:.2f}); limits {100 * low:g} % to {100 * high:g} %"
    )
    return Finding(f"{100 * offset:.1f} %", verdict, why)


def _t(estimate: Estimate, question: Question | None = None) -> float:
    """Return the half width of an estimate's interval at LEVEL (the stated U), or for a question at
    its level `against`.

    A one-sided test would allow the interval at twice the level. But refills scatter with a long
    upper tail, so that the mean of four errs low more often than high: for a claim with an upper
    limit the narrower interval held falsely in 7 % of simulated sessions, the stated interval in 5
    %.
    """
    level = question.against if question else LEVEL
    return estimate.factor(1 - level) * estimate.u


def _listed(labels: Sequence[str]) -> str:
    """Return labels as an English list: "a, b and c"."""
    return " and ".join(filter(None, [", ".join(labels[:-1]), *labels[-1:]]))


def _scatter(found: Logs) -> str:
    """Return the scatter of a run and its degrees of freedom in words."""
    low, high = (f"{100 * s:.2g}" for s in found.s)
    few = min(nu for _, _, nu in found.means)
    return f"a run scatters by {low if low == high else f'{low} to {high}'} %, {few:.0f} degrees of freedom at least"


TESTS: Mapping[str, Callable[[Sequence[Level], Question], Finding]] = {
    "optimum": optimum, "order": rising, "rise": rising, "fall": falling, "nonlinear": nonlinear,
    "nearly_zero": nearly_zero, "offset_within": offset_within,
}  # fmt: skip
