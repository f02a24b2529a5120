"""Claims about the event-driven rows and the rig's parts, judged from one run's rows."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from rig.benchmarks.results.curve import Cost, cost_at
from rig.benchmarks.timing import spread

Row = dict[str, Any]


class Claim(NamedTuple):
    """`rivals` need at least `demand` times as long as ours to reach the relative error `error` of
    W.
    """

    error: float
    demand: float
    rivals: tuple[str, ...]
    words: str


FIRST_ORDER = ("semi-implicit Euler", "Moreau time stepping")
SOLVE_IVP = ("solve_ivp RK45", "solve_ivp DOP853", "solve_ivp Radau", "solve_ivp LSODA")
RK4 = ("RK4, events located",)
OURS = "event-driven (ours)"

WHOLE_PROCESS = 2.0
"""Limit in seconds of `rig run` on the fill protocol, from the start of Python to its end, on two
free cores.
"""

CLAIMS = (
    Claim(1e-6, 1000.0, SOLVE_IVP, "best solve_ivp with events"),
    Claim(1e-6, 2.0, RK4, "compiled RK4, events located"),
    Claim(1e-4, 20.0, FIRST_ORDER, "best compiled first-order stepping"),
    Claim(1e-9, 4.0, RK4, "compiled RK4, events located"),
)


def judged(rows: Sequence[Row]) -> list[Row]:
    """Return one row per claim and problem, and one for all problems together, which decides by the
    summed times.
    """
    precise = [row for row in _of(rows, "precision") if row["failure"] is None]
    problems = list(dict.fromkeys(row["problem"] for row in precise))
    found = []
    for claim in CLAIMS:
        sums: list[tuple[list[float], list[float]]] = []
        bound = False
        for problem in problems:
            here = [row for row in precise if row["problem"] == problem]
            ours = _costs(here, OURS, claim.error)
            rivals = {name: _costs(here, name, claim.error) for name in claim.rivals}
            rivals = {name: costs for name, costs in rivals.items() if costs}
            if not ours or not ours[0].reached or not rivals:
                continue
            # A rival that reaches the error beats any that does not, however fast.
            best = min(
                rivals, key=lambda name: (not rivals[name][0].reached, _median(rivals[name]))
            )
            theirs = rivals[best]
            # No rival reaches the error: the ratio is a lower bound.
            bound |= not theirs[0].reached
            sums.append(([cost.seconds for cost in theirs], [cost.seconds for cost in ours]))
            found.append(_row(claim, problem, best, sums[-1:], not theirs[0].reached))
        if sums:
            found.append(_row(claim, "all", "", sums, bound))
    return found


def checked(rows: Sequence[Row]) -> list[Row]:
    """Return one row per claim about the rig's parts: measured value, limit, and whether it is
    kept.
    """
    found: list[Row] = []
    fill = _of(rows, "fill")
    recording = [row for row in fill if row["method"].startswith("recording")]
    if recording:
        best = recording[-1]
        found.append(
            _check(
                f"fill protocol, {best['method']}: times faster than rig time",
                best["times_faster"]["median"],
                200.0,
                least=True,
            )
        )
    found += [
        _check(f"fill protocol, {row['method']}: s", row["s"]["median"], WHOLE_PROCESS)
        for row in fill
        if row["method"].startswith("whole process")
    ]
    found += [
        _check(
            f"{row['problem']}, {row['method']}: speed over that of {row['speed']['rival']}",
            row["speed"]["median"],
            row["speed"]["demand"],
            least=True,
        )
        for row in _of(rows, "part")
        if row.get("speed")
    ]
    weighed = [row for row in _of(rows, "memory") if row["worker_MB"] is not None]
    if weighed:
        short, long = weighed[0], weighed[-1]
        grown = max(long[who] - short[who] for who in ("writer_MB", "worker_MB"))
        found.append(
            _check(f"memory, {long['method']}: MB more than for {short['method']}", grown, 5.0)
        )
    tier = [row for row in _of(rows, "layers") if row["method"] == "layers variant, 8 rows"]
    if tier:
        found.append(
            _check(
                "layers variant, 8 rows: ms a condition, slowest level",
                max(row["ms"]["median"] for row in tier),
                10.0,
            )
        )
        found.append(
            _check(
                "layers variant, 8 rows: relative error of W_T, worst level",
                max(row["error"] for row in tier),
                5e-3,
            )
        )
    found += [
        _check(
            f"exciter in the loop, {row['rows']} rows at {row['level']:.1f} m/s2: times faster than real time",
            row["times_faster"]["median"],
            20.0,
            least=True,
        )
        for row in _of(rows, "shaker")
    ]
    found += [
        _check(
            f"account of bed {row['problem']}, {row['cycles']} cycles: relative drift",
            row["drift"],
            1e-9,
        )
        for row in _of(rows, "drift")
    ]
    found += [
        {
            **_check(
                f"cost over {row['axis']}: exponent, error {row['error']:.2f}", row["exponent"], 1.0
            ),
            "held": row["at_most_linear"],
        }
        for row in _of(rows, "exponent")
        if row["at_most_linear"] is not None
    ]
    return found


def _of(rows: Sequence[Row], kind: str) -> list[Row]:
    return [row for row in rows if row["kind"] == kind]


def _check(what: str, value: float, limit: float, least: bool = False) -> Row:
    held = value >= limit if least else value <= limit
    return {
        "kind": "check",
        "what": what,
        "found": value,
        "limit": limit,
        "least": least,
        "held": held,
    }


def _row(
    claim: Claim,
    problem: str,
    rival: str,
    times: Sequence[tuple[list[float], list[float]]],
    bound: bool,
) -> Row:
    """Return the row of a claim from the times of rival and ours, per problem and round."""
    theirs, ours = zip(*times, strict=True)
    slow = [sum(values) for values in zip(*theirs, strict=True)]
    fast = [sum(values) for values in zip(*ours, strict=True)]
    ratio = spread([a / b for a, b in zip(slow, fast, strict=True)])
    return {
        "kind": "claim",
        "error": claim.error,
        "rivals": claim.words,
        "problem": problem,
        "best": rival,
        "demand": claim.demand,
        "ratio": ratio,
        "at_least": bound,
        "held": ratio["median"] >= claim.demand,
        "problems": len(times),
    }


def _costs(rows: Sequence[Row], method: str, wanted: float) -> list[Cost]:
    """Return the cost of a method at a given error, us per cycle, once for each round; empty where
    it always failed.
    """
    own = [row for row in rows if row["method"] == method]
    if not own:
        return []
    errors = [row["error"] for row in own]
    rounds = zip(*(row["us_each"] for row in own), strict=True)
    return [cost_at(wanted, errors, times) for times in rounds]


def _median(costs: Sequence[Cost]) -> float:
    return sorted(cost.seconds for cost in costs)[len(costs) // 2]
