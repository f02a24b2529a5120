"""Read a record of another laboratory as its mapping says: scale it to SI units, find its frequency
and whole cycles, and refuse it if it is not steady.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from analysis.session.record import AnalysisError
from analysis.signals.cycles import whole_cycles
from analysis.signals.stationary import Steadiness, drive_frequency, steadiness
from daq.formats.reading import CsvStyle, FileColumn, kind_of, read_columns
from daq.formats.sidecar import Sidecar
from daq.formats.wave import FormatError
from daq.regular_files import open_regular
from rig.importing.exported_record import sidecar_for
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

Array = NDArray[np.float64]

UNEVEN = 0.02  # largest deviation of a sample from an even time scale, as a fraction of a step
OTHER_DRIVE = 1e-2  # largest relative difference of the record's frequency from the mapping's
SHORTEST = 16  # samples


@dataclass(frozen=True, eq=False)
class Reading:
    """One record in SI units.

    rate, frequency : of the samples and of the drive, Hz
    start : first sample of the part that is analysed
    cycles : whole cycles in that part
    digest : SHA-256 of the file
    sidecar : content of the file beside an exported record
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


def read_record(file: Path, run: RunFile, mapping: RecordMap) -> Reading:
    """Return a record: read, scaled and checked.

    Raises FormatError if the file cannot be read as the mapping says, AnalysisError if it has no
    steady whole cycles.
    """
    kind = mapping.format or kind_of(file)
    if kind is None:
        raise FormatError(
            f"{file}: no format by that name; write `format:` ({', '.join(FORMATS)}) in the mapping"
        )
    names = [
        mapping.force.channel,
        mapping.acceleration.channel,
        *([mapping.time.channel] if mapping.time else []),
    ]
    style = CsvStyle(mapping.csv.delimiter, mapping.csv.decimal, mapping.csv.skip)
    columns = read_columns(file, kind, names, style)
    force, acceleration = (columns[name] for name in names[:2])
    if force.samples.size != acceleration.samples.size:
        found = f"{force.samples.size} and {acceleration.samples.size} samples"
        raise FormatError(
            f"{file}: force and acceleration have {found}: they must be sampled together"
        )
    for name in names:
        bad = np.flatnonzero(~np.isfinite(columns[name].samples))
        if bad.size:
            raise FormatError(
                f"{file}: {name} is not a number at sample {bad[0]}; a record may have no gap"
            )
    with open_regular(file) as content:
        digest = hashlib.file_digest(content, "sha256").hexdigest()
    sidecar = sidecar_for(file, digest, mapping)
    beside = None if sidecar is None else sidecar.rate
    rate = _rate(
        file,
        mapping,
        (force, acceleration),
        beside,
        columns[names[2]].samples if mapping.time else None,
    )
    # The run's own settling time goes before the mapping's, and both before the sidecar's.
    start = round((mapping.settle if run.settle is None else run.settle) * rate)
    if sidecar is not None and run.settle is None and not mapping.settle:
        start = round(sidecar.window[0])
    stop = force.samples.size if mapping.length is None else start + round(mapping.length * rate)
    part = slice(start, min(stop, force.samples.size))
    F = _scaled(force.samples, mapping.force, FORCE_UNITS)
    a = _scaled(acceleration.samples, mapping.acceleration, ACCELERATION_UNITS)
    if start >= force.samples.size:
        lasts = force.samples.size / rate
        raise AnalysisError(
            f"{file}: the record lasts {lasts:.4g} s, and {start / rate:.4g} s are left out: `settle`"
        )
    if a[part].size < SHORTEST or not np.ptp(a[part]):
        raise AnalysisError(
            f"{file}: nothing moves in the {a[part].size} samples after {start / rate:g} s"
        )
    try:
        frequency = drive_frequency(a[part], rate, mapping.frequency)
        if mapping.frequency is not None and abs(frequency / mapping.frequency - 1) > OTHER_DRIVE:
            raise AnalysisError(
                f"the drive is at {frequency:.6g} Hz, the mapping says {mapping.frequency:g} Hz"
            )
        steady = steadiness(a[part], rate, frequency)
        cycles = whole_cycles(part.stop, rate, frequency, settle=start * frequency / rate).cycles
    except (AnalysisError, ValueError) as error:
        raise AnalysisError(f"{file}: {error}") from error
    _gate(file, mapping, steady)
    return Reading(
        file, run.condition, F, a, rate, frequency, start, cycles, steady, digest, sidecar
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


def _rate(
    file: Path,
    mapping: RecordMap,
    channels: tuple[FileColumn, FileColumn],
    beside: float | None,
    time: Array | None,
) -> float:
    """Return the samples per second: from the time column if the mapping names one; otherwise from
    mapping, file and sidecar, which must agree.

    beside : the sidecar's rate, Hz
    """
    if time is not None and mapping.time is not None:
        seconds = time * {"s": 1.0, "ms": 1e-3, "us": 1e-6}[mapping.time.unit]
        step = float(seconds[-1] - seconds[0]) / max(seconds.size - 1, 1)
        apart = np.abs(seconds - seconds[0] - step * np.arange(seconds.size))
        if not step > 0 or apart.max() > UNEVEN * step:
            where = int(np.argmax(apart)) if step > 0 else 0
            raise FormatError(
                f"{file}: the time column is not even (sample {where}): no gap or jump is allowed"
            )
        return 1 / step
    every = (mapping.rate, *(channel.rate for channel in channels), beside)
    stated = [rate for rate in every if rate is not None]
    if not stated:
        raise FormatError(
            f"{file} does not say its sampling rate: write `rate:` or `time:` in the mapping"
        )
    if abs(stated[0] / stated[-1] - 1) > 1e-5:
        raise FormatError(f"{file}: sampling rates of {stated[0]:g} and {stated[-1]:g} Hz")
    return float(stated[0])


def _scaled(
    samples: Array, column: ForceColumn | AccelerationColumn, units: Mapping[str, float]
) -> Array:
    """Return samples in N or m/s^2, positive in the drive's direction."""
    return samples * (column.sign * units[column.unit] / (column.sensitivity or 1.0))
