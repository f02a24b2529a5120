"""Plain tables and numbers for the terminal; readable at 80 columns and without colour."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table


def number(value: Any, digits: int = 3) -> str:
    """A number to some digits, a dash for nothing."""
    if value is None:
        return "-"
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value)
    return f"{value:.{digits}g}"


def percent(value: float | None) -> str:
    """A fraction as a signed percentage, a dash for nothing."""
    return "-" if value is None else f"{100 * value:+.1f} %"


def table(title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], left: Sequence[str] = ()) -> Table:
    """A table with numbers on the right and the columns named in `left` on the left."""
    found = Table(title=title, title_justify="left", box=None, pad_edge=False)
    for column in columns:
        found.add_column(column, justify="left" if column in left else "right")
    for row in rows:
        found.add_row(*row)
    return found


def print_report(console: Console, report: Mapping[str, Any]) -> None:
    """The verdict table of a run: a line per condition, the agreement, the nulls, the verdict and its reasons."""
    rows = (
        (
            c["id"], c["material"], c["bed"], f"{c['fill']:.0%}", number(c["diameter"] * 1e3),
            number(c["acceleration"]), number(c["W_exp"]), number(c["U_W_exp"], 2), number(c["W_T"]),
            percent(c["offset"]), number(c["E_n_chain"], 2),
        )
        for c in report["conditions"]
    )  # fmt: skip
    columns = ("id", "grains", "bed", "fill", "d/mm", "a", "W_exp/J", "U/J", "W_T/J", "offset", "E_n chain")
    console.print(table("", columns, rows, ("id", "grains", "bed")))
    agreement = report["agreement"]
    if agreement["ratio"] is not None:
        console.print(
            f"\nSum of W_exp over sum of W_T: {agreement['ratio']:.3f} +- {agreement['U_ratio']:.3f} "
            f"(mean offset {percent(agreement['mean_offset'])} over {agreement['n']} conditions)"
        )
    console.print(f"tests: {report['tests']}; waveform: {report['waveform']} (ideal waveform assumed in servo drive)")
    for null in report["nulls"]:
        console.print(f"null {null['null']}: {null['verdict']} ({null['why']})")
    closure = report["ledger"]["closure_max"]
    if closure is not None:
        console.print(f"ledger closes to {closure:.1e}")
    console.print(f"verdict: {report['verdict']}")
    for reason in report["reasons"]:
        console.print(f"  {reason}")
