"""Read channels of LabVIEW's TDMS files with what their properties state: scale, unit, rate, start."""

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from daq.formats.column import FileColumn, Instant, hertz, name_of, numbers
from daq.formats.wave import FormatError, MissingReader

__all__ = ["read_tdms"]

UNITS = ("unit_string", "NI_UnitDescription", "unit", "units")
SECONDS_TO_1970 = 2082844800  # from LabVIEW's epoch, 1904
FRACTIONS = 2.0**-64


def read_tdms(path: Path, wanted: Sequence[str]) -> dict[str, FileColumn]:
    """Return channels as "group/channel", scaled as their NI_Scale properties say. Others are not
    touched.

    Raises FormatError for a channel of text, or of times where numbers are asked for.
    """
    try:
        import nptdms
    except ImportError:
        raise MissingReader("TDMS", "npTDMS") from None
    size = path.stat().st_size
    file: Any
    with nptdms.TdmsFile.open(path, raw_timestamps=True) as file:  # type: ignore[attr-defined, no-untyped-call, unused-ignore]
        every = [
            (f"{group.name}/{one.name}", one) for group in file.groups() for one in group.channels()
        ]
        names, channels = [name for name, _ in every], dict(every)
        found = {}
        for name in wanted:
            channel = channels[name_of(path, names, name, "channel")]
            if len(channel) > size:  # nothing is packed in this format
                raise FormatError(
                    f"{path}: {name} claims {len(channel)} values in a file of {size} bytes"
                )
            found[name] = _column(path, name, channel)
    return found


def _column(path: Path, name: str, channel: Any) -> FileColumn:
    """Return a channel with its properties."""
    told: Mapping[str, Any] = channel.properties
    values = channel[:]
    kind = np.asarray(values).dtype
    if kind.names is not None:  # LabVIEW's time stamps: fractions of 2^-64 s, and seconds
        whole = values["seconds"].astype(np.int64)
        seconds = (whole - whole[0]) + (
            values["second_fractions"].astype(np.float64) * FRACTIONS
            - float(values["second_fractions"][0]) * FRACTIONS
        )
        return FileColumn(seconds, unit="s", unit_at="time stamps", resolution=1e-12)
    raw = channel.data_type
    column = numbers(path, name, values)
    # A scaled channel arrives as floating numbers; codes without a scale keep their type.
    step = told.get("wf_increment") or None
    rate = None if step is None else hertz(path, f"{name}: 1 / wf_increment", _inverse(step))
    unit = next((str(told[key]) for key in UNITS if str(told.get(key, "")).strip()), "")
    scales = [key for key in told if key.startswith("NI_Scale[")]
    return FileColumn(
        column.samples,
        rate=rate,
        unit=unit,
        unit_at=f"property unit_string of {name}" if unit else "",
        start=_start(path, name, told),
        codes=column.codes,
        resolution=column.resolution,
        told=(f"{name}: NI_Scale of {getattr(raw, '__name__', raw)}",) if scales else (),
    )


def _start(path: Path, name: str, told: Mapping[str, Any]) -> Instant | None:
    """Return the time of a channel's first sample, None where no property tells any."""
    offset = told.get("wf_start_offset")
    stamp = told.get("wf_start_time")
    if offset is None and stamp is None:
        return None
    late = float(offset or 0.0)
    if not math.isfinite(late):
        raise FormatError(f"{path}: {name} has wf_start_offset {offset!r}")
    if stamp is None:
        return Instant(0, late, f"wf_start_offset {late:g} s")
    whole = int(stamp.seconds) - SECONDS_TO_1970
    part = float(stamp.second_fractions) * FRACTIONS
    text = f"wf_start_time {stamp}" + (f" and wf_start_offset {late:g} s" if late else "")
    return Instant(whole, part + late, text)


def _inverse(step: Any) -> Any:
    """Return 1 / step for a number, anything else unchanged."""
    plain = isinstance(step, int | float | np.number) and not isinstance(step, bool)
    return 1 / step if plain else step
