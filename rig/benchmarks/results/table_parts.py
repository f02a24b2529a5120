"""A table of results, and the numbers and words in its cells."""

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


class ResultTable(NamedTuple):
    """A table of results: `name` is its place on the page, `left` the columns of words."""

    name: str
    title: str
    columns: tuple[str, ...]
    lines: tuple[tuple[str, ...], ...]
    left: tuple[str, ...] = ()


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


def cost_of(own: Sequence[Row], wanted: float) -> float | None:
    """Return a method's microseconds per cycle at the error `wanted`, None if not reached."""
    if not own:
        return None
    cost = cost_at(
        wanted, [row["error"] for row in own], [row["us_per_cycle"]["median"] for row in own]
    )
    return cost.seconds if cost.reached else None


def succeeded(rows: Sequence[Row]) -> list[Row]:
    """Return the rows of the work-precision curves without those of failed methods."""
    return [row for row in of_kind(rows, "precision") if row["failure"] is None]


def yes_or_no(held: bool | None) -> str:
    """Return the answer in words, a dash for None."""
    if held is None:
        return "-"
    return "yes" if held else "no"


def of_kind(rows: Sequence[Row], kind: str) -> list[Row]:
    """Return the rows of one kind."""
    return [row for row in rows if row["kind"] == kind]


def verdict(held: bool) -> str:
    """Return whether a claim held, in words."""
    return "held" if held else "not held"
