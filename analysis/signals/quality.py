"""What a record itself tells of its channels: stuck values, steps, slips, noise and spikes that no
flag announced.

A steady drive repeats: per cycle, a channel has a mean, a fundamental (size and phase) and a
remainder about the mean cycle. A fault shows as a change of one of them that the scatter from cycle
to cycle does not explain. Where the bed's own scatter is larger, the fault is not seen;
`docs/acquisition.md` says how large it may be.

A motion that is free (shaker-coupled drive: no waveform is held) does not repeat: its impacts come
and go, and its level and phase glide where the bed settles. There a fault must show in what a
motion cannot do: noise in the quiet part of a cycle, between the impacts, and a step from one cycle
to the next.
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

STUCK = 16  # equal values in a row: a sine of 200 codes has fewer at its crest, at 512 samples to a cycle
SURE = 10.0  # step over its own standard deviation: cycles of a bed are not independent (6 was seen in 428 runs)
LEAST = {"bias": 5e-3, "gain_step": 5e-3, "clock_slip": 2e-3}  # of the fundamental, of itself, rad
LONE = 5.0  # a spike against the twentieth largest remainder elsewhere: a bed's own impacts come in numbers
GAUSSIAN = 7.0  # largest over rms: noise has less in any record, impacts and spikes have more
NOISY = 3.0  # rms of a cycle's remainder over the usual one, and over the certified noise
CLIPS = 0.98  # of the sensor's own limit
QUIET = 0.1  # share of a cycle's fourth differences that is quiet: between the impacts
FOURTH = math.sqrt(
    70 / 6
)  # rms of fourth over second differences of white noise; of a motion that is sampled well 1.4
SUDDEN = 0.6  # share of a step that no cycle bridges: 0.47 was seen of a bed that glides, in 320 runs; faults left 0.69
BESIDE = 4  # cycles on either side of a sudden step
NOTHING = 3.0  # a fundamental below so many certified noises is no signal

OVERLOAD = int(Flag.OVERLOAD_HI | Flag.OVERLOAD_LO)

REFUSED = {
    "stuck": "is stuck: equal values in a row",
    "no_signal": "carries no signal above its noise",
}
SUSPECT = ("gain_step", "clock_slip", "noisy", "spike", "sensor_clip")
CORRECTED = ("bias", "drift")


@dataclass(frozen=True, eq=False)
class Cycles:
    """Features of one channel over consecutive cycles, arrays of (cycles,): mean; fundamental, peak
    phasor; fast: rms of the second differences of what the mean cycle leaves, and crest, their
    largest over that. spike: their largest over the twentieth largest elsewhere; stuck: most equal
    values in a row; peak: largest magnitude; quiet: of a free motion the decile of the fourth
    differences' magnitudes, else nothing, (0,)."""

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
    """Features of a window of whole cycles, (cycles * points,), poles not undone. smooth: nothing
    in the condition knocks at this channel; only then does a lone spike mean anything, and only
    then is it looked for. stuck: of the samples as recorded. free: no waveform is held."""
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
    """Cosine and negative sine over a cycle, (2, points)."""
    turn = 2 * np.pi * np.arange(points) / points
    return np.stack([np.cos(turn), -np.sin(turn)])


def _fast(x: Array) -> Array:
    """Second differences of what the mean cycle leaves of (cycles, points)."""
    rest = x - x.mean(axis=0)
    return np.asarray(rest[:, 2:] + rest[:, :-2] - 2 * rest[:, 1:-1])


class Scrutiny:
    """Looks at a run's force and acceleration stretch by stretch, in constant memory; each stretch
    is compared with the one before it and with the first."""

    def __init__(self, channels: Sequence[ChannelFacts], setting: Setting) -> None:
        self._channels, self._smooth, self._omega = (
            channels,
            _smooth(setting),
            2 * math.pi * setting.frequency,
        )
        self._settled, self._free = (
            setting.settle_cycles / setting.frequency,
            setting.drive == "shaker",
        )
        self._known: list[tuple[Cycles, ...]] = [() for _ in channels]
        self._found: dict[tuple[str, str], None] = {}

    def add(self, signals: Sequence[Signal], on_grid: Sequence[Array], cycles: int) -> None:
        """The next stretch: signals as recorded, and with a whole number of points to each cycle."""
        for k, (channel, signal, values) in enumerate(
            zip(self._channels, signals, on_grid, strict=True)
        ):
            stuck = 1 if signal.flags & OVERLOAD else longest_stuck(signal.samples)
            part = features(
                np.ascontiguousarray(values), cycles, self._smooth[k], stuck, self._free
            )
            names = doubts(channel, part, self._omega, self._settled, self._smooth[k])
            known = (
                self._known[k][-1:] if self._free else self._known[k]
            )  # a free motion may glide from the first one
            for other in known:
                names += changes(channel, other, part, self._omega, self._settled)
            self._found |= dict.fromkeys((name, channel.name) for name in names)
            self._known[k] = (*self._known[k][:1], part)

    def flags(self, run: str) -> tuple[str, ...]:
        """Flags "bias_force"... AnalysisError for what cannot be read at all."""
        for name, channel in self._found:
            if name in REFUSED:
                raise AnalysisError(f"{run}: the channel {channel} {REFUSED[name]}")
        return tuple(f"{name}_{channel}" for name, channel in self._found)


def _smooth(setting: Setting) -> tuple[bool, bool]:
    """Whether nothing knocks at force and acceleration: a programmed motion, a box in which nothing
    slides.
    """
    prescribed = setting.drive == "prescribed"
    return prescribed and (
        setting.is_empty or setting.is_bonded or setting.bed == "dashpot"
    ), prescribed


def longest_stuck(samples: Array) -> int:
    """Length of the longest stretch of equal values."""
    equal = samples[1:] == samples[:-1]
    if np.count_nonzero(equal) < STUCK - 1:
        return 1
    edges = np.flatnonzero(np.diff(np.concatenate(([False], equal, [False])).astype(np.int8)))
    return int((edges[1::2] - edges[::2]).max()) + 1


def doubts(
    channel: ChannelFacts, part: Cycles, omega: float, settled: float, smooth: bool
) -> tuple[str, ...]:
    """Names of what is wrong with a channel over a stretch. omega: rad/s; settled: s from the
    drive's start to the window (what is left of the poles' start is no fault); smooth: as for
    `features`."""
    found = ["stuck"] if part.stuck >= STUCK else []
    middle = complex(part.fundamental.mean())
    if abs(middle) <= NOTHING * channel.noise_rms:
        return (*found, "no_signal")
    # of second differences of white noise, rounding included
    floor = math.sqrt(
        6.0 * (channel.noise_rms**2 + (channel.scale / channel.sensitivity) ** 2 / 12)
    )
    stated = smooth and channel.noise_rms > 0  # else the other cycles are the measure
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
    if _stepped(np.angle(part.fundamental / middle), LEAST["clock_slip"], sudden):
        found.append("clock_slip")
    offset = part.mean / abs(middle)
    if _stepped(offset, LEAST["bias"] + _of_start(channel, omega, settled)):
        found.append("drift" if _sloped(offset) else "bias")
    return tuple(found)


def changes(
    channel: ChannelFacts, one: Cycles, other: Cycles, omega: float, settled: float
) -> tuple[str, ...]:
    """Names of what changed in a channel from one stretch to another."""
    middle = complex(one.fundamental.mean())
    level = abs(middle)
    if not level:
        return ()
    series = {
        "gain_step": (np.abs(one.fundamental) / level, np.abs(other.fundamental) / level),
        "clock_slip": (np.angle(one.fundamental / middle), np.angle(other.fundamental / middle)),
        "bias": (one.mean / level, other.mean / level),
    }
    start = {"bias": _of_start(channel, omega, settled)}
    sudden = dict.fromkeys(("gain_step", "clock_slip"), SUDDEN) if one.quiet.size else {}
    return tuple(
        name
        for name, (a, b) in series.items()
        if _apart(a, b, LEAST[name] + start.get(name, 0.0), sudden.get(name, 0.0))
    )


def _of_start(channel: ChannelFacts, omega: float, settled: float) -> float:
    """How far the mean may slide as the poles' start dies away, over the fundamental, with a factor
    of 2.
    """
    return 2 * sum(math.exp(-settled / tau) / (omega * tau) for tau in channel.time_constants)


def _median(values: Array) -> float:
    """np.median, which takes ten times as long over so few values."""
    ordered, half = np.sort(values), values.size // 2
    return float(ordered[half]) if values.size % 2 else float(ordered[half - 1] + ordered[half]) / 2


def _lone(fast: Array) -> float:
    """The largest value over the twentieth largest of those more than 8 places away; 0 where there
    are too few.
    """
    top = int(fast.argmax())
    others = np.concatenate((fast[: max(top - 8, 0)], fast[top + 9 :]))
    if others.size < 200:
        return 0.0
    usual = float(np.partition(others, others.size - 20)[others.size - 20])
    return float(fast[top]) / usual if usual > 0 else 0.0


def _loud(quiet: Array, floor: float) -> NDArray[np.bool_]:
    """Whether each cycle's quiet part is louder than usual by NOISY, and by SURE of the deviations
    that the cycles have (robust, of the logarithm: a motion's roughness varies in proportion).
    floor: rms of the certified noise's second differences; the normal decile of magnitudes is 0.126
    of the rms. All are where nothing is known of it, (1,)."""
    if not quiet.size:
        return np.ones(1, dtype=np.bool_)
    level = np.log(np.maximum(quiet, max(0.126 * FOURTH * floor, math.ulp(0.0))))
    above = level - np.median(level)
    deviation = 1.4826 * float(
        np.median(np.abs(above))
    )  # a normal deviation from the median magnitude
    return np.asarray((above > math.log(NOISY)) & (above > SURE * deviation))


def _gap(a: Array, b: Array) -> float:
    """Distance between the nearest values of two groups, 0 where they overlap."""
    return max(0.0, float(b.min() - a.max()), float(a.min() - b.max()))


def _stepped(series: Array, least: float, sudden: float = 0.0) -> bool:
    """Whether a series steps or slides by more than `least`, and by more than its scatter explains:
    the largest difference between the means before and after a place. sudden: share of the step
    that must be empty between all values before and all after, the two at the place left out (the
    step may lie within one of them), with BESIDE cycles on either side (the end of a glide looks
    like a step otherwise)."""
    n = series.size
    if n < 8 or float(series.max() - series.min()) <= least:
        return False
    k = np.arange(2, n - 1)
    before, total = np.cumsum(series)[k - 1], float(series.sum())
    steps = (total - before) / (n - k) - before / k
    place = int(np.abs(steps).argmax())
    size, cut = abs(float(steps[place])), int(k[place])
    if sudden and (
        min(cut, n - cut) < BESIDE or _gap(series[: cut - 1], series[cut + 1 :]) < sudden * size
    ):
        return False
    return size > least and size > SURE * _scatter(series) * math.sqrt(1 / cut + 1 / (n - cut))


def _apart(a: Array, b: Array, least: float, sudden: float = 0.0) -> bool:
    """Whether two stretches differ by more than `least`, and by more than their scatter explains.
    sudden: share of the difference that must be empty between them."""
    size = abs(float(b.mean() - a.mean()))
    if min(a.size, b.size) < 8 or size <= least or (sudden and _gap(a, b) < sudden * size):
        return False
    return size > SURE * math.hypot(
        _scatter(a) / math.sqrt(a.size), _scatter(b) / math.sqrt(b.size)
    )


def _scatter(series: Array) -> float:
    """Standard deviation of a series by the differences of neighbours, the two largest left out: a
    step, a slope and a single bad cycle do not raise it, and alternation from cycle to cycle, as
    beds have it, is counted in full."""
    differences = np.sort(np.abs(np.diff(series)))[:-2]
    return math.sqrt(float((differences**2).mean()) / 2)


def _sloped(series: Array) -> bool:
    """Whether a line explains a series better than a step does."""
    n = series.size
    t = np.arange(n) - (n - 1) / 2
    line = series - series.mean() - t * float((t * series).sum() / (t * t).sum())
    k = np.arange(1, n)
    before, total = np.cumsum(series)[:-1], float(series.sum())
    gained = before**2 / k + (total - before) ** 2 / (n - k) - total**2 / n
    return float((line**2).sum()) < float(((series - series.mean()) ** 2).sum() - gained.max())
