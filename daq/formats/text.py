"""Read the asked-for columns of a text file of numbers: CSV of instruments and loggers, aligned
columns, LabVIEW measurement files.
"""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt

from daq.formats.column import FileColumn, Instant, hertz, name_of
from daq.formats.dialect import CsvStyle, Layout, layout_of, lines_of, split, tail_of
from daq.formats.wave import FormatError
from daq.formats.words import clean, is_clock, stem_of

__all__ = ["read_text"]

LARGEST_TEXT = 2**31  # bytes of a text file, which is read as a whole
TIME = re.compile(
    r"t|time|zeit|temps|tempo|tiempo|timestamp|x_value|sec|seconds|datetime", re.IGNORECASE
)
CLOCK = re.compile(
    r"(?P<date>.*?)[\sT]*(?P<h>\d{1,2}):(?P<m>\d{2}):(?P<s>\d{2}(?:[.,]\d+)?)\s*(?P<half>[AaPp][Mm])?(?:Z|[-+]\d{2}:?\d{2})?"
)
HALF_DAY, DAY = 43200.0, 86400.0


def read_text(path: Path, wanted: Sequence[str], style: CsvStyle) -> dict[str, FileColumn]:
    """Return the wanted columns by header, header without its unit, or position from 1; with each,
    as `times`, the file's time column where it has one that was not asked for.

    Raises FormatError for a line that does not hold what it should, naming line and word.
    """
    if path.stat().st_size > LARGEST_TEXT:
        raise FormatError(f"{path} is larger than 2 GiB: cut it into records")
    layout = layout_of(path, style)
    names = list(layout.names)
    at = {name: _place(path, layout, names, name) for name in wanted}
    beside = _time_beside(layout, set(at.values()))
    places = sorted({*at.values(), *([] if beside is None else [beside])})
    found = _columns(path, layout, places)
    columns = {n: _with_facts(path, layout, n, found[n]) for n in places}
    times = None if beside is None else columns[beside]
    return {
        name: replace(columns[n], times=None if n == beside else times) for name, n in at.items()
    }


def _place(path: Path, layout: Layout, names: Sequence[str], name: str) -> int:
    """Return the column of a name, with or without its unit, or of a position from 1."""
    if name not in names:
        stems = [stem_of(header) for header in names]
        if stems.count(name) == 1:
            return stems.index(name)
        if name.isdecimal() and 1 <= int(name) <= layout.width:
            return int(name) - 1
    return names.index(name_of(path, names, name))


def _time_beside(layout: Layout, asked: set[int]) -> int | None:
    """Return a column whose header says time and that nobody asked for, None for none."""
    if any(TIME.fullmatch(stem_of(layout.names[n])) for n in asked):
        return None
    for n, header in enumerate(layout.names):
        words = [row[n] for row in layout.rows if len(row) > n]
        filled = bool(words) and all(
            clean(word, layout.decimal) is not None or is_clock(word) for word in words
        )
        if n not in asked and filled and TIME.fullmatch(stem_of(header)):
            return n
    return None


def _columns(
    path: Path, layout: Layout, places: Sequence[int]
) -> dict[int, npt.NDArray[np.float64] | list[str]]:
    """Return the columns at some places: numbers, or words that tell a time of day."""
    clocks = [n for n in places if any(is_clock(row[n]) for row in layout.rows[:5])]
    if not clocks and not layout.quoted:
        try:
            lines = _checked(path, layout)
            values = np.loadtxt(
                lines,
                delimiter=None if layout.delimiter == " " else layout.delimiter,
                usecols=places,
                ndmin=2,
                dtype=np.float64,
            )
            return {n: np.ascontiguousarray(values[:, k]) for k, n in enumerate(places)}
        except ValueError:
            pass  # a word that needs a closer look: it is read again, and named if it is wrong
    words = _words(path, layout, places)
    found: dict[int, npt.NDArray[np.float64] | list[str]] = {}
    for n in places:
        if n in clocks:
            found[n] = [word for _, word in words[n]]
        else:
            found[n] = np.array([_number(path, layout, n, *word, words[n]) for word in words[n]])
    return found


def _checked(path: Path, layout: Layout) -> Iterator[str]:
    """Yield the lines of numbers with a decimal point. ValueError for a line that has a sign of
    thousands, another number of columns, or that is empty with others after it.
    """
    comma, delimiter = layout.decimal == ",", layout.delimiter
    fields: int | None = None
    empty = False
    for number, line in enumerate(lines_of(path, layout.encoding), 1):
        if number < layout.first:
            continue
        if line.isspace():
            empty = True
            continue
        if empty:
            raise ValueError
        if comma:
            if "." in line:
                raise ValueError
            line = line.replace(",", ".")
        if delimiter != " ":
            count = line.count(delimiter)
            fields = count if fields is None else fields
            if count != fields and not line.lstrip().startswith("#"):
                raise ValueError
        yield line


def _words(path: Path, layout: Layout, places: Sequence[int]) -> dict[int, list[tuple[int, str]]]:
    """Return the words of some columns with their lines."""
    found: dict[int, list[tuple[int, str]]] = {n: [] for n in places}
    empty, quoted = 0, layout.quoted and layout.delimiter != " "
    for number, line in enumerate(lines_of(path, layout.encoding), 1):
        if number < layout.first or line.lstrip().startswith("#"):
            continue
        if line.isspace():
            empty = empty or number
            continue
        if empty:
            raise FormatError(
                f"{path}: line {empty} is empty with numbers after it: a record may have no gap"
            )
        row = split(line, layout.delimiter, quoted)
        if len(row) not in (layout.width, layout.width + 1) or any(row[layout.width :]):
            raise FormatError(
                f"{path}: line {number} has {len(row)} columns, the others have {layout.width}"
            )
        for n in places:
            found[n].append((number, row[n]))
    return found


def _number(
    path: Path, layout: Layout, n: int, line: int, word: str, every: Sequence[tuple[int, str]]
) -> float:
    """Return the number of a word. FormatError where it is none, or missing."""
    name = layout.names[n] or str(n + 1)
    if not word:
        empty = sum(not other for _, other in every)
        reason = "a record may have no gap"
        if empty > 0.3 * len(every):
            share = len(every) / (len(every) - empty) if empty < len(every) else math.inf
            reason = (
                f"{empty} of its {len(every)} cells are, as if it had {share:.3g} times fewer samples than other "
                "columns: the channels have two rates; export them with one"
            )
        raise FormatError(f"{path}: column {name} is empty at line {line}: {reason}")
    cleaned = clean(word, layout.decimal)
    if cleaned is None:
        raise FormatError(
            f"{path}: column {name} has {word[:40]!r} at line {line}, no number with the decimal sign {layout.decimal!r}"
        )
    return float(cleaned.replace("d", "e").replace("D", "e"))


def _with_facts(
    path: Path, layout: Layout, n: int, values: npt.NDArray[np.float64] | list[str]
) -> FileColumn:
    """Return a column with its unit and with what a header tells of its time scale."""
    if isinstance(values, list):
        return _clock(path, layout, n, values)
    step = layout.steps[n] if n < len(layout.steps) else math.nan
    start = layout.starts[n] if n < len(layout.starts) else math.nan
    return FileColumn(
        values,
        rate=None if not step > 0 else hertz(path, "1 / Delta_X", 1 / step),
        unit=layout.units[n],
        unit_at=layout.units_at,
        skipped_unit=layout.skipped[n] if layout.skipped else "",
        codes=not layout.units[n] and _whole(layout, n),
        start=None if math.isnan(start) else Instant(0, start, f"X0 {start:g} s"),
        resolution=_resolution(path, layout, n),
    )


def _whole(layout: Layout, n: int) -> bool:
    """Return whether all numbers of a column are written as whole ones, some of them large."""
    words = [row[n] for row in layout.rows if len(row) > n]
    whole = all(re.fullmatch(r"[-+]?\d+", word) for word in words)
    return whole and any(len(word.strip("+-")) > 2 for word in words)


def _resolution(path: Path, layout: Layout, n: int) -> float:
    """Return the largest rounding of a column's numbers by their digits, from the last lines, where
    times have the fewest.
    """
    digits, power = 0, 0
    for line in tail_of(path, layout.encoding)[-20:-1]:
        row = split(line, layout.delimiter, layout.quoted and layout.delimiter != " ")
        word = clean(row[n], layout.decimal) if len(row) > n else None
        if word is None or not word.strip("+-")[:1].isdigit():
            continue
        mantissa, _, exponent = word.lower().partition("e")
        digits = max(digits, len(mantissa.partition(".")[2]))
        power = max(power, int(exponent)) if exponent else power
    return float(0.5 * 10.0 ** (power - digits))


def _clock(path: Path, layout: Layout, n: int, words: Sequence[str]) -> FileColumn:
    """Return clock times as seconds after the first, over midnights."""
    seconds = np.empty(len(words))
    digits = 0
    for k, word in enumerate(words):
        told = CLOCK.fullmatch(word)
        if told is None:
            raise FormatError(
                f"{path}: column {layout.names[n] or n + 1} has {word[:40]!r} in row {k + 1} of the numbers, no time"
            )
        hours = int(told["h"])
        if told["half"]:
            hours = hours % 12 + (12 if told["half"].lower() == "pm" else 0)
        second = told["s"].replace(",", ".")
        digits = max(digits, len(second.partition(".")[2]))
        seconds[k] = 3600 * hours + 60 * int(told["m"]) + float(second)
    days = np.concatenate(([0.0], np.cumsum(np.diff(seconds) < -HALF_DAY))) * DAY
    return FileColumn(
        seconds - seconds[0] + days,
        unit="s",
        unit_at=f"times of day as {words[0]!r}",
        resolution=0.5 * 10.0**-digits,
    )
