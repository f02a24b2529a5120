"""Claims of the protocol, judged from the session: findings, which never fail a run.

Each entry of the session's document `protocol` (key `expect`) lists the cases and their conditions.
The grammar of protocols is therefore not needed here, and a laboratory may write claims of its own.
"""

from collections import Counter
from collections.abc import Iterable, Mapping

from analysis.comparison.claim_tests import TESTS, Finding, Level, Question, Scatter
from analysis.results.condition import Result
from analysis.results.judged_rows import CaseRow, ClaimRow
from analysis.session.protocol import ClaimCase, ExpectedClaim

__all__ = ["judge"]

VERDICTS = ("does not hold", "undecided", "holds")
"""Verdicts in order of precedence: the first one that any case has is the verdict over all cases.
"""


def judge(expect: Iterable[ExpectedClaim], results: Mapping[str, Result]) -> tuple[ClaimRow, ...]:
    """Return the report's `claims`, one row for each expected claim.

    results: evaluated conditions by id.

    A claim over several cases holds where it holds in every one (each tested at 5 %: an
    intersection-union test) and does not hold where one contradicts it (each tested at 5 % over
    their number).
    """
    scatter = Scatter.of(results.values())
    return tuple(_entry(entry, results, scatter) for entry in expect)


def _entry(
    entry: ExpectedClaim, results: Mapping[str, Result], scatter: Scatter | None
) -> ClaimRow:
    """Return the row of one claim."""
    question = Question(entry.values, entry.limits, max(1, len(entry.cases)), scatter)
    cases = [(_place(case.at), _case(entry, question, case, results)) for case in entry.cases]
    whole = _whole(cases)
    imposed = bool(entry.imposed) and whole.verdict != "does not hold"
    return ClaimRow(
        claim=entry.claim,
        test=_test(entry),
        found=whole.found,
        verdict="imposed" if imposed else whole.verdict,
        why=f"{entry.imposed}; {whole.why}" if imposed else whole.why,
        ties=whole.ties,
        cases=tuple(_row(at, finding) for at, finding in cases) if len(cases) > 1 else (),
    )


def _row(at: str, finding: Finding) -> CaseRow:
    """Return the row of one case."""
    return CaseRow(at, finding.found, finding.verdict, finding.why, finding.ties)


def _case(
    entry: ExpectedClaim, question: Question, case: ClaimCase, results: Mapping[str, Result]
) -> Finding:
    """Return the finding of one case; undecided where conditions that it needs were not measured."""
    levels = [
        Level(level.value, tuple(results[c] for c in level.conditions if c in results))
        for level in case.levels
    ]
    if entry.over and len({len(level.results) for level in levels}) > 1:
        return Finding(
            "", "undecided", f"not every value was measured at every {_field(entry.over)}"
        )
    one_each = not entry.over and entry.kind != "offset_within"
    if one_each and any(len(level.conditions) > 1 for level in case.levels):
        return Finding("", "undecided", f"several conditions have the same {_field(entry.about)}")
    levels = [level for level in levels if level.results]
    if not levels:
        return Finding("", "undecided", "none of its conditions was measured")
    return TESTS[entry.kind](levels, question)


def _whole(cases: list[tuple[str, Finding]]) -> Finding:
    """Return the finding over all cases."""
    if not cases:
        return Finding("", "undecided", "no condition of this session is about it")
    if len(cases) == 1:
        return cases[0][1]
    verdicts = Counter(finding.verdict for _, finding in cases)
    whole = next(verdict for verdict in VERDICTS if verdicts[verdict])
    found = dict.fromkeys(finding.found for _, finding in cases)
    shown = [f"{at}: {finding.found or finding.verdict}" for at, finding in cases]
    same = len(found) == 1 and "" not in found
    counts = ", ".join(
        f"{verdict} in {verdicts[verdict]}" for verdict in VERDICTS if verdicts[verdict]
    )
    return Finding(
        next(iter(found)) if same else "; ".join(shown), whole, f"{len(cases)} cases: {counts}"
    )


def _place(at: Mapping[str, str]) -> str:
    """Return the values that single out a case: "fill 85 %, diameter 4 mm"."""
    return ", ".join(f"{_field(path)} {value}" for path, value in at.items())


def _field(path: str) -> str:
    """Return the last word of a path in a protocol."""
    return path.rpartition(".")[2]


def _test(entry: ExpectedClaim) -> str:
    """Return the test of a claim in words."""
    kind, field, values = entry.kind, _field(entry.about), entry.values
    limits = [f"{limit:g}" for limit in entry.limits]
    per = f", per {field}" if field else ""
    over = f", mean of ln W over {_field(entry.over)}" if entry.over else ""
    return {
        "optimum": lambda: f"W is largest at {field} {' or '.join(values)}{over}",
        "order": lambda: f"W rises along {field} {', '.join(values)}{over}",
        "rise": lambda: f"W rises with {field} from {' to '.join(values)}{over}",
        "fall": lambda: f"W falls with {field} from {' to '.join(values)}{over}",
        "nonlinear": lambda: f"n = dlnW/dlna differs from 2 by more than {limits[0]}",
        "nearly_zero": lambda: f"W at {field} {values[0]} is below {limits[0]} of W at {values[1]}",
        "offset_within": lambda: f"W_exp/W_T - 1 is between {' and '.join(limits)}{per}",
    }[kind]()
