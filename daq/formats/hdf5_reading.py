"""Read datasets of HDF5 files with their attributes: unit, scale, rate, start; fields of compound
datasets and columns of matrices by "path#field" and "path#2".
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from daq.formats.column import (
    FileColumn,
    Instant,
    by_columns,
    hertz,
    instant_of,
    name_of,
    numbers,
    scaled,
)
from daq.formats.wave import FormatError
from daq.session.hdf5 import dataset, has

__all__ = ["read_hdf5"]

UNITS = ("units", "unit", "Units", "Unit", "UNITS", "unit_string")
SCALES, OFFSETS = ("scale_factor", "scale", "slope"), ("add_offset", "offset", "intercept")
RATES = ("fs", "Fs", "sampling_rate", "sample_rate", "samplerate", "sampling_frequency", "rate")
STEPS = ("dt", "wf_increment", "sample_interval", "delta_t")
STARTS = ("start_time", "start_timestamp", "t0", "wf_start_time")
SURE = "scale_factor"  # the only name that also holds for floating numbers (netCDF)


def read_hdf5(path: Path, wanted: Sequence[str]) -> dict[str, FileColumn]:
    """Return the datasets; only the wanted ones are opened, and only if they keep their bytes in
    this file.

    Raises FormatError where one is missing, no real numbers, or states several different scales.
    """
    with h5py.File(path, "r") as file:  # type: ignore[attr-defined, no-untyped-call, unused-ignore]
        return {name: _column(path, file, name) for name in wanted}


def _column(path: Path, file: Any, name: str) -> FileColumn:
    """Return a dataset, a column of it, or a field, with its attributes."""
    place, _, part = (name, "", "") if has(file, name.strip("/")) else name.rpartition("#")
    place = (place or name).strip("/")
    if not has(file, place):
        raise FormatError(
            f"{path} has no dataset {place!r}; at its root lie {', '.join(islice(file, 20))}"
        )
    if isinstance(file[place], h5py.Group):  # type: ignore[attr-defined, unused-ignore]
        inside = ", ".join(f"{place}/{key}" for key in islice(file[place], 20))
        raise FormatError(f"{path}: {place!r} is a group; in it lie {inside}")
    dataset(file, place)  # refuses bytes elsewhere, foreign filters and absurd sizes
    values = np.asarray(file[place][()])
    if values.dtype.names is not None:
        if {"real", "imag"} == set(values.dtype.names):
            raise FormatError(f"{path}: {place} holds complex numbers; a record has real ones")
        fields = values.dtype.names
        if part not in fields:
            listed = ", ".join(f"{place}#{field}" for field in fields)
            raise FormatError(
                f"{path}: {place} is a compound dataset; write one of its fields: {listed}"
            )
        values = values[part]
        whole = numbers(path, name, values)
        told = {name: whole}
        chosen = name
    else:
        whole = numbers(path, place, values)
        told = by_columns({place: values}, {place: whole})
        chosen = name_of(path, list(told), f"{place}#{part}" if part else place, "column")
    attributes = dict(_attributes(file, place))
    return _with_attributes(path, place, told[chosen], attributes)


def _attributes(file: Any, place: str) -> Iterator[tuple[str, Any]]:
    """Yield the attributes of root, groups and dataset, the nearest last; of those above only what
    tells a rate or a start.
    """
    above = {*RATES, *STEPS, *STARTS}
    parts = place.split("/")
    for n in range(len(parts)):
        node = file["/".join(parts[:n])] if n else file
        yield from ((key, value) for key, value in node.attrs.items() if key in above)
    yield from file[place].attrs.items()


def _with_attributes(
    path: Path, place: str, column: FileColumn, told: Mapping[str, Any]
) -> FileColumn:
    """Return a column with unit, scale, rate and start from attributes."""
    found = _scaled(path, place, column, told)
    key = next((key for key in UNITS if _word(told.get(key))), "")
    rates = {key: _number(path, f"{place}: {key}", told[key]) for key in RATES if key in told}
    steps = {key: _number(path, f"{place}: {key}", told[key]) for key in STEPS if key in told}
    rates |= {key: 1 / step if step else math.nan for key, step in steps.items()}
    for name, rate in rates.items():
        hertz(path, f"{place}: {name}", rate)
    if rates and max(rates.values()) > min(rates.values()) * (1 + 1e-5):
        said = ", ".join(f"{name} {rate:g} Hz" for name, rate in rates.items())
        raise FormatError(f"{path}: {place} states several rates: {said}")
    return replace(
        found,
        rate=next(iter(rates.values()), None),
        unit=_word(told.get(key)) if key else "",
        unit_at=f"attribute {key} of {place}" if key else "",
        start=_start(path, place, told),
    )


def _scaled(path: Path, place: str, column: FileColumn, told: Mapping[str, Any]) -> FileColumn:
    """Return a column by the scale that its attributes state.

    For floating numbers only `scale_factor` is sure to be one to be applied; another word leaves
    them codes, which a mapping has to scale.
    """
    scales = {key: _number(path, f"{place}: {key}", told[key]) for key in SCALES if key in told}
    offsets = {key: _number(path, f"{place}: {key}", told[key]) for key in OFFSETS if key in told}
    if len(set(scales.values())) > 1 or len(set(offsets.values())) > 1:
        said = ", ".join(f"{key} {value:g}" for key, value in (scales | offsets).items())
        raise FormatError(f"{path}: {place} states several scales: {said}")
    if not scales:
        return column
    key, slope = next(iter(scales.items()))
    if not column.codes and key != SURE:
        return replace(column, codes=slope != 1)
    offset = next(iter(offsets.values()), 0.0)
    return scaled(path, column, (slope, offset), f"{place}: {key}")


def _start(path: Path, place: str, told: Mapping[str, Any]) -> Instant | None:
    """Return the start that attributes tell, None for none."""
    for key in STARTS:
        if key not in told:
            continue
        word = _word(told[key])
        if word:
            return instant_of(path, word)
        value = _number(path, f"{place}: {key}", told[key])
        whole = math.floor(value)
        return Instant(whole, value - whole, f"{key} {value!r} s")
    return None


def _word(value: Any) -> str:
    """Return the text of an attribute, "" for anything else."""
    one = np.asarray(value).ravel()
    if one.size != 1:
        return ""
    if isinstance(one[0], bytes):
        return one[0].decode("utf-8", "replace").strip()
    return str(one[0]).strip() if isinstance(one[0], str) else ""


def _number(path: Path, what: str, value: Any) -> float:
    """Return the number of an attribute. FormatError where it is none."""
    one = np.asarray(value).ravel()
    if one.size != 1 or one.dtype.kind not in "fiu":
        raise FormatError(f"{path}: {what} is {value!r:.40}, no number")
    return float(one[0])
