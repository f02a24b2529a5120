"""Tables and their cells: the displayed text, and the number to sort by."""

import math
from dataclasses import dataclass

__all__ = ["UNBOUNDED", "UNKNOWN", "Cell", "Table", "fixed", "number", "significant", "with_U"]


@dataclass(frozen=True, slots=True)
class Cell:
    """A table cell.

    text : as displayed
    value : number to sort by; None for text
    numeric : set among the numbers, without a value
    """

    text: str
    value: float | None = None
    numeric: bool = False


@dataclass(frozen=True, slots=True)
class Table:
    """A titled table with a note; without rows it is not shown."""

    title: str
    note: str
    head: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]


UNKNOWN = Cell("–", numeric=True)
UNBOUNDED = Cell("∞", math.inf)


def significant(value: float, digits: int) -> str:
    """Return a number to `digits` significant digits, with an exponent only in place of a row of
    zeros.
    """
    if value == 0 or not 1e-4 <= abs(value) < 1e6:
        return f"{value:.{digits}g}"
    value = float(f"{value:.{digits}g}")
    places = digits - 1 - math.floor(math.log10(abs(value)))
    return f"{value:.{max(0, places)}f}"


def number(value: float | None, digits: int = 3, scale: float = 1.0) -> Cell:
    """Return a cell with a number to `digits` significant digits; a dash for None."""
    return UNKNOWN if value is None else Cell(significant(value * scale, digits), value * scale)


def fixed(value: float | None, places: int) -> Cell:
    """Return a cell with a number to `places` decimal places; a dash for None."""
    if value is None:
        return UNKNOWN
    return Cell(_rounded(value, places), value)


def with_U(value: float | None, U: float | None, scale: float = 1.0) -> Cell:
    """Return a cell with value ± U, U to two significant digits and the value to the same place."""
    if value is None or U is None or U == 0:
        return number(value, 4, scale)
    value, U = value * scale, U * scale
    places = max(0, 1 - math.floor(math.log10(U)))
    if places > 6:  # an exponent is shorter than the row of zeros
        return Cell(f"{value:.3g} ± {U:.2g}", value)
    return Cell(f"{_rounded(value, places)} ± {U:.{places}f}", value)


def _rounded(value: float, places: int) -> str:
    """Return a number to `places` decimal places, without a minus before zero."""
    text = f"{value:.{places}f}"
    return text if float(text) else text.removeprefix("-")
