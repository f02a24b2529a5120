"""Quality of the channels from the record itself: stuck values, steps, slips, noise and spikes
without a flag.

A steady drive repeats: per cycle, a channel has a mean, a fundamental (magnitude and phase) and a
remainder about the mean cycle. A fault changes one of them by more than the scatter from cycle to
cycle explains. Where the bed's own scatter is larger, the fault is not detected;
`docs/acquisition.md` states the detectable sizes.

A free motion (shaker-coupled drive: no waveform is controlled) does not repeat: its impacts come
and go, and level and phase glide while the bed settles. There a fault must show in a feature that a
motion cannot have: noise in the quiet part of a cycle, between the impacts, or a step from one
cycle to the next.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analysis.session.record import AnalysisError, ChannelFacts, Signal
from analysis.session.setting import Setting
from analysis.signals.compiled_loops import cycle_features
from daq.chain.block import Flag

__all__ = [
    "CORRECTED",
    "REFUSED",
    "SUSPECT",
    "Cycles",
    "Scrutiny",
    "changes",
    "doubts",
    "features",
    "longest_stuck",
]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

STUCK = 16
"""Equal values in succession that count as stuck: a sine with an amplitude of 200 codes has fewer at its
crest, at 512 samples per cycle."""
SURE = 10.0
"""A step over its own standard deviation: cycles of a bed are not independent (the largest of 428 sound
runs was 6)."""
LEAST = {"bias": 5e-3, "gain_step": 5e-3, "clock_slip": 2e-3}
"""Smallest change that counts: relative to the fundamental, relative, rad."""

LONE = 5.0
"""A spike over the twentieth largest remainder elsewhere: the impacts of a bed come in larger numbers."""

GAUSSIAN = 7.0  # largest over rms: noise has less in any record, impacts and spikes have more
NOISY = 3.0  # rms of a cycle's remainder over the usual one, and over the certified noise
CLIPS = 0.98  # of the sensor's own limit
QUIET = 0.1  # fraction of a cycle's fourth differences that counts as quiet: between the impacts
FOURTH = math.sqrt(70 / 6)
"""Rms of the fourth over that of the second differences of white noise: coefficients (1, -4, 6, -4, 1)
and (1, -2, 1). A well sampled motion has 1.4."""
SUDDEN = 0.6
"""Fraction of a sudden step that no cycle bridges: at most 0.47 for gliding beds in 320 runs, at least
0.69 for faults."""
BESIDE = 4  # fewest cycles on either side of a sudden step
NOTHING = 3.0  # multiple of the certified noise below which a fundamental is no signal

OVERLOAD = int(Flag.OVERLOAD_HI | Flag.OVERLOAD_LO)

REFUSED = {
    "stuck": "is stuck: equal values in a row",
    "no_signal": "carries no signal above its noise",
}
SUSPECT = ("gain_step", "clock_slip", "noisy", "spike", "sensor_clip")
CORRECTED = ("bias", "drift")


@dataclass(frozen=True, eq=False)
class Cycles:
    """Features of one channel over consecutive cycles; arrays are (cycles,).

    mean : of each cycle
    fundamental : peak phasor
    fast : rms of the second differences of the remainder about the mean cycle
    crest : their largest over that rms
    spike : their largest over the twentieth largest elsewhere; 0 where none was looked for
    stuck : length of the longest sequence of equal values
    peak : largest magnitude
    quiet : of a free motion the tenth percentile of the magnitudes of the fourth differences;
        otherwise (0,)
    """

    mean: Array
    fundamental: Complex
    fast: Array
    crest: Array
    spike: float
    stuck: int
    peak: float
    quiet: Array


def features(
    samples: Array, cycles: int, smooth: bool, stuck: int = 1, free: bool = False
) -> Cycles:
    """Return the features of a window of whole cycles, (cycles * points,), poles not corrected.

    smooth: no impacts reach this channel; only then does a lone spike mean anything, and only then
    is it looked for. stuck: longest sequence of equal values in the samples as recorded. free: no
    waveform is controlled.
    """
    points = samples.size // cycles
    mean, parts, rms, top, peak = cycle_features(samples, cycles, _turn(points))
    lone = smooth and float(top.max()) > GAUSSIAN * float(np.sqrt((rms**2).mean()))
    fast = _fast(samples.reshape(cycles, points)) if lone or free else np.empty(0)
    quiet = np.quantile(np.abs(np.diff(fast, 2, axis=1)), QUIET, axis=1) if free else np.empty(0)
    return Cycles(
        mean=mean,
        fundamental=parts.view(np.complex128)[:, 0] * (2 / points),
        fast=rms,
        crest=np.divide(top, rms, out=np.zeros_like(top), where=rms > 0),
        spike=_lone(np.abs(fast).ravel()) if lone else 0.0,
        stuck=stuck,
        peak=peak,
        quiet=quiet,
    )


@lru_cache(maxsize=4)
def _turn(points: int) -> Array:
    """Return cosine and negative sine over a cycle, (2, points)."""
    turn = 2 * np.pi * np.arange(points) / points
    return np.stack([np.cos(turn), -np.sin(turn)])


def _fast(x: Array) -> Array:
    """Return the second differences of the remainder about the mean cycle, (cycles, points - 2)."""
    rest = x - x.mean(axis=0)
    return np.asarray(rest[:, 2:] + rest[:, :-2] - 2 * rest[:, 1:-1])


class Scrutiny:
    """A check of a run's force and acceleration, in constant memory: each stretch is compared with
    the previous and the first one.
    """

    def __init__(self, channels: Sequence[ChannelFacts], setting: Setting) -> None:
        self._channels = channels
        self._smooth = _smooth(setting)
        self._omega = 2 * math.pi * setting.frequency
        self._settled = setting.settle_cycles / setting.frequency
        self._free = setting.drive == "shaker"
        self._known: list[tuple[Cycles, ...]] = [() for _ in channels]
        self._found: dict[tuple[str, str], None] = {}

    def add(self, signals: Sequence[Signal], on_grid: Sequence[Array], cycles: int) -> None:
        """Add the next stretch: signals as recorded, and with a whole number of points to each
        cycle.
        """
        for k, (channel, signal, values) in enumerate(
            zip(self._channels, signals, on_grid, strict=True)
        ):
            stuck = 1 if signal.flags & OVERLOAD else longest_stuck(signal.samples)
            part = features(
                np.ascontiguousarray(values), cycles, self._smooth[k], stuck, self._free
            )
            names = doubts(channel, part, self._omega, self._settled, self._smooth[k])
            # A free motion may glide away from the first stretch: compare with the previous one only.
            known = self._known[k][-1:] if self._free else self._known[k]
            for other in known:
                names += changes(channel, other, part, self._omega, self._settled)
            self._found |= dict.fromkeys((name, channel.name) for name in names)
            self._known[k] = (*self._known[k][:1], part)

    def flags(self, run: str) -> tuple[str, ...]:
        """Return flags such as "bias_force". AnalysisError for a channel that cannot be read at
        all.
        """
        for name, channel in self._found:
            if name in REFUSED:
                raise AnalysisError(f"{run}: the channel {channel} {REFUSED[name]}")
        return tuple(f"{name}_{channel}" for name, channel in self._found)


def _smooth(setting: Setting) -> tuple[bool, bool]:
    """Return whether force and acceleration are free of impacts: a prescribed motion, and a box in
    which nothing slides.
    """
    prescribed = setting.drive == "prescribed"
    return prescribed and (
        setting.is_empty or setting.is_bonded or setting.bed == "dashpot"
    ), prescribed


def longest_stuck(samples: Array) -> int:
    """Return the length of the longest sequence of equal values."""
    equal = samples[1:] == samples[:-1]
    if np.count_nonzero(equal) < STUCK - 1:
        return 1
    edges = np.flatnonzero(np.diff(np.concatenate(([False], equal, [False])).astype(np.int8)))
    return int((edges[1::2] - edges[::2]).max()) + 1


def doubts(
    channel: ChannelFacts, part: Cycles, omega: float, settled: float, smooth: bool
) -> tuple[str, ...]:
    """Return the names of the faults of a channel within a stretch.

    omega: rad/s; settled: s from the start of the drive to the window (the decaying start of the
    poles is no fault); smooth: as for `features`.
    """
    found = ["stuck"] if part.stuck >= STUCK else []
    middle = _mean(part.fundamental)
    if abs(middle) <= NOTHING * channel.noise_rms:
        return (*found, "no_signal")
    # rms of the second differences of white noise (1 + 4 + 1 = 6), quantisation (1/12) included
    floor = math.sqrt(
        6.0 * (channel.noise_rms**2 + (channel.scale / channel.sensitivity) ** 2 / 12)
    )
    stated = smooth and channel.noise_rms > 0  # otherwise compare with the other cycles
    usual = floor if stated else max(_median(part.fast), floor)
    loud = part.fast > NOISY * usual
    if loud.any() and (loud & (part.crest < GAUSSIAN) & _loud(part.quiet, floor)).any():
        found.append("noisy")
    if part.spike > LONE:
        found.append("spike")
    if channel.clips_at and part.peak > CLIPS * channel.clips_at / channel.sensitivity:
        found.append("sensor_clip")
    sudden = SUDDEN if part.quiet.size else 0.0
    if _stepped(np.abs(part.fundamental) / abs(middle), LEAST["gain_step"], sudden):
        found.append("gain_step")
    if _stepped(_angle(part.fundamental / middle), LEAST["clock_slip"], sudden):
        found.append("clock_slip")
    offset = part.mean / abs(middle)
    if _stepped(offset, LEAST["bias"] + _of_start(channel, omega, settled)):
        found.append("drift" if _sloped(offset) else "bias")
    return tuple(found)


def changes(
    channel: ChannelFacts, one: Cycles, other: Cycles, omega: float, settled: float
) -> tuple[str, ...]:
    """Return the names of the faults of a channel that show as a change from one stretch to
    another.
    """
    middle = _mean(one.fundamental)
    level = abs(middle)
    if not level:
        return ()
    series = {
        "gain_step": (np.abs(one.fundamental) / level, np.abs(other.fundamental) / level),
        "clock_slip": (_angle(one.fundamental / middle), _angle(other.fundamental / middle)),
        "bias": (one.mean / level, other.mean / level),
    }
    start = {"bias": _of_start(channel, omega, settled)}
    sudden = dict.fromkeys(("gain_step", "clock_slip"), SUDDEN) if one.quiet.size else {}
    return tuple(
        name
        for name, (a, b) in series.items()
        if _apart(a, b, LEAST[name] + start.get(name, 0.0), sudden.get(name, 0.0))
    )


def _mean(values: Complex) -> complex:
    """Return the mean; np.mean takes four times as long for a few dozen values."""
    return complex(values.sum()) / values.size


def _angle(values: Complex) -> Array:
    """Return the angles, rad."""
    return np.arctan2(values.imag, values.real)


def _of_start(channel: ChannelFacts, omega: float, settled: float) -> float:
    """Return the drift of the mean by the decaying start of the poles, over the fundamental, with a
    factor of 2 for safety.
    """
    return 2 * sum(math.exp(-settled / tau) / (omega * tau) for tau in channel.time_constants)


def _median(values: Array) -> float:
    """Return the median; np.median takes ten times as long for a few dozen values."""
    ordered, half = np.sort(values), values.size // 2
    return float(ordered[half]) if values.size % 2 else float(ordered[half - 1] + ordered[half]) / 2


def _lone(fast: Array) -> float:
    """Return the largest value over the twentieth largest of those more than 8 places away; 0 for
    too few values.
    """
    top = int(fast.argmax())
    others = np.concatenate((fast[: max(top - 8, 0)], fast[top + 9 :]))
    if others.size < 200:
        return 0.0
    usual = float(np.partition(others, others.size - 20)[others.size - 20])
    return float(fast[top]) / usual if usual > 0 else 0.0


def _loud(quiet: Array, floor: float) -> NDArray[np.bool_]:
    """Return for each cycle whether its quiet part is too loud, (cycles,); (1,) True where there is
    no quiet part.

    Too loud: by NOISY over the median, and by SURE robust standard deviations of the logarithms
    (the roughness of a motion varies in proportion). floor: rms of the second differences of the
    certified noise; the lowest decile of a normal deviate's magnitude is 0.126 of its rms.
    """
    if not quiet.size:
        return np.ones(1, dtype=np.bool_)
    level = np.log(np.maximum(quiet, max(0.126 * FOURTH * floor, math.ulp(0.0))))
    above = level - np.median(level)
    # 1.4826: standard deviation of a normal variable over its median magnitude
    deviation = 1.4826 * float(np.median(np.abs(above)))
    return np.asarray((above > math.log(NOISY)) & (above > SURE * deviation))


def _gap(a: Array, b: Array) -> float:
    """Return the distance between the nearest values of two groups, 0 where they overlap."""
    return max(0.0, float(b.min() - a.max()), float(a.min() - b.max()))


def _stepped(series: Array, least: float, sudden: float = 0.0) -> bool:
    """Return whether a series steps or slides by more than `least`, and by more than its scatter
    explains.

    The step is the largest difference between the means before and after a place. sudden: fraction
    of the step that must be empty between all values before and all after. The two values at the
    place are left out (the step may lie within one of them), and BESIDE cycles are needed on either
    side (otherwise the end of a glide looks like a step).
    """
    n = series.size
    if n < 8 or float(series.max() - series.min()) <= least:
        return False
    sums, (k, left) = series.cumsum(), _places(n)
    before = sums[1:-2]
    steps = np.abs((sums[-1] - before) / left - before / k)
    place = int(steps.argmax())
    size, cut = float(steps[place]), place + 2
    if sudden and (
        min(cut, n - cut) < BESIDE or _gap(series[: cut - 1], series[cut + 1 :]) < sudden * size
    ):
        return False
    return size > least and size > SURE * _scatter(series) * math.sqrt(1 / cut + 1 / (n - cut))


@lru_cache(maxsize=16)
def _places(n: int) -> tuple[Array, Array]:
    """Return the number of values before and after each place of n where a step may be."""
    k = np.arange(2.0, n - 1)
    return k, n - k


def _apart(a: Array, b: Array, least: float, sudden: float = 0.0) -> bool:
    """Return whether two stretches differ by more than `least`, and by more than their scatter
    explains.

    sudden: fraction of the difference that must be empty between them.
    """
    size = abs(float(b.sum() / b.size - a.sum() / a.size))
    if min(a.size, b.size) < 8 or size <= least or (sudden and _gap(a, b) < sudden * size):
        return False
    return size > SURE * math.hypot(
        _scatter(a) / math.sqrt(a.size), _scatter(b) / math.sqrt(b.size)
    )


def _scatter(series: Array) -> float:
    """Return the standard deviation of a series from the differences of neighbours, without the two
    largest.

    A step, a slope and a single bad cycle do not raise it; alternation from cycle to cycle, as beds
    have it, counts in full.
    """
    differences = np.abs(series[1:] - series[:-1])
    differences.sort()
    usual = differences[:-2]
    return math.sqrt(float(usual @ usual) / (2 * usual.size))


def _sloped(series: Array) -> bool:
    """Return whether a line explains a series better than a step does."""
    n = series.size
    t = np.arange(n) - (n - 1) / 2
    line = series - series.mean() - t * float((t * series).sum() / (t * t).sum())
    k = np.arange(1, n)
    before, total = np.cumsum(series)[:-1], float(series.sum())
    gained = before**2 / k + (total - before) ** 2 / (n - k) - total**2 / n
    return float((line**2).sum()) < float(((series - series.mean()) ** 2).sum() - gained.max())
