"""Read columns of numbers from other tools' files: CSV, UFF58, SEP-005, TDMS, MATLAB, plain HDF5.

The meaning of the columns is stated by a mapping (rig.importing). A file may come from anybody, so
that its stated sizes are checked against the bytes it holds before anything is allocated.
"""

import csv
import io
import json
import math
import os
import struct
import zipfile
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np
import numpy.typing as npt

from daq.documents.shapes import Keys, List, Number, Text, deviations
from daq.expansion import ALWAYS, DEFLATE, TIMES, most_unpacked
from daq.formats.wave import FormatError, MissingReader
from daq.regular_files import kind_of_place, open_regular
from daq.session.hdf5 import dataset, has

__all__ = ["KINDS", "CsvStyle", "FileColumn", "kind_of", "read_columns"]

KINDS: Mapping[str, tuple[str, ...]] = {
    "csv": (".csv", ".txt", ".dat", ".tsv"),
    "uff58": (".uff", ".unv"),
    "sep005": (".npz",),
    "tdms": (".tdms",),
    "mat": (".mat",),
    "hdf5": (".h5", ".hdf5", ".hdf"),
}
"""Formats, with their usual file name suffixes."""

HEADER_LINES = 200  # lines searched for the header
LARGEST_TEXT = 2**31  # bytes of a text file, which is read as a whole
LONGEST_LINE = 2**20  # characters of a line of a text file
PIECE = 2**20  # bytes unpacked at a time to count them
RATE = Number(1e-6, 1e9)
SEP005 = List(Keys({"name": Text(), "fs": RATE}))
UFF58 = 58
MAT_HEAD, MAT_PACKED = 128, 15  # header length in bytes; type number of a compressed element
MAT_NUMBERS = {
    "double",
    "single",
    *(f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)),
}


@dataclass(frozen=True)
class CsvStyle:
    """The number format of a text file. skip: lines before the header or the numbers."""

    delimiter: str = ","
    decimal: str = "."
    skip: int = 0


@dataclass(frozen=True, eq=False)
class FileColumn:
    """A column of a file. rate: Hz, None where the file does not state it."""

    samples: npt.NDArray[np.float64]
    rate: float | None = None


def kind_of(path: Path) -> str | None:
    """Return the format of a file by its name's suffix, None where it is none of KINDS."""
    return next((kind for kind, suffixes in KINDS.items() if path.suffix.lower() in suffixes), None)


def read_columns(
    path: Path, kind: str, wanted: Sequence[str], style: CsvStyle = CsvStyle()
) -> dict[str, FileColumn]:
    """Return the wanted columns of a file by name: headers, variables or paths, or positions from
    1.

    Raises FormatError where the file cannot be read, or has no such column (naming those that it
    has).
    """
    kind_there = kind_of_place(path)
    if kind_there != "a file":
        raise FormatError(
            f"{path} is {kind_there}, no file" if kind_there else f"there is no file {path}"
        )
    readers: Mapping[str, Callable[[], dict[str, FileColumn]]] = {
        "csv": lambda: _csv(path, style),
        "uff58": lambda: _uff58(path),
        "sep005": lambda: _sep005(path, wanted),
        "tdms": lambda: _tdms(path, wanted),
        "mat": lambda: _mat(path, wanted),
        "hdf5": lambda: _hdf5(path, wanted),
    }
    try:
        found = readers[kind]()
    except FormatError:
        raise
    except MemoryError as error:
        raise FormatError(f"{path}: out of memory while it was read") from error
    except Exception as error:  # the libraries raise any exception on a malformed file
        raise FormatError(
            f"{path} cannot be read as {kind}: {str(error) or type(error).__name__}"
        ) from error
    return {name: _chosen(path, found, name) for name in wanted}


def _chosen(path: Path, found: Mapping[str, FileColumn], name: str) -> FileColumn:
    return found[_name_of(path, list(found), name)]


def _name_of(path: Path, names: Sequence[str], name: str) -> str:
    """Return the column with this name, or at this position."""
    if name in names:
        return name
    if name.isdecimal() and 1 <= int(name) <= len(names):
        return names[int(name) - 1]
    raise FormatError(f"{path} has no column {name!r}; it has {', '.join(names[:20]) or 'none'}")


def _hertz(path: Path, what: str, value: Any) -> float:
    """Return a sampling rate (Hz) stated by the file.

    Raises FormatError unless it is a plausible number.
    """
    plain = value.item() if isinstance(value, np.generic) else value
    if not RATE.holds(plain):
        raise FormatError(f"{path}: {what} is {plain!r:.40}, expected {RATE} (Hz)")
    return float(plain)


def _refuse_large(path: Path, packed: int, unpacked: int) -> None:
    """Raise FormatError where a file would unpack to far more bytes than a record does."""
    if unpacked > most_unpacked(packed):
        raise FormatError(
            f"{path} would unpack from {packed} bytes to {unpacked} or more; at most {TIMES} times as many are "
            f"unpacked, or {ALWAYS}"
        )


def _lines(path: Path, skip: int) -> Iterator[str]:
    """Yield the lines of a text file after the first `skip`.

    Raises FormatError where it is not text.
    """
    with io.TextIOWrapper(open_regular(path), encoding="utf-8-sig", errors="replace") as file:
        number = 0
        while line := file.readline(LONGEST_LINE + 1):
            number += 1
            if len(line) > LONGEST_LINE:
                raise FormatError(f"{path}: line {number} has more than {LONGEST_LINE} characters")
            if number > skip:
                yield line


def _csv(path: Path, style: CsvStyle) -> dict[str, FileColumn]:
    """Read numbers below one header line, or without one; `#` starts a comment."""
    if path.stat().st_size > LARGEST_TEXT:
        raise FormatError(f"{path} is larger than 2 GiB: cut it into records")
    head = [line for line in islice(_lines(path, style.skip), HEADER_LINES) if line.strip()]
    rows = list(
        csv.reader(
            (line for line in head if not line.lstrip().startswith("#")), delimiter=style.delimiter
        )
    )
    if not rows:
        raise FormatError(f"{path} holds no numbers")
    # Any word that is not a number makes the first row a header; without one the columns are
    # numbered.
    first = [_number(word, style) for word in rows[0]]
    names = (
        [word.strip() for word in rows[0]]
        if None in first
        else [str(n + 1) for n in range(len(rows[0]))]
    )
    if len(rows) < 2 and None in first:
        raise FormatError(f"{path} holds no numbers below its headers")
    lines = _lines(path, style.skip)
    text = (line.replace(style.decimal, ".") for line in lines) if style.decimal != "." else lines
    before = _before(path, style) if None in first else 0
    values = np.loadtxt(text, delimiter=style.delimiter, skiprows=before, ndmin=2, dtype=np.float64)
    if values.shape[1] != len(names):
        raise FormatError(f"{path} has {len(names)} headers over {values.shape[1]} columns")
    if len(set(names)) < len(names):
        # Headers that repeat cannot name columns.
        names = [str(n + 1) for n in range(len(names))]
    return {name: FileColumn(np.ascontiguousarray(values[:, n])) for n, name in enumerate(names)}


def _before(path: Path, style: CsvStyle) -> int:
    """Return the number of lines up to and including the header, counted after `skip`."""
    for number, line in enumerate(_lines(path, style.skip), start=1):
        if line.strip() and not line.lstrip().startswith("#"):
            return number
    return 0


def _number(word: str, style: CsvStyle) -> float | None:
    """Return the number that a word stands for, None where it is not one."""
    try:
        return float(word.replace(style.decimal, "."))
    except ValueError:
        return None


def _uff58(path: Path) -> dict[str, FileColumn]:
    """Read time responses, by their first ID line, else by position; with the exact rate in files
    that we wrote.
    """
    try:
        import pyuff
    except ImportError:
        raise MissingReader("UFF58", "pyuff") from None
    file: Any = pyuff.UFF(str(path))  # type: ignore[no-untyped-call, unused-ignore]
    wanted = [number for number, kind in enumerate(file.get_set_types()) if int(kind) == UFF58]
    read = file.read_sets(wanted) if wanted else []
    # pyuff returns a single set without a list
    entries = read if isinstance(read, list) else [read]
    sets = [entry for entry in entries if entry.get("func_type") == 1]
    found: dict[str, FileColumn] = {}
    for number, entry in enumerate(sets, start=1):
        if len(entry["data"]) != entry["num_pts"] or len(entry["data"]) < 2:
            raise FormatError(
                f"{path}: dataset {number} says {entry['num_pts']} values and has {len(entry['data'])}"
            )
        # The abscissa is stored with six digits; ID line 3 of our own files states the exact rate.
        step = 1 / _hertz(
            path,
            f"the rate of dataset {number}",
            1 / float(entry["x"][1] - entry["x"][0] or np.nan),
        )
        name = str(entry.get("id1", "")).strip()
        told = str(entry.get("id3", "")).split()
        exact = (
            float(told[1]) if len(told) == 3 and told[0] == "rate" and told[2] == "Hz" else 1 / step
        )
        rate = exact if math.isfinite(exact) and abs(exact * step - 1) < 1e-5 else 1 / step
        key = name if name and name not in found and name != "NONE" else str(number)
        found[key] = FileColumn(_flat(entry["data"]), rate)
    return found


def _sep005(path: Path, wanted: Sequence[str]) -> dict[str, FileColumn]:
    """Read the arrays of an npz file with SEP-005 dicts, as `write_sep005` writes them."""
    _check_archive(path)
    with np.load(path, allow_pickle=False) as arrays:
        entries = json.loads(str(arrays["channels"][()]))
        for sentence in deviations(entries, SEP005, "channels"):
            raise FormatError(f"{path}: {sentence}")
        names = [entry["name"] for entry in entries]
        places = {names.index(_name_of(path, names, name)) for name in wanted}
        found = {
            names[n]: FileColumn(_flat(arrays[f"data_{n}"]), float(entries[n]["fs"]))
            for n in sorted(places)
        }
    return {name: found[_name_of(path, names, name)] for name in wanted}


def _check_archive(path: Path) -> None:
    """Raise FormatError for a zip file that unpacks to absurd sizes, or an array header that claims
    more than its entry.
    """
    with open_regular(path) as file, zipfile.ZipFile(file) as archive:
        entries = archive.infolist()
        _refuse_large(path, path.stat().st_size, sum(entry.file_size for entry in entries))
        for entry in entries:
            if entry.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                raise FormatError(
                    f"{path} is packed by zip's method {entry.compress_type}; numpy writes 0 and 8"
                )
            with archive.open(entry) as array:
                version = np.lib.format.read_magic(array)
                # 3.0 is for structured types with unicode names
                if version not in ((1, 0), (2, 0)):
                    raise FormatError(f"{path}: {entry.filename} is an array of version {version}")
                read = (
                    np.lib.format.read_array_header_1_0
                    if version == (1, 0)
                    else np.lib.format.read_array_header_2_0
                )
                shape, _, dtype = read(array)
            if math.prod(shape) * dtype.itemsize > entry.file_size:
                raise FormatError(
                    f"{path}: {entry.filename} claims {shape} values of {dtype}, more than it holds"
                )


def _tdms(path: Path, wanted: Sequence[str]) -> dict[str, FileColumn]:
    """Read channels as "group/channel", with the rate from the waveform's increment."""
    try:
        import nptdms
    except ImportError:
        raise MissingReader("TDMS", "npTDMS") from None
    size = path.stat().st_size
    file: Any
    with nptdms.TdmsFile.open(path) as file:  # type: ignore[attr-defined, no-untyped-call, unused-ignore]
        channels = {
            f"{group.name}/{one.name}": one for group in file.groups() for one in group.channels()
        }
        found = {}
        for name in wanted:
            channel = channels[_name_of(path, list(channels), name)]
            if len(channel) > size:  # nothing is packed in this format
                raise FormatError(
                    f"{path}: {name} claims {len(channel)} values in a file of {size} bytes"
                )
            step = channel.properties.get("wf_increment") or None
            rate = None if step is None else _hertz(path, "1 / wf_increment", _inverse(step))
            found[name] = FileColumn(_flat(channel[:]), rate)
    return found


def _inverse(step: Any) -> Any:
    """Return 1 / step for a number, anything else unchanged."""
    return (
        1 / step
        if isinstance(step, int | float | np.number) and not isinstance(step, bool)
        else step
    )


def _mat(path: Path, wanted: Sequence[str]) -> dict[str, FileColumn]:
    """Read numeric variables; `fs` in Hz is the rate of all of them. Version 7.3 is HDF5."""
    from scipy import io as matlab

    with open_regular(path) as file:
        version = file.read(10)
    if version == b"MATLAB 7.3":
        return _hdf5(path, wanted)
    room = _unpacked_mat(path)
    reader: Any = matlab
    names = []
    for name, shape, kind in reader.whosmat(path):
        # cells and structures are not read, because their stated sizes prove nothing
        if kind not in MAT_NUMBERS:
            continue
        if math.prod(map(int, shape)) > room:
            raise FormatError(f"{path}: {name} claims {shape} values, more than the file holds")
        names.append(name)
    values = reader.loadmat(path, variable_names=names, simplify_cells=False) if names else {}
    numeric = {name: value for name, value in values.items() if _is_numeric(name, value)}
    told = numeric.get("fs")
    rate = None if told is None or told.size != 1 else _hertz(path, "fs", told.ravel()[0])
    return _by_columns({name: value for name, value in numeric.items() if value.size > 1}, rate)


def _is_numeric(name: str, value: Any) -> bool:
    """Return whether a variable of loadmat is an array of numbers, not one of its own entries
    ("__header__").
    """
    if name.startswith("__") or not isinstance(value, np.ndarray):
        return False
    return value.dtype.kind in "fiu"


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
                _refuse_large(path, size, unpacked)
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


def _hdf5(path: Path, wanted: Sequence[str]) -> dict[str, FileColumn]:
    """Read datasets by path; only the wanted ones are opened, and only if they keep their bytes in
    this file.
    """
    with h5py.File(path, "r") as file:  # type: ignore[attr-defined, no-untyped-call, unused-ignore]
        names = {name: name.rpartition("#")[0] or name for name in wanted}
        missing = [name for name in names.values() if not has(file, name.strip("/"))]
        if missing:
            raise FormatError(
                f"{path} has no dataset {missing[0]!r}; at its root lie {', '.join(islice(file, 20))}"
            )
        arrays = {}
        for name in dict.fromkeys(names.values()):
            # refuses bytes elsewhere, foreign filters and absurd sizes
            dataset(file, name.strip("/"))
            arrays[name] = np.asarray(file[name][()])
    return _by_columns(arrays, None)


def _by_columns(
    arrays: Mapping[str, npt.NDArray[Any]], rate: float | None
) -> dict[str, FileColumn]:
    """Return vectors by name, and each column of a matrix, along its longer side, as "name#1",
    "name#2", ...
    """
    found = {}
    for name, array in arrays.items():
        flat = np.atleast_1d(np.squeeze(array))
        if flat.ndim == 1:
            found[name] = FileColumn(_flat(flat), rate)
        elif flat.ndim == 2:
            upright = flat if flat.shape[0] >= flat.shape[1] else flat.T
            found |= {
                f"{name}#{n + 1}": FileColumn(_flat(upright[:, n]), rate)
                for n in range(upright.shape[1])
            }
    return found


def _flat(values: Any) -> npt.NDArray[np.float64]:
    return np.ascontiguousarray(values, dtype=np.float64).ravel()
