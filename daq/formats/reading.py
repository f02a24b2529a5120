"""Read columns of numbers from other tools' files: text, UFF58, SEP-005, TDMS, MATLAB, HDF5, WAV.

The meaning of the columns is stated by a mapping (rig.importing); what the file itself states of
them (units, scales, rates, starts) comes with them. A file may come from anybody, so that its stated
sizes are checked against the bytes it holds before anything is allocated.
"""

import json
import math
import warnings
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from daq.documents.shapes import Keys, List, Text, deviations
from daq.formats.column import RATE, FileColumn, hertz, instant_of, name_of, numbers, refuse_large
from daq.formats.dialect import CsvStyle
from daq.formats.hdf5_reading import read_hdf5
from daq.formats.matlab import read_mat
from daq.formats.tdms import read_tdms
from daq.formats.text import read_text
from daq.formats.uff58_reading import read_uff58
from daq.formats.wave import FormatError
from daq.regular_files import kind_of_place, open_regular

__all__ = ["KINDS", "CsvStyle", "FileColumn", "kind_of", "read_columns"]

KINDS: Mapping[str, tuple[str, ...]] = {
    "csv": (".csv", ".txt", ".dat", ".tsv", ".lvm", ".asc"),
    "uff58": (".uff", ".unv", ".uf", ".uff58"),
    "sep005": (".npz",),
    "tdms": (".tdms",),
    "mat": (".mat",),
    "hdf5": (".h5", ".hdf5", ".hdf"),
    "wav": (".wav",),
}
"""Formats, with their usual file name suffixes."""

SEP005 = List(Keys({"name": Text()}))


def kind_of(path: Path) -> str | None:
    """Return the format of a file by its name's suffix, None where it is none of KINDS."""
    return next((kind for kind, suffixes in KINDS.items() if path.suffix.lower() in suffixes), None)


def read_columns(
    path: Path, kind: str, wanted: Sequence[str], style: CsvStyle | None = None
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
        "csv": lambda: read_text(path, wanted, style or CsvStyle()),
        "uff58": lambda: read_uff58(path, wanted),
        "sep005": lambda: _sep005(path, wanted),
        "tdms": lambda: read_tdms(path, wanted),
        "mat": lambda: read_mat(path, wanted),
        "hdf5": lambda: read_hdf5(path, wanted),
        "wav": lambda: _wav(path, wanted),
    }
    try:
        return readers[kind]()
    except FormatError:
        raise
    except MemoryError as error:
        raise FormatError(f"{path}: out of memory while it was read") from error
    except Exception as error:  # the libraries raise any exception on a malformed file
        raise FormatError(
            f"{path} cannot be read as {kind}: {str(error) or type(error).__name__}"
        ) from error


def _sep005(path: Path, wanted: Sequence[str]) -> dict[str, FileColumn]:
    """Read the arrays of an npz file with SEP-005 dicts, as `write_sep005` writes them. `time` of a
    dict is the name of an array, or the numbers themselves.
    """
    _check_archive(path)
    with np.load(path, allow_pickle=False) as arrays:
        entries = json.loads(str(arrays["channels"][()]))
        for sentence in deviations(entries, SEP005, "channels"):
            raise FormatError(f"{path}: {sentence}")
        names = [str(entry["name"]) for entry in entries]
        found = {}
        for name in wanted:
            n = names.index(name_of(path, names, name, "channel"))
            found[name] = _sep005_column(path, arrays, entries[n], n)
        return found


def _sep005_column(path: Path, arrays: Any, entry: Mapping[str, Any], n: int) -> FileColumn:
    """Return channel n of a SEP-005 file."""
    name = entry["name"]
    rate = entry.get("fs")
    stated = "fs" in entry and not (rate is None and entry.get("time") is not None)
    if stated and not RATE.holds(rate):
        raise FormatError(f"{path}: channels[{n}].fs is {rate!r:.40}, expected {RATE} (Hz)")
    unit = entry.get("unit_str", "")
    start = entry.get("start_timestamp")
    for key, value in (("unit_str", unit), ("start_timestamp", start)):
        if value is not None and not isinstance(value, str):
            raise FormatError(f"{path}: channels[{n}].{key} is {value!r:.40}, expected text")
    time = entry.get("time")
    times = None
    if time is not None:
        if isinstance(time, str) and time not in arrays:
            raise FormatError(f"{path}: channels[{n}].time names {time!r}, which is not there")
        own = numbers(path, f"the time of {name}", arrays[time] if isinstance(time, str) else time)
        times = replace(own, unit="s", unit_at=f"time of {name}", codes=False)
    column = numbers(path, f"{name}", arrays[f"data_{n}"])
    if times is not None and times.samples.size != column.samples.size:
        raise FormatError(
            f"{path}: {name} has {column.samples.size} samples and {times.samples.size} times"
        )
    return replace(
        column,
        rate=None if rate is None else float(rate),
        unit=unit or "",
        unit_at=f"unit_str of {name}" if unit else "",
        start=instant_of(path, start) if start else None,
        times=times,
    )


def _wav(path: Path, wanted: Sequence[str]) -> dict[str, FileColumn]:
    """Read channels of a WAV file by their position from 1; it states a rate and no unit, and its whole
    numbers are codes.
    """
    from scipy.io import wavfile

    reader: Any = wavfile
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", wavfile.WavFileWarning)  # about chunks of other programs
        rate, table = reader.read(path)
    table = np.atleast_2d(table.T).T
    names = [str(n + 1) for n in range(table.shape[1])]
    found = {}
    for name in wanted:
        n = names.index(name_of(path, names, name, "channel"))
        own = numbers(path, f"channel {name}", table[:, n])
        found[name] = FileColumn(
            own.samples,
            rate=hertz(path, "the rate", rate),
            codes=own.codes,
            resolution=own.resolution,
        )
    return found


def _check_archive(path: Path) -> None:
    """Raise FormatError for a zip file that unpacks to absurd sizes, or an array header that claims
    more than its entry.
    """
    with open_regular(path) as file, zipfile.ZipFile(file) as archive:
        entries = archive.infolist()
        refuse_large(path, path.stat().st_size, sum(entry.file_size for entry in entries))
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
