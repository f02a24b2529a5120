"""Read variables of MATLAB files: version 4 to 7, and 7.3, which is HDF5; fields of structs by
"rec.F".
"""

import math
import os
import struct
import zlib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from daq.expansion import ALWAYS, DEFLATE
from daq.formats.column import FileColumn, by_columns, hertz, name_of, numbers, refuse_large
from daq.formats.hdf5_reading import read_hdf5
from daq.formats.wave import FormatError
from daq.regular_files import open_regular

__all__ = ["read_mat"]

PIECE = 2**20  # bytes unpacked at a time to count them
MAT_HEAD, MAT_PACKED = 128, 15  # header length in bytes; type number of a compressed element
RATES, STEPS = ("fs", "Fs", "FS", "sampling_rate", "sample_rate", "samplerate"), ("dt", "Ts")
UNITS = "units"
NUMBERS = "fiu"


def read_mat(path: Path, wanted: Sequence[str]) -> dict[str, FileColumn]:
    """Return numeric variables, columns of matrices as "name#1", and fields of structs as "rec.F".
    `fs` (Hz) or `dt` (s) beside a variable is its rate, `units.F` the unit of F.

    Raises FormatError for cells, struct arrays, and anything that is no real number.
    """
    with open_regular(path) as file:
        version = file.read(10)
    if version == b"MATLAB 7.3":
        dotted = {name: name.replace(".", "/") for name in wanted}
        found = read_hdf5(path, list(dotted.values()))
        return {name: found[place] for name, place in dotted.items()}
    from scipy import io as matlab

    room = _unpacked_mat(path)
    reader: Any = matlab
    listed = {}
    for name, shape, kind in reader.whosmat(path):
        if math.prod(map(int, shape)) > room:
            raise FormatError(f"{path}: {name} claims {shape} values, more than the file holds")
        listed[name] = kind
    tops = {name.partition("#")[0].partition(".")[0] for name in wanted if not name.isdecimal()}
    told = {*RATES, *STEPS, UNITS}
    plain = {name for name, kind in listed.items() if kind not in ("struct", "cell", "object")}
    names = sorted(plain | ({*tops, UNITS} & listed.keys()) | (told & plain))
    values = reader.loadmat(path, variable_names=names, simplify_cells=False) if names else {}
    flat = {name: value for name, value in _fields(path, values) if not name.startswith("__")}
    found = {}
    for name in wanted:
        found[name] = _column(path, flat, name)
    return found


def _fields(path: Path, values: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield variables and the fields of structs, which stand behind a point."""
    for name, value in values.items():
        fields = getattr(getattr(value, "dtype", None), "names", None)
        if not fields:
            yield name, value
        elif value.size == 1:
            inside = {f"{name}.{field}": value.ravel()[0][field] for field in fields}
            yield from _fields(path, inside)
        else:
            yield name, value


def _column(path: Path, flat: Mapping[str, Any], name: str) -> FileColumn:
    """Return a variable, a field, or a column of one, with the rate and the unit beside it."""
    whole = name.partition("#")[0]
    numeric = {
        key: value
        for key, value in flat.items()
        if isinstance(value, np.ndarray) and value.dtype.kind in NUMBERS and value.size > 1
    }
    if whole in flat and whole not in numeric:
        value = flat[whole]
        if getattr(value.dtype, "names", None):
            raise FormatError(
                f"{path}: {whole} is a struct array of {value.size} elements; save the record as numbers: "
                "save('r.mat', 'F', 'a', 'fs')"
            )
        if value.dtype.kind not in NUMBERS:
            numbers(path, whole, value)  # which says what it is
    if whole not in numeric:
        columns = [one for key in numeric for one in _names(key, numeric[key])]
        whole = name_of(path, columns, name, "variable")
        return _column(path, flat, whole)
    value = numeric[whole]
    told = by_columns({whole: value}, {whole: numbers(path, whole, value)})
    chosen = told[
        name_of(path, list(told), name, "column") if name in told or len(told) > 1 else whole
    ]
    parent, _, last = whole.rpartition(".")
    unit = _text(flat.get(f"{parent}.{UNITS}.{last}" if parent else f"{UNITS}.{last}"))
    return FileColumn(
        chosen.samples,
        rate=_rate(path, flat, parent),
        unit=unit,
        unit_at=f"{UNITS}.{last}" if unit else "",
        codes=chosen.codes,
        resolution=chosen.resolution,
    )


def _names(name: str, value: Any) -> list[str]:
    """Return the columns of a variable by name."""
    shape = np.squeeze(value).shape
    return [name] if len(shape) < 2 else [f"{name}#{n + 1}" for n in range(min(shape))]


def _text(value: Any) -> str:
    """Return the text in a MATLAB variable, "" for none."""
    array = np.asarray([] if value is None else value).ravel()
    return str(array[0]).strip() if array.size == 1 and array.dtype.kind == "U" else ""


def _rate(path: Path, flat: Mapping[str, Any], parent: str) -> float | None:
    """Return the rate beside a variable, or at the top. FormatError where several differ."""
    found: dict[str, float] = {}
    for place in dict.fromkeys((f"{parent}." if parent else "", "")):
        for key in (*RATES, *STEPS):
            value = flat.get(place + key)
            if isinstance(value, np.ndarray) and value.size == 1 and value.dtype.kind in NUMBERS:
                number = value.ravel()[0]
                if key in STEPS:
                    number = 1 / number if number else math.nan
                found[place + key] = hertz(path, place + key, number)
        if found:
            break
    if found and max(found.values()) > min(found.values()) * (1 + 1e-5):
        said = ", ".join(f"{key} {value:g} Hz" for key, value in found.items())
        raise FormatError(f"{path} states several rates: {said}")
    return next(iter(found.values()), None)


def _unpacked_mat(path: Path) -> int:
    """Return the bytes to which a MATLAB file of version 4 to 7 unpacks, counted piece by piece
    without keeping them.

    Raises FormatError as soon as there are too many. The sizes stated in the file are not trusted.
    """
    size = path.stat().st_size
    with open_regular(path) as file:
        head = file.read(MAT_HEAD)
        if len(head) < MAT_HEAD or head[-2:] not in (b"IM", b"MI"):
            return size  # version 4 packs nothing
        order = "<" if head[-2:] == b"IM" else ">"
        # No compressed file of this size can exceed the limit: counting is not needed.
        if DEFLATE * size <= ALWAYS:
            return DEFLATE * size
        unpacked = size
        while len(tag := file.read(8)) == 8:
            kind, left = struct.unpack(f"{order}II", tag)
            if kind != MAT_PACKED:
                file.seek(left, os.SEEK_CUR)
                continue
            for piece in _pieces(file, left):
                unpacked += piece
                refuse_large(path, size, unpacked)
    return unpacked


def _pieces(file: BinaryIO, left: int) -> Iterator[int]:
    """Yield the sizes of the pieces to which the next `left` bytes unpack."""
    engine = zlib.decompressobj()
    while left > 0 and not engine.eof:
        data = file.read(min(left, PIECE))
        if not data:
            return
        left -= len(data)
        while data and not engine.eof:
            yield len(engine.decompress(data, PIECE))
            data = engine.unconsumed_tail
    file.seek(left, os.SEEK_CUR)
