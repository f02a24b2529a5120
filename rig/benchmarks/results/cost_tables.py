"""Tables of the cost of the rig: beds, parts, growth with size, compiling and memory."""

from collections.abc import Sequence

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
    yes_or_no,
)


def layers_table(rows: Sequence[Row]) -> ResultTable:
    """Return the table of the cost of the layers of a bed."""
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
        for row in of_kind(rows, "layers")
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


def small_beds_table(rows: Sequence[Row]) -> ResultTable:
    """Return the table of the cost of small beds."""
    lines = tuple(
        (
            row["problem"],
            row["method"],
            f"{row['setting']:g}" if row["setting"] else "-",
            f"{row['error']:.0e}",
            number(row["ms"]["median"]),
            spread(row["times_ours"]),
        )
        for row in of_kind(rows, "small_bed")
        if row["failure"] is None
    )
    columns = ("bed", "method", "setting", "error of W", "ms", "times as long as ours")
    return ResultTable(
        "small_beds", "A bed of few rows, whole, 8 cycles", columns, lines, ("bed", "method")
    )


def fill_table(rows: Sequence[Row]) -> ResultTable:
    """Return the table of the fill protocol, in whole and in parts."""
    lines = tuple(
        (
            row["method"],
            spread(row["s"]),
            number(row["rig_time_s"]),
            "-" if row["times_faster"] is None else spread(row["times_faster"]),
        )
        for row in of_kind(rows, "fill")
    )
    return ResultTable(
        "fill",
        "The fill protocol, 160 runs",
        ("what", "s", "rig time s", "times faster"),
        lines,
        ("what",),
    )


def parts_table(rows: Sequence[Row]) -> ResultTable:
    """Return the table of the parts of the rig."""
    lines = tuple(
        (
            row["problem"],
            row["method"],
            spread(row["ms"]),
            "0" if row["error"] == 0.0 else f"{row['error']:.1e}",
            number(row["memory_kB"], 2),
        )
        for row in of_kind(rows, "part")
    )
    return ResultTable(
        "parts",
        "Parts beside their rivals",
        ("part", "method", "ms", "error", "kB"),
        lines,
        ("part", "method"),
    )


def exponents_table(rows: Sequence[Row]) -> ResultTable:
    """Return the table of the growth of cost with size."""
    lines = tuple(
        (
            row["axis"],
            row["what"],
            f"{row['sizes'][0]:g} to {row['sizes'][1]:g}",
            f"{row['exponent']:.2f} +- {2.0 * row['error']:.2f}",
            yes_or_no(row["at_most_linear"]),
        )
        for row in of_kind(rows, "exponent")
    )
    return ResultTable(
        "exponents",
        "How cost grows: time ~ size^exponent",
        ("axis", "what", "sizes", "exponent", "at most linear"),
        lines,
        ("axis", "what", "sizes", "at most linear"),
    )


def sizes_table(rows: Sequence[Row]) -> ResultTable:
    """Return the table of times at each size."""
    lines = tuple(
        (row["axis"], f"{row['size']:g}", spread(row["ms"])) for row in of_kind(rows, "scaling")
    )
    return ResultTable(
        "sizes", "Times behind the exponents", ("axis", "size", "ms"), lines, ("axis",)
    )


def break_even(compiling: float, own: float, rival: float) -> float | None:
    """Return the cycles after which compiling (s) has paid, from costs in microseconds per cycle;
    None for never.
    """
    return compiling / (1e-6 * (rival - own)) if rival > own else None


def compiling_table(rows: Sequence[Row]) -> ResultTable:
    """Return the compiling times, and the cycles of a slider after which they have paid against
    scipy, which compiles nothing.
    """
    own = {method: _mean_cost(rows, (method,)) for method in SHORT}
    scipy = _mean_cost(rows, [name for name in SHORT if name.startswith("solve_ivp")])
    lines = []
    for row in of_kind(rows, "compiling"):
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
            cost = cost_of(own_rows(precise, problem, method), wanted)
            if cost is not None:
                costs.append(cost)
        if not costs:
            return None
        best.append(min(costs))
    return sum(best) / len(best) if best else None


def memory_table(rows: Sequence[Row]) -> ResultTable:
    """Return the table of the peak memory."""
    lines = tuple(
        (row["problem"], row["method"], number(row["writer_MB"]), number(row["worker_MB"]))
        for row in of_kind(rows, "memory")
    )
    return ResultTable(
        "memory",
        "Peak memory",
        ("what", "record", "writer MB", "worker MB"),
        lines,
        ("what", "record"),
    )
