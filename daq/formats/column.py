"""A column of a file with all that the file states of it: unit, scale, rate, start, abscissa."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from daq.documents.shapes import Number
from daq.expansion import ALWAYS, TIMES, most_unpacked
from daq.formats.wave import FormatError

__all__ = [
    "RATE",
    "FileColumn",
    "Instant",
    "by_columns",
    "hertz",
    "instant_of",
    "name_of",
    "numbers",
    "refuse_large",
    "scaled",
]

RATE = Number(1e-6, 1e9)
REAL = "fiu"  # kinds of numpy's types that are real numbers
SHOWN = 20  # names listed in a message
DIGITS = {2: 1e-3, 4: 6e-8, 8: 1.2e-16}  # relative resolution of floats by their size in bytes
Scale = tuple[float, float]


@dataclass(frozen=True)
class Instant:
    """A time: whole seconds (since 1970 where the file tells a date), and the rest in s. Two fields,
    since one float has a resolution of 0.2 us at today's dates. `text`: as the file tells it.
    """

    whole: int
    part: float
    text: str

    def after(self, other: "Instant") -> float:
        """Return the seconds from another instant to this one."""
        return (self.whole - other.whole) + (self.part - other.part)


@dataclass(frozen=True, eq=False)
class FileColumn:
    """A column of a file and what the file states of it; None and "" stand for nothing.

    samples : scaled where the file states a scale
    rate : Hz
    unit : in the file's words; `unit_at`: where it stands
    skipped_unit : one that stands in lines which the mapping leaves out
    start : of the first sample
    times : an abscissa that stands beside every sample, s
    codes : whole numbers of a converter, for which the file states no scale
    resolution : largest rounding of the samples by digits or type, in their unit
    told : further statements that were used, as sentences
    """

    samples: npt.NDArray[np.float64]
    rate: float | None = None
    unit: str = ""
    unit_at: str = ""
    skipped_unit: str = ""
    start: Instant | None = None
    times: "FileColumn | None" = None
    codes: bool = False
    resolution: float = 0.0
    told: tuple[str, ...] = ()


def name_of(path: Path, names: Sequence[str], name: str, what: str = "column") -> str:
    """Return the column with this name, or at this position (from 1).

    Raises FormatError where there is none, or several of that name.
    """
    same = [number for number, one in enumerate(names, start=1) if one == name]
    if len(same) > 1:
        places = ", ".join(map(str, same))
        raise FormatError(
            f"{path}: the name {name!r} is not unique: {what}s {places} have it; write the number in the mapping"
        )
    if same:
        return name
    if name.isdecimal() and 1 <= int(name) <= len(names):
        return names[int(name) - 1]
    raise FormatError(f"{path} has no {what} {name!r}; it has {', '.join(names[:SHOWN]) or 'none'}")


def hertz(path: Path, what: str, value: Any) -> float:
    """Return a sampling rate (Hz) stated by the file.

    Raises FormatError unless it is a plausible number.
    """
    plain = value.item() if isinstance(value, np.generic) else value
    if not RATE.holds(plain):
        raise FormatError(f"{path}: {what} is {plain!r:.40}, expected {RATE} (Hz)")
    return float(plain)


def numbers(path: Path, name: str, values: Any) -> FileColumn:
    """Return real numbers as a column of float64; codes where they are whole numbers.

    Raises FormatError for anything else: complex numbers (no part of them is dropped), text, truth
    values.
    """
    array = np.asarray(values)
    if array.dtype.kind == "c":
        raise FormatError(
            f"{path}: {name} holds complex numbers (a spectrum?); a record has real ones"
        )
    if array.dtype.kind not in REAL:
        raise FormatError(f"{path}: {name} holds {array.dtype}, not real numbers")
    flat = np.ascontiguousarray(array, dtype=np.float64).ravel()
    resolution = 0.0
    if array.dtype.kind == "f" and flat.size:
        resolution = DIGITS.get(array.dtype.itemsize, 0.0) * float(np.abs(flat).max(initial=0.0))
    return FileColumn(flat, codes=array.dtype.kind in "iu", resolution=resolution)


def scaled(path: Path, column: FileColumn, scale: Scale | None, source: str) -> FileColumn:
    """Return a column times a scale plus an offset that the file states under the name `source`;
    the same column for None.

    Raises FormatError where they are no numbers, or the scale is 0.
    """
    if scale is None:
        return column
    slope, offset = scale
    if not (math.isfinite(slope) and math.isfinite(offset)) or slope == 0:
        raise FormatError(f"{path}: {source} is {slope!r}, offset {offset!r}: no scale")
    return replace(
        column,
        samples=column.samples * slope + offset,
        codes=False,
        resolution=column.resolution * abs(slope),
        told=(*column.told, f"{source} {slope:.6g}, offset {offset:.6g}"),
    )


def instant_of(path: Path, text: str) -> Instant:
    """Return the instant that a text in ISO 8601 tells. FormatError for another text."""
    try:
        moment = datetime.fromisoformat(text.strip())
    except ValueError as error:
        raise FormatError(f"{path}: the start {text!r:.60} is no time in ISO 8601") from error
    if moment.tzinfo is None:
        moment = moment.replace(tzinfo=UTC)
    day = moment.replace(microsecond=0)
    return Instant(int(day.timestamp()), moment.microsecond * 1e-6, text.strip())


def refuse_large(path: Path, packed: int, unpacked: int) -> None:
    """Raise FormatError where a file would unpack to far more bytes than a record does."""
    if unpacked > most_unpacked(packed):
        raise FormatError(
            f"{path} would unpack from {packed} bytes to {unpacked} or more; at most {TIMES} times as many are "
            f"unpacked, or {ALWAYS}"
        )


def by_columns(
    arrays: Mapping[str, npt.NDArray[Any]], columns: Mapping[str, FileColumn]
) -> dict[str, FileColumn]:
    """Return vectors by name, and each column of a matrix, along its longer side, as "name#1",
    "name#2", ...; `columns` holds the values of each array as one column.
    """
    found = {}
    for name, array in arrays.items():
        shape: tuple[int, ...] = np.atleast_1d(np.squeeze(array)).shape
        whole = columns[name]
        if len(shape) == 1:
            found[name] = whole
        elif len(shape) == 2:
            table = whole.samples.reshape(shape)
            upright = table if table.shape[0] >= table.shape[1] else table.T
            found |= {
                f"{name}#{n + 1}": replace(whole, samples=np.ascontiguousarray(upright[:, n]))
                for n in range(upright.shape[1])
            }
    return found
