"""The rows as tables of text, the same for the terminal and for docs/performance.md."""

from collections.abc import Sequence

from rig.benchmarks.results.cost_tables import (
    break_even,
    compiling_table,
    exponents_table,
    fill_table,
    layers_table,
    memory_table,
    parts_table,
    sizes_table,
    small_beds_table,
)
from rig.benchmarks.results.table_parts import (
    SHORT,
    ResultTable,
    Row,
    cost_of,
    number,
    of_kind,
    own_rows,
    spread,
    succeeded,
    verdict,
)

__all__ = ["SHORT", "ResultTable", "break_even", "number", "own_rows", "succeeded", "tables"]

WANTED = (1e-4, 1e-6, 1e-9)


def tables(rows: Sequence[Row]) -> list[ResultTable]:
    """Return all tables for which the rows have numbers."""
    found = [
        _claims(rows),
        _each(rows),
        _checks(rows),
        *(_costs(rows, wanted) for wanted in WANTED),
        _work(rows),
        _states(rows),
        layers_table(rows),
        small_beds_table(rows),
        fill_table(rows),
        parts_table(rows),
        exponents_table(rows),
        sizes_table(rows),
        compiling_table(rows),
        _drift(rows),
        memory_table(rows),
        _failures(rows),
    ]
    return [table for table in found if table.lines]


def _claims(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (
            f"{row['error']:.0e}",
            row["rivals"],
            "all of them" if row["problem"] == "all" else row["problem"],
            f"{row['demand']:g}",
            ("> " if row["at_least"] else "") + spread(row["ratio"]),
            verdict(row["held"]),
        )
        for row in of_kind(rows, "claim")
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
    own = [row for row in of_kind(rows, "claim") if row["problem"] != "all"]
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
            verdict(row["held"]),
        )
        for row in of_kind(rows, "check")
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
            cells.append(number(cost_of(own_rows(precise, problem, method), wanted)))
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


def _drift(rows: Sequence[Row]) -> ResultTable:
    lines = tuple(
        (row["problem"], str(row["cycles"]), f"{row['drift']:.1e}", f"{row['largest_J']:.1e}")
        for row in of_kind(rows, "drift")
    )
    return ResultTable(
        "drift",
        "Account of a bed over many cycles",
        ("bed", "cycles", "left over / W", "worst cycle J"),
        lines,
        ("bed",),
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
