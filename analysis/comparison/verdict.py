"""The verdict of a session: ledger, null tests, references, quality of the record, chain
comparison.

Claims never decide it.
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
from analysis.session.run_flags import NOT_REACHED
from analysis.signals.examination import FOUND
from analysis.signals.quality import SUSPECT
from analysis.text import counted

__all__ = ["Verdict", "verdict"]

CLOSES = {"prescribed": 1e-9, "shaker": 1e-6}
"""Largest relative error of an energy account that closes, by drive: that of a shaker-coupled stand
contains the error of its time steps.
"""
SHOWN = 5  # conditions named in a sentence
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
    """The verdict of a session.

    verdict : passes or fails
    reasons : one sentence for each check
    chain_share : fraction of the conditions within the family's bound of the chain comparison; None
        without a ledger
    failures : the sentences of the checks that failed
    """

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
    """Judge a session.

    closure: largest relative error of the energy account; sweeps: of runs that state no energy;
    limit: critical score of the family of tests. A check that the record cannot answer (no truth,
    no null test) is mentioned and fails nothing.
    """
    chain = [test.score <= limit for test in chain_tests(results)]
    fraction = sum(chain) / len(chain) if chain else None
    faulted = [run.run for r in results for run in r.runs if _faulted(run.flags)]
    faulted += [one.run for one in sweeps if _faulted(one.flags)]
    if results:
        why = "the record holds no truth"
    else:
        why = "a sweep states no energy" if sweeps else "no run can be used"
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
        "passes" if passes else "fails",
        tuple(text for _, text in checks if text),
        fraction,
        failures,
    )


def _ledger(results: Sequence[Result], closure: float | None, why: str) -> tuple[bool, str]:
    """Check that the energy account closes; why: the reason where there is none."""
    if closure is None:
        return True, f"The energy account is not checked: {why}."
    good = True
    for result in results:
        limit = CLOSES.get(result.setting.drive, CLOSES["prescribed"])
        ledgers = [run.ledger for run in result.runs if run.ledger is not None]
        good = good and all(ledger[CLOSURE] <= limit for ledger in ledgers if CLOSURE in ledger)
    found = "closes" if good else "does not close"
    return good, f"The rig's energy account {found}: error {closure:.1e}, relative."


def _beyond(results: Sequence[Result]) -> tuple[bool, str]:
    """Return why W_T is missing where the level reached lies outside the predicted ones."""
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
    """Yield a sentence for each kind of bed and verdict.

    Of several null tests it quotes the one whose angle is the largest fraction of its U.
    """

    def closeness(null: NullTest) -> float:
        return abs(null.dphi.value) / null.dphi.U if null.dphi and null.dphi.U else 0.0

    for name, same in _alike(nulls, lambda null: (null.null, null.verdict)):
        test = (
            "The loop-back" if name[0] == "loop-back" else f"The null test with the {name[0]} bed"
        )
        yield name[1] != "does not hold", f"{test} {_in_words(name[1], same, closeness)}."


def _references(references: Sequence[Reference]) -> Iterator[tuple[bool, str]]:
    """Yield the sentences of the measured references, as `_nulls` does; the signs only where they
    are wrong.
    """
    stated = [
        each for each in references if each.value is not None or each.verdict == "does not hold"
    ]

    def closeness(each: Reference) -> float:
        if each.value is None or each.expected is None or not each.U:
            return 0.0
        return abs(each.value - each.expected) / each.U

    for name, same in _alike(stated, lambda each: (each.reference, each.of, each.verdict)):
        yield (
            name[2] != "does not hold",
            f"The reference {name[0]} ({name[1]}) {_in_words(name[2], same, closeness)}.",
        )


T = TypeVar("T", NullTest, Reference)


def _alike(
    each: Sequence[T], key: Callable[[T], tuple[str, ...]]
) -> Iterator[tuple[tuple[str, ...], list[T]]]:
    """Return groups of equal keys in the order of first appearance."""
    groups: dict[tuple[str, ...], list[T]] = {}
    for item in each:
        groups.setdefault(key(item), []).append(item)
    return iter(groups.items())


def _in_words(verdict: str, same: Sequence[T], closeness: Callable[[T], float]) -> str:
    """Return a verdict in words, with the reason of the case nearest to its limit; closeness: of a
    case to it.
    """
    words = "is undecided" if verdict == "undecided" else verdict
    worst = max(same, key=closeness)
    if len(same) == 1:
        return f"{words}: {worst.why}"
    which = ", most narrowly" if closeness(worst) else ""
    return f"{words} in {len(same)} cases{which}: {worst.why}"


def _faulted(flags: Sequence[str]) -> bool:
    """Return whether a run's flags say that it is not what was asked for."""
    # Flags of the analysis end in the channel's name: "gain_step_force".
    found = {flag.rpartition("_")[0] for flag in flags}
    return bool(FAULTS & set(flags) or found & {*SUSPECT, *FOUND}) or any(
        flag.startswith(NOT_REACHED) for flag in flags
    )


def _faults(faulted: Sequence[str], left_out: Sequence[LeftOutRun]) -> tuple[bool, str]:
    """Check that no run is left out, overloaded or faulted."""
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
    """Check that enough conditions agree with the ledger; limit: critical score."""
    if not chain:
        return True, f"The chain comparison is not made: {why}."
    inside = f"W_exp agrees with the rig's own ledger in {sum(chain)} of {len(chain)} conditions"
    shared = "All tests of a session together fail a healthy rig in at most 1 of 20 sessions."
    bound = f"limit {limit / ALONE:.2f} U, because all tests are judged together; {needed(len(chain))} are needed"
    return sum(chain) >= needed(len(chain)), f"{inside} ({bound}). {shared}"


def _sweeps(count: int) -> tuple[bool, str]:
    """Return how many runs were sweeps."""
    return (
        True,
        f"Force and acceleration against frequency, no energy: {counted(count, 'sweep')}."
        if count
        else "",
    )


def _repeats(results: Sequence[Result]) -> tuple[bool, str]:
    """Return how many conditions have a single run: their U lacks the scatter between refills."""
    single = sum(len(r.runs) == 1 for r in results)
    if not single:
        return True, ""
    them = f"{counted(single, 'condition')} {'has' if single == 1 else 'have'} a single run"
    return True, f"{them}: U holds nothing of the scatter between refills there."
