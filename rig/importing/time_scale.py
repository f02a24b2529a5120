"""The time scale of a record from all that states one: rate, time column, abscissa, starts. What
states it twice must agree.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from analysis.signals.corrected_signal import CorrectedSignal
from daq.formats.column import FileColumn, Instant
from daq.formats.wave import FormatError
from rig.importing.file_units import time_unit, unit_in_words
from rig.importing.mapping import TIME_UNITS, RecordMap, TimeColumn

__all__ = ["TimeScale", "aligned", "even_scale", "evened", "sizes", "time_scale"]

Array = NDArray[np.float64]

UNEVEN = 0.02  # largest deviation of a sample from an even time scale, as a fraction of a step
SCATTER = 0.02  # largest rms deviation of the steps for which samples are put on an even scale
SAME = 1e-5  # relative difference of two rates that are one: UFF58 has six digits
NOMINAL = 0.1  # relative difference up to which a stated rate may be the nominal one of an abscissa
COARSE = 1e-3  # largest rounding of a time column, as a fraction of the record
TOGETHER = 1e-6  # samples by which two starts may differ and be one


@dataclass(frozen=True, eq=False)
class TimeScale:
    """The time scale of a record. rate: Hz. told: what was taken from the file. doubts: names of
    what was contradicted. times: uneven sample times in s by channel, to be made even.
    """

    rate: float
    told: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
    times: Mapping[str, Array] | None = None


@dataclass(frozen=True, eq=False)
class EvenScale:
    """An even scale fitted to sample times. uneven: the times themselves where they deviate by more
    than rounding, None otherwise. loose: relative uncertainty of the rate by the rounding.
    """

    rate: float
    uneven: Array | None
    loose: float


def even_scale(file: Path, what: str, seconds: Array, resolution: float) -> EvenScale:
    """Return the even scale through all sample times (s), by least squares over the whole length.

    resolution: largest rounding of a time, s; it is no unevenness. Raises FormatError where times
    repeat or go back, where samples are missing, or where the times scatter.
    """
    count = seconds.size
    place = np.arange(count) - (count - 1) / 2
    step = float(place @ (seconds - seconds.mean()) / (place @ place)) if count > 1 else 0.0
    if not step > 0:
        raise FormatError(f"{file}: {what} is not even: its times do not rise")
    length = step * count
    if 2 * resolution > COARSE * length:
        raise FormatError(
            f"{file}: {what} is rounded to {2 * resolution:.2g} s, too coarse for a record of {length:.3g} s: leave it out "
            "and write `rate:` in the mapping"
        )
    apart = seconds - seconds.mean() - step * place
    worst = float(np.abs(apart).max())
    loose = 2 * resolution / length
    if worst <= UNEVEN * step + 1.1 * resolution:
        return EvenScale(1 / step, None, loose)
    steps = np.diff(seconds)
    usual = float(np.median(steps))
    # Two rounded times: each step may be off by twice the rounding.
    odd = np.abs(steps - usual) > 0.5 * usual + 2 * resolution
    if odd.any() or 20 * resolution > usual:
        at = int(np.argmax(np.abs(steps - usual)))
        raise FormatError(
            f"{file}: {what} is not even: from sample {at} to {at + 1} it goes on by {steps[at]:.6g} s, elsewhere by "
            f"{usual:.6g} s; no gap or jump is allowed"
        )
    scatter = float(np.sqrt(np.mean((steps / steps.mean() - 1) ** 2)))
    if scatter > SCATTER:
        raise FormatError(
            f"{file}: {what} is not even: its steps scatter by {100 * scatter:.2g} %; where these are the times of a computer's "
            "clock and the samples are even, leave it out and write `rate:` in the mapping"
        )
    return EvenScale((count - 1) / float(seconds[-1] - seconds[0]), seconds, loose)


def evened(samples: Array, times: Array) -> Array:
    """Return samples at uneven times on the even scale between the first and the last time.

    A cubic spline: its error for n samples a cycle is (2 pi / n)^4 / 384 of a sine, 1e-9 at 257.
    """
    from scipy import interpolate

    library: Any = interpolate
    even = np.linspace(float(times[0]), float(times[-1]), times.size)
    return np.asarray(library.CubicSpline(times, samples)(even))


def time_scale(
    file: Path,
    mapping: RecordMap,
    channels: Mapping[str, FileColumn],
    time: FileColumn | None,
    beside: float | None,
) -> TimeScale:
    """Return the time scale of the channels.

    time: the column that the mapping names; beside: the rate of the JSON file beside an export, Hz.
    Raises FormatError where two statements differ, naming both, or where there is none.
    """
    stated: dict[str, tuple[float, float]] = {}
    told: list[str] = []
    doubts: list[str] = []
    uneven: dict[str, Array] = {}
    if time is not None and mapping.time is not None:
        unit = time_unit(file, mapping.time, time)
        if unit.told:
            told.append(f"time.unit: {unit.told}")
        size = TIME_UNITS[unit.unit]
        scale = even_scale(file, "the time column", time.samples * size, time.resolution * size)
        stated["the time column"] = (scale.rate, scale.loose)
        if scale.uneven is not None:
            uneven = dict.fromkeys(channels, scale.uneven)
    if mapping.rate is not None:
        stated["the mapping's `rate`"] = (mapping.rate, 0.0)
    if beside is not None:
        stated["the JSON file beside it"] = (beside, 0.0)
    for name, channel in channels.items():
        if channel.times is not None and time is None:
            found = _abscissa(file, name, channel.times, mapping)
            if found is not None:
                stated[f"the times of {name}"] = (found.rate, found.loose)
                if found.uneven is not None:
                    uneven[name] = found.uneven
        if channel.rate is None:
            continue
        own = stated.get(f"the times of {name}")
        if own is not None and SAME < abs(channel.rate / own[0] - 1) < NOMINAL:
            doubts.append(f"rate_{name}")
            told.append(
                f"{name}: {channel.rate:g} Hz stated, {own[0]:.6g} Hz by its times, which are taken"
            )
        else:
            stated[f"the file's rate of {name}"] = (channel.rate, 0.0)
    if not stated:
        raise FormatError(
            f"{file} does not say its sampling rate: write `rate:` or `time:` in the mapping"
        )
    _compare(file, stated)
    source, (rate, _) = next(iter(stated.items()))
    if "mapping" not in source:
        told.append(f"rate {rate:.10g} Hz by {source}")
    if uneven:
        told.append("samples put on an even time scale by their own times")
    return TimeScale(rate, tuple(told), tuple(doubts), uneven or None)


def _compare(file: Path, stated: Mapping[str, tuple[float, float]]) -> None:
    """Raise FormatError where two statements of the rate differ."""
    (first, (rate, loose)), *others = stated.items()
    for name, (other, other_loose) in others:
        if abs(other / rate - 1) > SAME + loose + other_loose:
            raise FormatError(
                f"{file}: {first} says {rate:.8g} Hz, {name} {other:.8g} Hz; correct one of them in the mapping or the file"
            )


def _abscissa(file: Path, name: str, times: FileColumn, mapping: RecordMap) -> EvenScale | None:
    """Return the scale of times that stand beside a channel; None where they say nothing: no unit,
    and a rate is stated that they fit in some unit, or they are a count of samples.
    """
    steps = np.diff(times.samples)
    what = f"the times of {name}"
    if steps.size and np.all(steps == 1.0):
        return None
    unit = unit_in_words(times.unit)
    if not unit and mapping.rate is not None:
        length = float(times.samples[-1] - times.samples[0])
        if not length > 0:
            return None
        rate = (times.samples.size - 1) / length
        fits = [
            size for size in TIME_UNITS.values() if abs(rate / size / mapping.rate - 1) < NOMINAL
        ]
        if not fits:
            raise FormatError(
                f"{file}: the mapping's `rate` says {mapping.rate:g} Hz, a column of times {rate:g} samples per unit of its; "
                "correct the rate, or write `time:` in its place"
            )
        if 2 * times.resolution > COARSE * length:
            return None
        return even_scale(file, what, times.samples * fits[0], times.resolution * fits[0])
    found = time_unit(file, TimeColumn(name), times)
    size = TIME_UNITS[found.unit]
    if mapping.rate is not None and 2 * times.resolution > COARSE * abs(
        float(np.ptp(times.samples))
    ):
        return None
    return even_scale(file, what, times.samples * size, times.resolution * size)


def aligned(
    file: Path, mapping: RecordMap, channels: Mapping[str, FileColumn], rate: float
) -> tuple[Mapping[str, FileColumn], tuple[str, ...]]:
    """Return force and acceleration from the later of their starts on, the force moved onto the
    times of the acceleration's samples, and what was taken from the file.

    Raises FormatError where the starts differ and the mapping states a delay as well, or where the
    channels do not overlap.
    """
    force, acceleration = channels["force"], channels["acceleration"]
    one, other = _start(force), _start(acceleration)
    if one is None or other is None or mapping.force.overrule or mapping.acceleration.overrule:
        return channels, ()
    lag = other.after(one)
    if abs(lag) * rate < TOGETHER:
        return channels, ()
    starts = f"force starts at {one.text}, acceleration at {other.text}"
    if mapping.force.delay or mapping.acceleration.delay:
        raise FormatError(
            f"{file}: {starts}, and the mapping states a delay: leave the delay out, or write `overrule: true` beside it where "
            "the starts mean nothing"
        )
    size = force.samples.size
    if abs(lag) * rate > size - 1:
        raise FormatError(f"{file}: {starts}: the channels have no time in common")

    def read(start: int, stop: int) -> Array:
        return force.samples[start:stop]

    moved = CorrectedSignal(read, size, (0.0, float(size)), 1 / rate, (), lag).samples()
    # Moved sample n is sample n + lag * rate of the record.
    first = max(0, int(np.ceil(-lag * rate - TOGETHER)))
    last = min(size, int(np.floor(size - 1 - lag * rate + TOGETHER)) + 1)
    told = (f"{starts}: aligned, {last - first} of {size} samples in common",)
    return {
        "force": replace(force, samples=np.ascontiguousarray(moved[first:last])),
        "acceleration": replace(
            acceleration, samples=np.ascontiguousarray(acceleration.samples[first:last])
        ),
    }, told


def _start(channel: FileColumn) -> Instant | None:
    """Return the time of a channel's first sample, None where the file tells none."""
    if channel.start is not None or channel.times is None:
        return channel.start
    size = TIME_UNITS.get(unit_in_words(channel.times.unit) or "s", 1.0)
    first = float(channel.times.samples[0]) * size
    return Instant(0, first, f"{first:g} s")


def sizes(file: Path, channels: Mapping[str, FileColumn]) -> None:
    """Raise FormatError where the channels have different numbers of samples, or rates."""
    counts = {name: channel.samples.size for name, channel in channels.items()}
    rates = [channel.rate for channel in channels.values() if channel.rate is not None]
    if rates and max(rates) > min(rates) * (1 + SAME):
        said = ", ".join(
            f"{name} {channel.rate:g} Hz" for name, channel in channels.items() if channel.rate
        )
        raise FormatError(
            f"{file}: the channels have different rates ({said}): they must be sampled together"
        )
    if len(set(counts.values())) > 1:
        found = " and ".join(f"{count} samples of {name}" for name, count in counts.items())
        raise FormatError(f"{file}: {found}: they must be sampled together")
