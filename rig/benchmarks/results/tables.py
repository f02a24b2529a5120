"""The rows as tables of text, the same for the terminal and for docs/performance.md."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from rig.benchmarks.results.curve import cost_at

Row = dict[str, Any]

SHORT = {
    "event-driven (ours)": "ours",
    "RK4, events located": "RK4",
    "semi-implicit Euler": "Euler",
    "Moreau time stepping": "Moreau",
    "solve_ivp RK45": "RK45",
    "solve_ivp DOP853": "DOP853",
    "solve_ivp Radau": "Radau",
    "solve_ivp LSODA": "LSODA",
}
WANTED = (1e-4, 1e-6, 1e-9)


class ResultTable(NamedTuple):
    """A table of results: `name` is its place on the page, `left` the columns of words."""

    name: str
    title: str
    columns: tuple[str, ...]
    lines: tuple[tuple[str, ...], ...]
    left: tuple[str, ...] = ()


def tables(rows: Sequence[Row]) -> list[ResultTable]:
    """Return all tables for which the rows have numbers."""
    found = [
        _claims(rows),
        _each(rows),
        _checks(rows),
        *(_costs(rows, wanted) for wanted in WANTED),
        _work(rows),
        _states(rows),
        _layers(rows),
        _small_beds(rows),
        _fill(rows),
        _parts(rows),
        _exponents(rows),
        _sizes(rows),
        _compiling(rows),
        _drift(rows),
        _memory(rows),
        _failures(rows),
    ]
    return [table for table in found if table.lines]


def spread(value: Row, digits: int = 3) -> str:
    """Return a median with the least and the largest value."""
    return f"{number(value['median'], digits)} ({number(value['low'], 2)} to {number(value['high'], 2)})"


def number(value: float | None, digits: int = 3) -> str:
    """Return a number to `digits` digits, without an exponent between 1e-3 and 1e6; a dash for
    None.
    """
    if value is None:
        return "-"
    if value == 0.0:
        return "0"
    if 1e-3 <= abs(value) < 1e6:
        return f"{float(f'{value:.{digits}g}'):f}".rstrip("0").rstrip(".")
    return f"{value:.{max(digits - 2, 0)}e}"


def own_rows(rows: Sequence[Row], problem: str, method: str) -> list[Row]:
    """Return the rows of one method on one problem, in order."""
    return [row for row in rows if (row["problem"], row["method"]) == (problem, method)]


def _cost(own: Sequence[Row], wanted: float) -> float | None:
    """Return a method's microseconds per cycle at the error `wanted`, None if not reached."""
    if not own:
        return None
    cost = cost_at(
        wanted, [row["error"] for row in own], [row["us_per_cycle"]["median"] for row in own]
    )
    return cost.seconds if cost.reached else None


def succeeded(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of the work-precision curves without those of failed methods."""
    return [row for row in _of(rows, "precision") if row["failure"] is None]


def _yes_or_no(held: bool | None) -> str:
    if held is None:
        return "-"
    return "yes" if held else "no"


def _of(rows: Sequence[Row], kind: str) -> list[Row]:
    return [row for row in rows if row["kind"] == kind]


def _verdict(held: bool) -> str:
    return "held" if held else "not held"


def _claims(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (
            f"{row['error']:.0e}",
            row["rivals"],
            "all of them" if row["problem"] == "all" else row["problem"],
            f"{row['demand']:g}",
            ("> " if row["at_least"] else "") + spread(row["ratio"]),
            _verdict(row["held"]),
        )
        for row in _of(rows, "claim")
        if row["problem"] == "all"
    )
    return ResultTable(
        "claims",
        "Times as fast as the rival, all problems together",
        ("error", "rival", "problems", "demand", "found", ""),
        lines,
        ("rival", "problems", ""),
    )


def _each(rows: Sequence[Row]) -> ResultTable:
    """Return the ratios problem by problem, a column for each claim."""
    own = [row for row in _of(rows, "claim") if row["problem"] != "all"]
    claims = list(dict.fromkeys((row["rivals"], row["error"], row["demand"]) for row in own))
    lines = []
    for problem in dict.fromkeys(row["problem"] for row in own):
        here = {
            (row["rivals"], row["error"], row["demand"]): row
            for row in own
            if row["problem"] == problem
        }
        cells = [problem]
        for claim in claims:
            row = here.get(claim)
            cells.append(
                f"{'> ' * row['at_least']}{number(row['ratio']['median'])}" if row else "-"
            )
        lines.append(tuple(cells))
    columns = (
        "problem",
        *(
            f"{rivals.split(',')[0].removeprefix('best ').removeprefix('compiled ')} {error:.0e} (>={demand:g})"
            for rivals, error, demand in claims
        ),
    )
    return ResultTable(
        "each",
        "Times as fast as the rival, problem by problem (median)",
        columns,
        tuple(lines),
        ("problem",),
    )


def _checks(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (
            row["what"],
            ("at least " if row["least"] else "at most ") + number(row["limit"]),
            number(row["found"]),
            _verdict(row["held"]),
        )
        for row in _of(rows, "check")
    )
    return ResultTable(
        "checks",
        "Limits of the parts",
        ("what", "limit", "found", ""),
        lines,
        ("what", "limit", ""),
    )


def _costs(rows: Sequence[Row], wanted: float) -> ResultTable:
    precise = succeeded(rows)
    problems = dict.fromkeys(row["problem"] for row in precise)
    methods = [name for name in SHORT if any(row["method"] == name for row in precise)]
    lines = []
    for problem in problems:
        cells = [problem]
        for method in methods:
            cells.append(number(_cost(own_rows(precise, problem, method), wanted)))
        lines.append(tuple(cells))
    return ResultTable(
        f"cost_{wanted:.0e}",
        f"Microseconds per cycle for an error of {wanted:.0e} in W (- : not reached)",
        ("problem", *(SHORT[name] for name in methods)),
        tuple(lines),
        ("problem",),
    )


def _work(rows: Sequence[Row]) -> ResultTable:
    """Return the work per cycle of the coarsest setting that brings W to 1e-6, on the first problem
    with friction and impacts.
    """
    precise = succeeded(rows)
    problems = list(dict.fromkeys(row["problem"] for row in precise))
    problem = next(
        (name for name in problems if name.startswith("friction")), problems[0] if problems else ""
    )
    lines = []
    for method, short in SHORT.items():
        own = [row for row in own_rows(precise, problem, method) if row["error"] <= 1e-6]
        if own:
            row = own[0]
            lines.append(
                (
                    short,
                    f"{row['setting']:g}" if row["knob"] else "-",
                    f"{row['error']:.0e}",
                    number(row["us_per_cycle"]["median"]),
                    *(number(row[key]) for key in ("events", "steps", "rhs", "roots")),
                    number(row["memory_kB"], 2),
                )
            )
    return ResultTable(
        "work",
        f"Work per cycle, {problem}: the coarsest setting at or below 1e-6",
        ("method", "setting", "error", "us", "events", "steps", "rhs", "roots", "kB"),
        tuple(lines),
        ("method",),
    )


def _states(rows: Sequence[Row]) -> ResultTable:
    """Return the error of the state, on the first problem in which the mass moves at the end of a
    cycle.
    """
    precise = [row for row in succeeded(rows) if "state_error" in row]
    problem = next((row["problem"] for row in precise if row["problem"].startswith("block")), "")
    lines = []
    for method, short in SHORT.items():
        own = own_rows(precise, problem, method)
        near = [row for row in own if row["error"] <= 1e-6] or own[-1:]
        lines += [
            (
                short,
                f"{row['setting']:g}" if row["knob"] else "-",
                str(row["cycles"]),
                f"{row['error']:.0e}",
                f"{row['state_error']:.0e}",
            )
            for row in near[:1]
        ]
    columns = ("method", "setting", "cycles", "error of W", "error of the state")
    return ResultTable(
        "states", f"State after the last cycle, {problem}", columns, tuple(lines), ("method",)
    )


def _layers(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (
            f"{row['level']:g}",
            row["method"],
            number(1e3 * row["W_T"], 4),
            number(row["ms"]["median"]),
            "-" if row["error"] is None else f"{row['error']:.1e}",
            f"{100.0 * row['model_error']:+.2f} %",
            "-" if row.get("times") is None else spread(row["times"]),
        )
        for row in _of(rows, "layers")
    )
    return ResultTable(
        "layers",
        "The standard bed: what a model costs and what it errs",
        (
            "m/s2",
            "model",
            "W_T mJ",
            "ms",
            "numerics",
            "against many rows",
            "times ours, same cycles",
        ),
        lines,
        ("model",),
    )


def _small_beds(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (
            row["problem"],
            row["method"],
            f"{row['setting']:g}" if row["setting"] else "-",
            f"{row['error']:.0e}",
            number(row["ms"]["median"]),
            spread(row["times_ours"]),
        )
        for row in _of(rows, "small_bed")
        if row["failure"] is None
    )
    columns = ("bed", "method", "setting", "error of W", "ms", "times as long as ours")
    return ResultTable(
        "small_beds", "A bed of few rows, whole, 8 cycles", columns, lines, ("bed", "method")
    )


def _fill(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (
            row["method"],
            spread(row["s"]),
            number(row["rig_time_s"]),
            "-" if row["times_faster"] is None else spread(row["times_faster"]),
        )
        for row in _of(rows, "fill")
    )
    return ResultTable(
        "fill",
        "The fill protocol, 160 runs",
        ("what", "s", "rig time s", "times faster"),
        lines,
        ("what",),
    )


def _parts(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (
            row["problem"],
            row["method"],
            spread(row["ms"]),
            "0" if row["error"] == 0.0 else f"{row['error']:.1e}",
            number(row["memory_kB"], 2),
        )
        for row in _of(rows, "part")
    )
    return ResultTable(
        "parts",
        "Parts beside their rivals",
        ("part", "method", "ms", "error", "kB"),
        lines,
        ("part", "method"),
    )


def _exponents(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (
            row["axis"],
            row["what"],
            f"{row['sizes'][0]:g} to {row['sizes'][1]:g}",
            f"{row['exponent']:.2f} +- {2.0 * row['error']:.2f}",
            _yes_or_no(row["at_most_linear"]),
        )
        for row in _of(rows, "exponent")
    )
    return ResultTable(
        "exponents",
        "How cost grows: time ~ size^exponent",
        ("axis", "what", "sizes", "exponent", "at most linear"),
        lines,
        ("axis", "what", "sizes", "at most linear"),
    )


def _sizes(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (row["axis"], f"{row['size']:g}", spread(row["ms"])) for row in _of(rows, "scaling")
    )
    return ResultTable(
        "sizes", "Times behind the exponents", ("axis", "size", "ms"), lines, ("axis",)
    )


def break_even(compiling: float, own: float, rival: float) -> float | None:
    """Return the cycles after which compiling (s) has paid, from costs in microseconds per cycle;
    None for never.
    """
    return compiling / (1e-6 * (rival - own)) if rival > own else None


def _compiling(rows: Sequence[Row]) -> ResultTable:
    """Return the compiling times, and the cycles of a slider after which they have paid against
    scipy, which compiles nothing.
    """
    own = {method: _mean_cost(rows, (method,)) for method in SHORT}
    scipy = _mean_cost(rows, [name for name in SHORT if name.startswith("solve_ivp")])
    lines = []
    for row in _of(rows, "compiling"):
        cost = own.get(row["method"])
        cycles = (
            break_even(row["compiling_s"], cost, scipy)
            if cost is not None and scipy is not None
            else None
        )
        lines.append(
            (
                row["method"],
                number(row["first_s"]),
                number(row["later_s"]),
                number(row["compiling_s"]),
                number(cost),
                "-" if cycles is None else f"{float(f'{cycles:.2g}'):.0f}",
            )
        )
    columns = (
        "what",
        "first s",
        "later s",
        "compiling s",
        "us per cycle",
        "cycles until it has paid",
    )
    return ResultTable(
        "compiling", "Compiling: the first time and later", columns, tuple(lines), ("what",)
    )


def _mean_cost(rows: Sequence[Row], methods: Sequence[str], wanted: float = 1e-6) -> float | None:
    """Return the microseconds per cycle for the error `wanted`: the best of these methods, averaged
    over the problems.

    None where a problem has no method that reaches it.
    """
    precise = succeeded(rows)
    best = []
    for problem in dict.fromkeys(row["problem"] for row in precise):
        costs = []
        for method in methods:
            cost = _cost(own_rows(precise, problem, method), wanted)
            if cost is not None:
                costs.append(cost)
        if not costs:
            return None
        best.append(min(costs))
    return sum(best) / len(best) if best else None


def _drift(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (row["problem"], str(row["cycles"]), f"{row['drift']:.1e}", f"{row['largest_J']:.1e}")
        for row in _of(rows, "drift")
    )
    return ResultTable(
        "drift",
        "Account of a bed over many cycles",
        ("bed", "cycles", "left over / W", "worst cycle J"),
        lines,
        ("bed",),
    )


def _memory(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (row["problem"], row["method"], number(row["writer_MB"]), number(row["worker_MB"]))
        for row in _of(rows, "memory")
    )
    return ResultTable(
        "memory",
        "Peak memory",
        ("what", "record", "writer MB", "worker MB"),
        lines,
        ("what", "record"),
    )


def _failures(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (
            row["problem"],
            row.get("method", "-"),
            f"{row['setting']:g}" if "setting" in row else "-",
            row["failure"],
        )
        for row in rows
        if row.get("failure")
    )
    return ResultTable(
        "failures",
        "Failed",
        ("problem", "method", "setting", "why"),
        lines,
        ("problem", "method", "why"),
    )
