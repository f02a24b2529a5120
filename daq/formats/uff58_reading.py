"""Read time records from universal files: sets 58 (ASCII, and binary of either byte order), with
the units of a set 164 before them.

Layout: SDRC I-DEAS Test Data Acquisition, "Universal Dataset Number 58", "Number 164". Binary sets
state their size, so that a mark of the end inside the numbers misleads nobody.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import BinaryIO

import numpy as np
import numpy.typing as npt

from daq.formats.column import FileColumn, Instant, hertz, name_of
from daq.formats.wave import FormatError
from daq.regular_files import open_regular

__all__ = ["read_uff58"]

MARK = b"-1"
LINES = 11  # of the head of a set 58
TIME_RESPONSE, GENERAL = 1, 0  # function types
SECONDS = 17  # specific data type of a time axis
FUNCTIONS = {
    0: "general", 1: "time response", 2: "auto spectrum", 3: "cross spectrum",
    4: "frequency response", 6: "coherence", 9: "power spectral density", 12: "spectrum",
}  # fmt: skip
ORDINATES = {2: ("f4", False), 4: ("f8", False), 5: ("f4", True), 6: ("f8", True)}
"""Ordinate data types: type, and whether the numbers are complex."""

DIRECTIONS = {0: "", 1: "+X", -1: "-X", 2: "+Y", -2: "-Y", 3: "+Z", -3: "-Z"}
QUANTITIES = {8: (1, 0), 9: (0, 1), 11: (1, 0), 12: (1, 0), 13: (0, 1)}
"""Specific data types with the exponents of length and force in their unit."""

NO_UNIT = {"", "NONE"}
SINGLE_STEP = 1e-5  # relative resolution of a step with six digits


@dataclass(frozen=True, eq=False)
class _Units:
    """Units of a set 164: words, and factors from SI to the file's units."""

    text: str
    length: float
    force: float


@dataclass(frozen=True, eq=False)
class _Set:
    """The head of a set 58, and its numbers not yet read.

    ids : ID lines 1 to 5
    function, node, direction : of the response
    ordinate, count, even, first, step : of record 7
    axis, unit : specific data type and unit label of abscissa and ordinate
    data : position of the first number; size: bytes to the end; binary: "<" or ">", "" for ASCII
    """

    ids: tuple[str, ...]
    function: int
    node: int
    direction: int
    ordinate: int
    count: int
    even: bool
    first: float
    step: float
    axis: tuple[int, int]
    unit: tuple[str, str]
    data: int
    size: int
    binary: str
    units: _Units | None

    @property
    def is_time(self) -> bool:
        """Whether the function is a record in time."""
        return self.function == TIME_RESPONSE or (
            self.function == GENERAL and self.axis[0] == SECONDS
        )


def read_uff58(path: Path, wanted: Sequence[str]) -> dict[str, FileColumn]:
    """Return time records by the first ID line, by "node:direction", or by their position from 1
    among them.

    Raises FormatError for a malformed file, complex numbers, and a name that several sets have.
    """
    with open_regular(path) as file:
        every = list(_sets(path, file))
        times = [one for one in every if one.is_time]
        if not times:
            kinds = sorted({FUNCTIONS.get(one.function, str(one.function)) for one in every})
            raise FormatError(
                f"{path} holds no record in time; its {len(every)} sets 58 are: {', '.join(kinds) or 'none'}"
            )
        return {name: _column(path, file, _chosen(path, times, name)) for name in wanted}


def _chosen(path: Path, sets: Sequence[_Set], name: str) -> _Set:
    """Return the set of a name or a position."""
    ids = [one.ids[0] for one in sets]
    places = [f"{one.node}:{DIRECTIONS.get(one.direction, one.direction)}" for one in sets]
    if ids.count(name) > 1:
        listed = ", ".join(f"{n} ({place})" for n, place in enumerate(places, 1))
        raise FormatError(
            f"{path}: the name {name!r} is not unique: {ids.count(name)} sets have it as first ID line; write a set's number "
            f"in the mapping, or node:direction: {listed}"
        )
    if name in ids:
        return sets[ids.index(name)]
    if name in places:
        return sets[places.index(name_of(path, places, name, "set"))]
    if name.isdecimal() and 1 <= int(name) <= len(sets):
        return sets[int(name) - 1]
    names = [
        f"{n} ({one}, {place})" for n, (one, place) in enumerate(zip(ids, places, strict=True), 1)
    ]
    raise FormatError(f"{path} has no record {name!r}; it has {', '.join(names[:20])}")


def _sets(path: Path, file: BinaryIO) -> Iterator[_Set]:
    """Yield the heads of all sets 58, with the units of the last set 164 before each."""
    units = None
    while line := file.readline(200):
        if line.strip() != MARK:
            continue
        kind = file.readline(200)
        word = kind[:6].strip()
        if word == b"58":
            found = _head(path, file, kind, units)
            yield found
            file.seek(found.data + found.size)
            _skip(file)
        elif word == b"164":
            units = _units(path, file)
            _skip(file)
        else:
            _skip(file)


def _skip(file: BinaryIO) -> None:
    """Read on to the end mark of a set."""
    while (line := file.readline(4096)) and line.strip() != MARK:
        pass


def _units(path: Path, file: BinaryIO) -> _Units:
    """Return the units of a set 164."""
    head = _text(file.readline(200))
    factors = _text(file.readline(200)).upper().replace("D", "E").split()
    try:
        length, force = float(factors[0]), float(factors[1])
    except (ValueError, IndexError) as error:
        raise FormatError(f"{path}: the set 164 states no factors: {factors}") from error
    if not (length > 0 and force > 0 and math.isfinite(length) and math.isfinite(force)):
        raise FormatError(f"{path}: the set 164 has factors {length:g} and {force:g}")
    return _Units(head[10:30].strip(), length, force)


def _text(line: bytes) -> str:
    return line.decode("latin-1").rstrip("\r\n")


def _head(path: Path, file: BinaryIO, kind: bytes, units: _Units | None) -> _Set:
    """Return the head of a set 58 whose first line has been read."""
    binary, size = "", 0
    if kind[6:7].lower() == b"b":
        fields = kind[7:].split()
        try:
            order, real, size = int(fields[0]), int(fields[1]), int(fields[3])
        except (ValueError, IndexError) as error:
            raise FormatError(f"{path}: the head of a binary set 58 is {kind[:80]!r}") from error
        if order not in (1, 2) or real != 2:
            raise FormatError(
                f"{path}: a binary set 58 has byte order {order} and numbers of kind {real}; 1 or 2, and 2 (IEEE 754), are read"
            )
        binary = "<" if order == 1 else ">"
    lines = [_text(file.readline(200)) for _ in range(LINES)]
    try:
        six, seven = lines[5], lines[6]
        return _Set(
            ids=tuple(line.strip() for line in lines[:5]),
            function=int(six[0:5]),
            node=int(six[41:51] or 0),
            direction=int(six[51:55] or 0),
            ordinate=int(seven[0:10]),
            count=int(seven[10:20]),
            even=int(seven[20:30]) == 1,
            first=float(seven[30:43] or 0),
            step=float(seven[43:56] or 0),
            axis=(int(lines[7][0:10]), int(lines[8][0:10])),
            unit=(lines[7][47:67].strip(), lines[8][47:67].strip()),
            data=file.tell(),
            size=size,
            binary=binary,
            units=units,
        )
    except ValueError as error:
        raise FormatError(f"{path}: the head of a set 58 cannot be read: {error}") from error


def _column(path: Path, file: BinaryIO, one: _Set) -> FileColumn:
    """Return the numbers of a set with all that it states."""
    kind, is_complex = ORDINATES.get(one.ordinate, ("", False))
    if not kind or is_complex:
        what = (
            "complex numbers (a spectrum?)" if is_complex else f"ordinates of type {one.ordinate}"
        )
        raise FormatError(f"{path}: the set {one.ids[0]!r} holds {what}; a record has real ones")
    if one.count < 2:
        raise FormatError(f"{path}: the set {one.ids[0]!r} says {one.count} values")
    table = _binary(path, file, one, kind) if one.binary else _ascii(path, file, one)
    values = np.ascontiguousarray(table[:, -1], dtype=np.float64)
    column = _with_unit(one, FileColumn(values))
    if not one.even:
        times = np.ascontiguousarray(table[:, 0], dtype=np.float64)
        coarse = 3e-7 if kind == "f4" or not one.binary else 1.2e-16
        own = FileColumn(
            times, unit=_label(one.unit[0]) or "s", unit_at="abscissa of the set",
            resolution=coarse * float(np.abs(times).max()),
        )  # fmt: skip
        return replace(column, times=own)
    scale = {"ms": 1e-3, "us": 1e-6}.get(_label(one.unit[0]), 1.0)
    step = one.step * scale
    told = hertz(path, f"the rate of the set {one.ids[0]!r}", 1 / step if step else math.nan)
    return replace(
        column,
        rate=_exact(one, told),
        start=Instant(0, one.first * scale, f"abscissa minimum {one.first * scale:g} s"),
    )


def _exact(one: _Set, rate: float) -> float:
    """Return the rate with all its digits from ID line 3 of our own files; record 7 has six."""
    words = one.ids[2].split()
    if len(words) == 3 and words[0] == "rate" and words[2] == "Hz":
        exact = float(words[1])
        if math.isfinite(exact) and abs(exact / rate - 1) < SINGLE_STEP:
            return exact
    return rate


def _label(label: str) -> str:
    """Return a unit label, "" where it says none."""
    return "" if label.upper() in NO_UNIT else label


def _with_unit(one: _Set, column: FileColumn) -> FileColumn:
    """Return the column in the unit of its label, or in SI by the set 164 before it."""
    where = f"axis label of the set {one.ids[0]!r}"
    label = _label(one.unit[1])
    if label:
        return replace(column, unit=label, unit_at=where)
    exponents = QUANTITIES.get(one.axis[1])
    if one.units is None or exponents is None:
        return column
    factor = one.units.length ** exponents[0] * one.units.force ** exponents[1]
    unit = {8: "m", 9: "N", 11: "m/s", 12: "m/s^2", 13: "N"}[one.axis[1]]
    return replace(
        column,
        samples=column.samples / factor,
        unit=unit,
        unit_at=f"set 164 ({one.units.text})",
        told=(*column.told, f"units of set 164 ({one.units.text}): divided by {factor:g}"),
    )


def _binary(path: Path, file: BinaryIO, one: _Set, kind: str) -> npt.NDArray[np.float64]:
    """Return the numbers of a binary set, (count, 1), or (count, 2) with its abscissa."""
    file.seek(one.data)
    item = int(kind[1])
    # The abscissa is single where the format's text is followed, and as wide as the ordinate
    # where the common programs write it: the stated size tells.
    forms = (
        [[("y", kind)]] if one.even else [[("x", kind), ("y", kind)], [("x", "f4"), ("y", kind)]]
    )
    for form in forms:
        dtype = np.dtype([(name, one.binary + sort) for name, sort in form])
        if one.count * dtype.itemsize <= one.size < one.count * dtype.itemsize + max(item, 8) * 8:
            data = file.read(one.count * dtype.itemsize)
            if len(data) < one.count * dtype.itemsize:
                break
            rows = np.frombuffer(data, dtype)
            return np.stack([rows[name].astype(np.float64) for name, _ in form], axis=1)
    raise FormatError(
        f"{path}: the set {one.ids[0]!r} says {one.count} values in {one.size} bytes, and does not hold them"
    )


def _ascii(path: Path, file: BinaryIO, one: _Set) -> npt.NDArray[np.float64]:
    """Return the numbers of an ASCII set, (count, 1), or (count, 2) with its abscissa; what fills
    the last line beyond the stated count is left out.
    """
    file.seek(one.data)
    wide = 20 if one.ordinate == 4 else 13
    widths = (
        [wide] * (4 if wide == 20 else 6) if one.even else [13, wide] * (3 if wide == 13 else 2)
    )
    wanted = one.count * (1 if one.even else 2)
    found: list[npt.NDArray[np.float64]] = []
    total = 0
    while total < wanted and (line := file.readline(400)) and line.strip() != MARK:
        row = _fields(path, _text(line), widths)
        found.append(row)
        total += row.size
    if total < wanted:
        raise FormatError(
            f"{path}: the set {one.ids[0]!r} says {one.count} values and has {total // (wanted // one.count)}"
        )
    return np.concatenate(found)[:wanted].reshape(one.count, -1)


def _fields(path: Path, line: str, widths: Sequence[int]) -> npt.NDArray[np.float64]:
    """Return the numbers of a line, by blanks where these part them, else by the columns of the
    format.
    """
    words = line.replace("D", "E").replace("d", "e").split()
    try:
        return np.array(words, dtype=np.float64)
    except ValueError:
        edges = np.cumsum([0, *widths])
        cut = [line[a:b].strip() for a, b in pairwise(edges)]
        try:
            return np.array([word.replace("D", "E") for word in cut if word], dtype=np.float64)
        except ValueError as error:
            raise FormatError(f"{path}: a set 58 holds {line[:60]!r}, no numbers") from error
