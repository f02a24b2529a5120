"""Read a record of another laboratory as its mapping says: scale it to SI units, find its frequency
and whole cycles, and refuse it if it is not steady.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.session.record import AnalysisError
from analysis.signals.cycles import whole_cycles
from analysis.signals.examination import examined
from analysis.signals.stationary import Steadiness, drive_line, steadiness
from daq.formats.column import FileColumn
from daq.formats.reading import CsvStyle, kind_of, read_columns
from daq.formats.sidecar import Sidecar
from daq.formats.wave import FormatError
from daq.regular_files import open_regular
from rig.importing.exported_record import sidecar_for
from rig.importing.file_units import channel_unit
from rig.importing.mapping import (
    ACCELERATION_UNITS,
    FORCE_UNITS,
    FORMATS,
    AccelerationColumn,
    ForceColumn,
    Known,
    RecordMap,
    RunFile,
)
from rig.importing.time_scale import aligned, evened, sizes, time_scale

Array = NDArray[np.float64]

OTHER_DRIVE = 1e-2  # largest relative difference of the record's frequency from the mapping's
SHORTEST = 16  # samples
SLOWEST, FASTEST = 0.5, 5000.0
"""Drive frequencies, Hz, beyond which a time column without a unit is in another one than seconds."""


@dataclass(frozen=True, eq=False)
class Reading:
    """One record in SI units.

    rate, frequency : of the samples and of the drive, Hz
    start : first sample of the part that is analysed
    cycles : whole cycles in that part
    digest : SHA-256 of the file
    sidecar : content of the file beside an exported record
    told : what was taken from the file because the mapping does not say it, in sentences
    doubts : flags of the run from the examination of file and signals, such as held_force
    """

    source: Path
    known: Known
    force: Array
    acceleration: Array
    rate: float
    frequency: float
    start: int
    cycles: int
    steady: Steadiness
    digest: str
    sidecar: Sidecar | None = None
    told: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()


def read_record(file: Path, run: RunFile, mapping: RecordMap) -> Reading:
    """Return a record: read, scaled and checked.

    Raises FormatError if the file cannot be read as the mapping says or states otherwise,
    AnalysisError if it has no steady whole cycles.
    """
    kind = mapping.format or kind_of(file)
    if kind is None:
        raise FormatError(
            f"{file}: no format by that name; write `format:` ({', '.join(FORMATS)}) in the mapping"
        )
    columns = _columns(file, kind, mapping)
    channels: Mapping[str, FileColumn] = {"force": columns[mapping.force.channel],
                "acceleration": columns[mapping.acceleration.channel]}  # fmt: skip
    time = columns[mapping.time.channel] if mapping.time else None
    with open_regular(file) as content:
        digest = hashlib.file_digest(content, "sha256").hexdigest()
    sidecar = sidecar_for(file, digest, mapping)
    sizes(file, channels)
    scale = time_scale(file, mapping, channels, time, None if sidecar is None else sidecar.rate)
    rate = scale.rate
    if scale.times is not None:
        channels = {
            name: replace(one, samples=evened(one.samples, scale.times[name]))
            if name in scale.times
            else one
            for name, one in channels.items()
        }
    channels, starts = aligned(file, mapping, channels, rate)
    F, force_told, force_doubts = _scaled(file, kind, "force", mapping.force, channels["force"])
    a, told, doubts = _scaled(
        file, kind, "acceleration", mapping.acceleration, channels["acceleration"]
    )
    # The run's own settling time goes before the mapping's, and both before the sidecar's.
    start = round((mapping.settle if run.settle is None else run.settle) * rate)
    if sidecar is not None and run.settle is None and not mapping.settle:
        start = round(sidecar.window[0])
    stop = F.size if mapping.length is None else start + round(mapping.length * rate)
    part = slice(start, min(stop, F.size))
    if start >= F.size:
        lasts = F.size / rate
        raise AnalysisError(
            f"{file}: the record lasts {lasts:.4g} s, and {start / rate:.4g} s are left out: `settle`"
        )
    if a[part].size < SHORTEST or not np.ptp(a[part]):
        raise AnalysisError(
            f"{file}: nothing moves in the {a[part].size} samples after {start / rate:g} s"
        )
    try:
        line = drive_line(a[part], rate, mapping.frequency)
        frequency = line.frequency
        if mapping.frequency is not None and abs(frequency / mapping.frequency - 1) > OTHER_DRIVE:
            raise AnalysisError(
                f"the drive is at {frequency:.6g} Hz, the mapping says {mapping.frequency:g} Hz"
            )
        steady = steadiness(a[part], rate, frequency)
        cycles = whole_cycles(part.stop, rate, frequency, settle=start * frequency / rate).cycles
    except (AnalysisError, ValueError) as error:
        raise AnalysisError(f"{file}: {error}") from error
    _plausible(file, mapping, time, frequency)
    _gate(file, mapping, steady)
    seen = [
        f"{name}_{channel}"
        for channel, values, column in (
            ("force", F, mapping.force), ("acceleration", a, mapping.acceleration),
        )
        for name in examined(values[part], rate, frequency, column.range is not None)
    ]  # fmt: skip
    if line.doubt:
        seen.append("drive_line_acceleration")
    return Reading(
        file, run.condition, F, a, rate, frequency, start, cycles, steady, digest, sidecar,
        told=(*force_told, *told, *scale.told, *starts, *([line.told] if line.told else [])),
        doubts=(*force_doubts, *doubts, *scale.doubts, *seen),
    )  # fmt: skip


def _columns(file: Path, kind: str, mapping: RecordMap) -> Mapping[str, FileColumn]:
    """Return the columns that the mapping names. FormatError where one holds no number somewhere."""
    names = [mapping.force.channel, mapping.acceleration.channel]
    if mapping.time is not None:
        names.append(mapping.time.channel)
    style = CsvStyle(mapping.csv.delimiter or "", mapping.csv.decimal or "", mapping.csv.skip)
    columns = read_columns(file, kind, names, style)
    sizes_of = {columns[name].samples.size for name in names}
    if mapping.time is not None and len(sizes_of) > 1:
        raise FormatError(f"{file}: the columns have different lengths: {sorted(sizes_of)}")
    for name in names:
        bad = np.flatnonzero(~np.isfinite(columns[name].samples))
        if bad.size:
            raise FormatError(
                f"{file}: {name} is not a number at sample {bad[0]}; a record may have no gap"
            )
    return columns


def _plausible(file: Path, mapping: RecordMap, time: FileColumn | None, frequency: float) -> None:
    """Raise FormatError where a time column whose unit nobody states makes a drive that no stand
    has.
    """
    if mapping.time is None or mapping.time.unit or mapping.frequency or time is None or time.unit:
        return
    if not SLOWEST <= frequency <= FASTEST:
        raise FormatError(
            f"{file}: neither mapping nor file states the unit of the time column; in seconds the drive would be at "
            f"{frequency:.4g} Hz: write `time: {{unit: ...}}` or `frequency:`"
        )


def _gate(file: Path, mapping: RecordMap, steady: Steadiness) -> None:
    """Raise AnalysisError if a record is less steady than the mapping allows."""
    limits = mapping.steady
    if steady.level > limits.level or steady.phase > limits.phase:
        raise AnalysisError(
            f"{file}: not steady: the acceleration's fundamental changes by {100 * steady.level:.2g} % (allowed "
            f"{100 * limits.level:g} %) and {1e3 * steady.phase:.2g} mrad (allowed {1e3 * limits.phase:g}); leave the "
            "start out with `settle`, or the end with `length`"
        )


def _scaled(
    file: Path, kind: str, name: str, column: ForceColumn | AccelerationColumn, found: FileColumn
) -> tuple[Array, tuple[str, ...], tuple[str, ...]]:
    """Return samples in N or m/s^2, positive in the drive's direction, what was taken from the file,
    and doubts. FormatError for codes without a scale.
    """
    unit = channel_unit(file, name, column, found)
    units = FORCE_UNITS if name == "force" else ACCELERATION_UNITS
    # In a text file whole numbers may well be in a unit, if only somebody says in which.
    said = kind == "csv" and column.unit is not None
    if found.codes and column.scale is None and not said:
        raise FormatError(
            f"{file}: {name} holds whole numbers of a converter, and no scale beside them: write `{name}: {{scale: ...}}`, "
            f"the {unit.unit} of one count (1 if they are {unit.unit} already)"
        )
    factor = column.sign * units[unit.unit] / (column.sensitivity or 1.0) * (column.scale or 1.0)
    told = ([f"{name}.unit: {unit.told}"] if unit.told else []) + list(found.told)
    return found.samples * factor, tuple(told), (f"unit_{name}",) if unit.doubt else ()
