"""Faults that a record of another laboratory shows by itself: values held or interpolated, a
saturated channel. Coarse steps of a converter are no fault.
"""

import math

import numpy as np
from numpy.typing import NDArray

from analysis.signals.stationary import noise_rms

__all__ = ["FOUND", "clipped", "examined"]

Array = NDArray[np.float64]

FOUND = ("held", "resampled", "saturated", "unit", "rate", "drive_line")
"""Flags of an import, before the channel's name; the last three from contradictions of a file."""

MOST_HELD = 16  # largest number of samples for which one value may be held
CONCENTRATED = 0.9  # share of all changes that fall on every k-th sample
BINS = 256  # phases of a mean cycle
NEAR, FAR = 0.003, 0.03  # distances from an extreme, fractions of the amplitude
SHARP = 5.0
"""Exponent of the descent from an extreme: 2 for a sine, 4 for the flattest sum of two harmonics, 6 for a
sine clipped at 0.98 of its amplitude, 20 at 0.88."""
COARSEST = 0.05  # resolution, as a fraction of the amplitude, beyond which no shape is judged
STUCK = 3  # equal extreme samples in a row: clipped, where the resolution does not explain them


def examined(values: Array, rate: float, frequency: float, ranged: bool) -> tuple[str, ...]:
    """Return the faults of a channel's samples: held, resampled, saturated.

    rate, frequency: of samples and drive, Hz. ranged: the channel's range is known, so that a flat
    top below it is the signal's own (a slider's friction has one).
    """
    found = []
    if _comb(np.diff(values)) or _runs(values):
        found.append("held")
    elif _comb(np.diff(values, 2)):
        found.append("resampled")
    if not ranged and _flat(values, rate, frequency):
        found.append("saturated")
    return tuple(found)


def _comb(changes: Array) -> bool:
    """Return whether nearly all the changes fall on every k-th place, for some k from 2 on."""
    square = changes * changes
    total = float(square.sum())
    if not total > 0:
        return False
    for k in range(2, MOST_HELD + 1):
        whole = square[: square.size - square.size % k].reshape(-1, k)
        # A slow signal's changes are alike at all places: the share of one is 1 / k.
        if whole.shape[0] >= 16 and float(whole.sum(axis=0).max()) > CONCENTRATED * total:
            return True
    return False


def _runs(values: Array) -> bool:
    """Return whether values repeat in runs of nearly equal length, as where a slower channel is held
    for 3 and 4 samples in turn. The runs of a coarsely resolved sine are of all lengths.
    """
    starts = np.flatnonzero(np.diff(values))
    if starts.size < 32:
        return False
    short, long = np.quantile(np.diff(starts), (0.05, 0.95))
    return bool(short >= 2 and long <= short + 1)


def resolution_of(values: Array) -> float:
    """Return the step between neighbouring values of a coarsely resolved channel, 0 for a fine one."""
    every = np.unique(values)
    if every.size < 2 or every.size > values.size / 8:
        return 0.0
    return float(np.median(np.diff(every)))


def _flat(values: Array, rate: float, frequency: float) -> bool:
    """Return whether the mean cycle has a flat top or bottom with corners, which a saturated
    amplifier makes, before noise or after it.
    """
    phase = np.arange(values.size) * (frequency / rate) % 1.0
    place = (phase * BINS).astype(np.intp)
    count = np.bincount(place, minlength=BINS)
    if count.min() < 1:
        return False
    cycle = np.bincount(place, weights=values, minlength=BINS) / count
    middle, amplitude = 0.5 * (cycle.max() + cycle.min()), 0.5 * float(np.ptp(cycle))
    if not amplitude > 0:
        return False
    noise = noise_rms(values, rate / frequency) / math.sqrt(float(count.min()))
    step = resolution_of(values)
    near = max(NEAR, 4 * noise / amplitude, step / amplitude)
    if near > COARSEST:
        return False
    ratio = FAR / NEAR
    for turned in (cycle - middle, middle - cycle):
        top = float(turned.max())
        inner, outer = (_width(turned, top - share * amplitude) for share in (near, ratio * near))
        # A width below two bins is that of the bins.
        if inner > 4 and outer < BINS / 2 and math.log(ratio) > SHARP * math.log(outer / inner):
            return True
    return False


def _width(cycle: Array, level: float) -> float:
    """Return the number of bins about the largest value that stay above a level."""
    rolled = np.roll(cycle, BINS // 2 - int(cycle.argmax()))
    below = np.flatnonzero(rolled < level)
    left, right = below[below < BINS // 2], below[below > BINS // 2]
    if not left.size or not right.size:
        return float(BINS)
    return float(right[0] - left[-1] - 1)


def clipped(values: Array, limit: float | None, period: float) -> NDArray[np.bool_]:
    """Return which samples are clipped: those at the range or, if that is not known, equal extreme
    values in a row, more of them than the resolution makes at the crest of a sine.

    period: of the drive, samples
    """
    if limit is not None:
        return np.asarray(np.abs(values) >= limit)
    found = np.zeros(values.size, dtype=bool)
    step, amplitude = resolution_of(values), 0.5 * float(np.ptp(values))
    crest = 0.0
    if amplitude > 0:
        # A sine of amplitude A stays within a step of its crest for 2 sqrt(2 step / A) rad.
        crest = 2 * math.sqrt(2 * step / amplitude) * period / (2 * math.pi)
    length = STUCK + (math.ceil(2 * crest) if step else 0)
    for extreme in (values.max(), values.min()):
        at = np.concatenate(([False], values == extreme, [False]))
        edges = np.flatnonzero(np.diff(at.astype(np.int8)))
        first, last = edges[::2], edges[1::2]
        long = last - first >= length
        for begin, end in zip(first[long], last[long], strict=True):
            found[begin:end] = True
    return found
