"""Columns out of other tools' files: CSV, UFF58, SEP-005, TDMS, MATLAB, plain HDF5. What they mean is for a mapping."""

import csv
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import numpy.typing as npt

from daq.formats.wave import FormatError, MissingReader
from daq.session_hdf5 import dataset, has

__all__ = ["KINDS", "Column", "CsvStyle", "kind_of", "read_columns"]

KINDS: Mapping[str, tuple[str, ...]] = {
    "csv": (".csv", ".txt", ".dat", ".tsv"), "uff58": (".uff", ".unv"), "sep005": (".npz",), "tdms": (".tdms",),
    "mat": (".mat",), "hdf5": (".h5", ".hdf5", ".hdf"),
}  # fmt: skip
"""Formats and the file names they usually have."""

HEADER_LINES = 200  # lines before the numbers that are looked at
LARGEST_TEXT = 2**31  # bytes of a text file that is read at once


@dataclass(frozen=True)
class CsvStyle:
    """How a text file writes its numbers. skip: lines before the header or the numbers."""

    delimiter: str = ","
    decimal: str = "."
    skip: int = 0


@dataclass(frozen=True, eq=False)
class Column:
    """A column as a file holds it. rate: Hz, None where the file does not say."""

    samples: npt.NDArray[np.float64]
    rate: float | None = None


def kind_of(path: Path) -> str | None:
    """The format that a file name stands for, None where it is none of KINDS."""
    return next((kind for kind, suffixes in KINDS.items() if path.suffix.lower() in suffixes), None)


def read_columns(path: Path, kind: str, wanted: Sequence[str], style: CsvStyle = CsvStyle()) -> dict[str, Column]:
    """The wanted columns of a file by name; names are headers, variables or paths, or positions from 1.

    Raises FormatError where the file cannot be read, or has no such column (naming those that there are).
    """
    if not path.is_file():
        raise FormatError(f"there is no file {path}")
    readers: Mapping[str, Callable[[], dict[str, Column]]] = {
        "csv": lambda: _csv(path, style), "uff58": lambda: _uff58(path), "sep005": lambda: _sep005(path),
        "tdms": lambda: _tdms(path), "mat": lambda: _mat(path, wanted), "hdf5": lambda: _hdf5(path, wanted),
    }  # fmt: skip
    try:
        found = readers[kind]()
    except FormatError:
        raise
    except Exception as error:  # other people's readers raise anything on a foreign file
        raise FormatError(f"{path} cannot be read as {kind}: {str(error) or type(error).__name__}") from error
    return {name: _chosen(path, found, name) for name in wanted}


def _chosen(path: Path, found: Mapping[str, Column], name: str) -> Column:
    if name in found:
        return found[name]
    columns = list(found.values())
    if name.isdecimal() and 1 <= int(name) <= len(columns):
        return columns[int(name) - 1]
    listed = ", ".join(islice(found, 20)) or "none"
    raise FormatError(f"{path} has no column {name!r}; it has {listed}")


def _csv(path: Path, style: CsvStyle) -> dict[str, Column]:
    """Numbers below one line of headers, or none; `#` starts a comment."""
    if path.stat().st_size > LARGEST_TEXT:
        raise FormatError(f"{path} is larger than 2 GiB: cut it into records")
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        head = [line for line in islice(file, style.skip, style.skip + HEADER_LINES) if line.strip()]
    rows = list(csv.reader((line for line in head if not line.lstrip().startswith("#")), delimiter=style.delimiter))
    if not rows:
        raise FormatError(f"{path} holds no numbers")
    first = [_number(word, style) for word in rows[0]]
    names = [word.strip() for word in rows[0]] if None in first else [str(n + 1) for n in range(len(rows[0]))]
    if len(rows) < 2 and None in first:
        raise FormatError(f"{path} holds no numbers below its headers")
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        lines = islice(file, style.skip, None)
        text = (line.replace(style.decimal, ".") for line in lines) if style.decimal != "." else lines
        before = _before(path, style) if None in first else 0
        values = np.loadtxt(text, delimiter=style.delimiter, skiprows=before, ndmin=2, dtype=np.float64)
    if values.shape[1] != len(names):
        raise FormatError(f"{path} has {len(names)} headers over {values.shape[1]} columns")
    if len(set(names)) < len(names):
        names = [str(n + 1) for n in range(len(names))]
    return {name: Column(np.ascontiguousarray(values[:, n])) for n, name in enumerate(names)}


def _before(path: Path, style: CsvStyle) -> int:
    """Lines up to and with the header, counted from `skip`."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        for number, line in enumerate(islice(file, style.skip, None), start=1):
            if line.strip() and not line.lstrip().startswith("#"):
                return number
    return 0


def _number(word: str, style: CsvStyle) -> float | None:
    try:
        return float(word.replace(style.decimal, "."))
    except ValueError:
        return None


def _uff58(path: Path) -> dict[str, Column]:
    """Time responses by their first ID line, else by position; the exact rate where we wrote it ourselves."""
    try:
        import pyuff
    except ImportError:
        raise MissingReader("UFF58", "pyuff") from None
    file: Any = pyuff.UFF(str(path))  # type: ignore[no-untyped-call, unused-ignore]
    sets = [entry for entry in file.read_sets() if entry.get("func_type") == 1]
    found: dict[str, Column] = {}
    for number, entry in enumerate(sets, start=1):
        step = float(entry["x"][1] - entry["x"][0])
        name = str(entry.get("id1", "")).strip()
        told = str(entry.get("id3", "")).split()
        exact = float(told[1]) if len(told) == 3 and told[0] == "rate" and told[2] == "Hz" else 1 / step
        rate = exact if abs(exact * step - 1) < 1e-5 else 1 / step
        key = name if name and name not in found and name != "NONE" else str(number)
        found[key] = Column(_flat(entry["data"]), rate)
    return found


def _sep005(path: Path) -> dict[str, Column]:
    with np.load(path, allow_pickle=False) as arrays:
        entries = json.loads(str(arrays["channels"][()]))
        return {
            str(entry["name"]): Column(_flat(arrays[f"data_{number}"]), float(entry["fs"]))
            for number, entry in enumerate(entries)
        }


def _tdms(path: Path) -> dict[str, Column]:
    """Channels as "group/channel"; the rate from the waveform's increment."""
    try:
        import nptdms
    except ImportError:
        raise MissingReader("TDMS", "npTDMS") from None
    found = {}
    file: Any = nptdms.TdmsFile.read(path)  # type: ignore[attr-defined, no-untyped-call, unused-ignore]
    for group in file.groups():
        for channel in group.channels():
            step = channel.properties.get("wf_increment")
            found[f"{group.name}/{channel.name}"] = Column(_flat(channel[:]), 1 / float(step) if step else None)
    return found


def _mat(path: Path, wanted: Sequence[str]) -> dict[str, Column]:
    """Numeric variables; `fs` in Hz is the rate of all of them. Version 7.3 is HDF5."""
    from scipy import io as matlab

    with path.open("rb") as file:
        version = file.read(10)
    if version == b"MATLAB 7.3":
        return _hdf5(path, wanted)
    values = matlab.loadmat(path, variable_names=None, simplify_cells=False)  # type: ignore[attr-defined, no-untyped-call, unused-ignore]
    numeric = {
        name: value
        for name, value in values.items()
        if not name.startswith("__") and isinstance(value, np.ndarray) and value.dtype.kind in "fiu"
    }
    rate = float(numeric["fs"].ravel()[0]) if "fs" in numeric and numeric["fs"].size == 1 else None
    return _by_columns({name: value for name, value in numeric.items() if value.size > 1}, rate)


def _hdf5(path: Path, wanted: Sequence[str]) -> dict[str, Column]:
    """Datasets by path; only those asked for are opened, and only such as hold their bytes in this file."""
    with h5py.File(path, "r") as file:  # type: ignore[attr-defined, no-untyped-call, unused-ignore]
        names = {name: name.rpartition("#")[0] or name for name in wanted}
        missing = [name for name in names.values() if not has(file, name.strip("/"))]
        if missing:
            raise FormatError(f"{path} has no dataset {missing[0]!r}; at its root lie {', '.join(islice(file, 20))}")
        arrays = {}
        for name in dict.fromkeys(names.values()):
            dataset(file, name.strip("/"))  # refuses bytes elsewhere, foreign filters and absurd sizes
            arrays[name] = np.asarray(file[name][()])
    return _by_columns(arrays, None)


def _by_columns(arrays: Mapping[str, npt.NDArray[Any]], rate: float | None) -> dict[str, Column]:
    """Vectors by name; of a matrix each column too, as "name#1", along its longer side."""
    found = {}
    for name, array in arrays.items():
        flat = np.atleast_1d(np.squeeze(array))
        if flat.ndim == 1:
            found[name] = Column(_flat(flat), rate)
        elif flat.ndim == 2:
            upright = flat if flat.shape[0] >= flat.shape[1] else flat.T
            found |= {f"{name}#{n + 1}": Column(_flat(upright[:, n]), rate) for n in range(upright.shape[1])}
    return found


def _flat(values: Any) -> npt.NDArray[np.float64]:
    return np.ascontiguousarray(values, dtype=np.float64).ravel()
