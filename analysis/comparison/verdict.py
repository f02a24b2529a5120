"""Whether a session passes: ledger, nulls, references, record quality, chain comparison. Claims
never decide it.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

from analysis.comparison.family_of_tests import ALONE, Reference, chain_tests, needed
from analysis.comparison.null_tests import NullTest
from analysis.energy.sweep_curve import SweepCurve
from analysis.results.condition import Result
from analysis.results.report import LeftOutRun
from analysis.session.ledger_columns import CLOSURE
from analysis.session.prediction import BEYOND
from analysis.signals.quality import SUSPECT
from analysis.text import counted

__all__ = ["Verdict", "verdict"]

CLOSES = {
    "prescribed": 1e-9,
    "shaker": 1e-6,
}  # largest closure of an account that closes, relative, by drive
SHOWN = 5  # conditions named in a sentence
NOT_REACHED = "level_not_reached"  # with what stopped the level: level_not_reached_voltage
FAULTS = {
    "clipped",
    "sensor_clip",
    "overload_hi",
    "overload_lo",
    "iepe_open",
    "iepe_short",
    "invalid",
    "overrun",
    "gap",
}


@dataclass(frozen=True, slots=True)
class Verdict:
    """verdict: passes or fails; reasons: one sentence per check; chain_share: of conditions within
    the family's bound of the chain; failures: the sentences of the checks that failed."""

    verdict: str
    reasons: tuple[str, ...]
    chain_share: float | None
    failures: tuple[str, ...] = ()


def verdict(
    results: Sequence[Result],
    nulls: Sequence[NullTest],
    references: Sequence[Reference],
    closure: float | None,
    left_out: Sequence[LeftOutRun],
    sweeps: Sequence[SweepCurve] = (),
    limit: float = ALONE,
) -> Verdict:
    """Judge a session; sweeps: of runs that state no energy; limit: critical score of the family of
    tests. A check that the record cannot answer (no truth, no null test) is said and fails nothing.
    """
    chain = [test.score <= limit for test in chain_tests(results)]
    share = sum(chain) / len(chain) if chain else None
    faulted = [run.run for r in results for run in r.runs if _faulted(run.flags)]
    faulted += [one.run for one in sweeps if _faulted(one.flags)]
    why = (
        "the record holds no truth"
        if results
        else "a sweep states no energy"
        if sweeps
        else "no run can be used"
    )
    checks = [
        _ledger(results, closure, why),
        *_nulls(nulls),
        *_references(references),
        _faults(faulted, left_out),
        _chain(chain, limit, why),
        _repeats(results),
        _beyond(results),
        (bool(results or sweeps), "" if results or sweeps else "No run can be used."),
        _sweeps(len(sweeps)),
    ]
    if not nulls:
        no_null = "no condition has a bed that cannot slide" if results or not sweeps else why
        checks.insert(1, (True, f"No null test: {no_null}."))
    passes = all(good for good, _ in checks)
    failures = tuple(text for good, text in checks if not good)
    return Verdict(
        "passes" if passes else "fails", tuple(text for _, text in checks if text), share, failures
    )


def _ledger(results: Sequence[Result], closure: float | None, why: str) -> tuple[bool, str]:
    if closure is None:
        return True, f"The energy account is not checked: {why}."
    good = all(
        run.ledger[CLOSURE] <= CLOSES.get(result.setting.drive, CLOSES["prescribed"])
        for result in results
        for run in result.runs
        if run.ledger is not None and CLOSURE in run.ledger
    )
    return (
        good,
        f"The rig's energy account {'closes' if good else 'does not close'}: error {closure:.1e}, relative.",
    )


def _beyond(results: Sequence[Result]) -> tuple[bool, str]:
    """Why W_T is missing where it was predicted for other levels than the one reached."""
    names = [result.setting.id for result in results if result.beyond]
    if not names:
        return True, ""
    shown = ", ".join(names[:SHOWN]) + (
        f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    )
    return (
        True,
        f"No W_T is stated for {shown}: the level reached is over {100 * BEYOND:g} % from those predicted.",
    )


def _nulls(nulls: Sequence[NullTest]) -> Iterator[tuple[bool, str]]:
    """A sentence for each kind of bed and verdict: the null whose angle is the largest share of its
    U stands for the others."""

    def share(null: NullTest) -> float:
        return abs(null.dphi.value) / null.dphi.U if null.dphi and null.dphi.U else 0.0

    for name, same in _alike(nulls, lambda null: (null.null, null.verdict)):
        test = (
            "The loop-back" if name[0] == "loop-back" else f"The null test with the {name[0]} bed"
        )
        yield name[1] != "does not hold", f"{test} {_told(name[1], same, share)}."


def _references(references: Sequence[Reference]) -> Iterator[tuple[bool, str]]:
    """Return what `_nulls` does, for references: those that were measured, and the signs only where
    they are wrong.
    """
    told = [
        each for each in references if each.value is not None or each.verdict == "does not hold"
    ]

    def share(each: Reference) -> float:
        known = each.value is not None and each.expected is not None and each.U
        return abs((each.value or 0.0) - (each.expected or 0.0)) / (each.U or 1.0) if known else 0.0

    for name, same in _alike(told, lambda each: (each.reference, each.of, each.verdict)):
        yield (
            name[2] != "does not hold",
            f"The reference {name[0]} ({name[1]}) {_told(name[2], same, share)}.",
        )


T = TypeVar("T", NullTest, Reference)


def _alike(
    each: Sequence[T], key: Callable[[T], tuple[str, ...]]
) -> Iterator[tuple[tuple[str, ...], list[T]]]:
    """Groups of equal keys in the order of first appearance."""
    groups: dict[tuple[str, ...], list[T]] = {}
    for item in each:
        groups.setdefault(key(item), []).append(item)
    return iter(groups.items())


def _told(verdict: str, same: Sequence[T], share: Callable[[T], float]) -> str:
    words = "is undecided" if verdict == "undecided" else verdict
    worst = max(same, key=share)
    if len(same) == 1:
        return f"{words}: {worst.why}"
    return f"{words} in {len(same)} cases, most narrowly: {worst.why}" if share(worst) else (
        f"{words} in {len(same)} cases: {worst.why}"
    )  # fmt: skip


def _faulted(flags: Sequence[str]) -> bool:
    """Whether a run's flags say that it is not what was asked for."""
    found = {
        flag.rpartition("_")[0] for flag in flags
    }  # what the analysis found of a channel: "gain_step_force"
    return bool(FAULTS & set(flags) or found & set(SUSPECT)) or any(
        flag.startswith(NOT_REACHED) for flag in flags
    )


def _faults(faulted: Sequence[str], left_out: Sequence[LeftOutRun]) -> tuple[bool, str]:
    if left_out:
        return (
            False,
            f"{counted(len(left_out), 'run')} cannot be used; the first: {left_out[0].why}.",
        )
    if faulted:
        if len(faulted) == 1:
            return False, f"1 run is overloaded or faulted: {faulted[0]}."
        return False, f"{len(faulted)} runs are overloaded or faulted, the first is {faulted[0]}."
    return True, "No run is overloaded or faulted."


def _chain(chain: Sequence[bool], limit: float, why: str) -> tuple[bool, str]:
    if not chain:
        return True, f"The chain comparison is not made: {why}."
    inside = f"W_exp agrees with the rig's own ledger in {sum(chain)} of {len(chain)} conditions"
    shared = "All tests of a session together fail a healthy rig in at most 1 of 20 sessions."
    bound = f"limit {limit / ALONE:.2f} U, because all tests are judged together; {needed(len(chain))} are needed"
    return sum(chain) >= needed(len(chain)), f"{inside} ({bound}). {shared}"


def _sweeps(count: int) -> tuple[bool, str]:
    return (
        True,
        f"Force and acceleration against frequency, no energy: {counted(count, 'sweep')}."
        if count
        else "",
    )


def _repeats(results: Sequence[Result]) -> tuple[bool, str]:
    single = sum(len(r.runs) == 1 for r in results)
    if not single:
        return True, ""
    them = f"{counted(single, 'condition')} {'has' if single == 1 else 'have'} a single run"
    return True, f"{them}: U holds nothing of the scatter between refills there."
