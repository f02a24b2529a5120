"""The front end's anti-alias filter: two linear-phase Kaiser designs, decimating by 4 and then by
2.

With the output rate fs, stage 1 works at 8 fs (pass band to 0.45 fs, stop band from 1.45 fs; stage
2 stops what it lets through in between) and stage 2 at 2 fs, a half-band filter (pass band to 0.45
fs, stop band from 0.55 fs). The delays are half-integer in output samples, 3.5 and 35.5, so that
the total delay is the integer 39.

Every output is the same sum in the same order however the stream is cut, because the vectorised
loop runs over outputs.

A channel that is sampled slightly late or early has its own stage 1: the same low-pass, sampled
between its taps. That needs no extra pass, and costs nothing where there is no skew.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from daq.chain.source import FloatArray
from daq.compiled import njit

__all__ = ["DELAY", "OVERSAMPLING", "STAGE1", "STAGE2", "Decimator", "shifted_lowpass"]

OVERSAMPLING = 8
TILE = 512  # outputs per pass: their inputs (8 x 512 doubles) stay in the first-level cache

IntArray = npt.NDArray[np.int64]


def shifted_lowpass(taps: int, cutoff: float, attenuation: float, delay: float = 0.0) -> FloatArray:
    """Return a Kaiser-windowed low-pass of unit sum that delays by half its length plus `delay`
    inputs (|delay| <= 1/2).

    cutoff: half-amplitude frequency over the rate; attenuation: dB, > 50. numpy's sinc and kaiser
    are avoided: their last digits depend on the processor, and so would the codes.
    """
    if not abs(delay) <= 0.5:
        raise ValueError(
            f"a skew of {delay:g} oversampled intervals: at most half an interval can be filtered in"
        )
    beta = 0.1102 * (attenuation - 8.7)  # Kaiser 1974
    half = (taps - 1) / 2
    n = np.arange(taps) - half - delay
    x = 2 * math.pi * cutoff * n
    sinc = np.array([math.sin(value) / value if value else 1.0 for value in x])
    h = sinc * bessel_i0(beta * np.sqrt(np.maximum(1 - (n / half) ** 2, 0.0)))
    return np.asarray(h / h.sum())


def bessel_i0(x: FloatArray) -> FloatArray:
    """Return the modified Bessel function I0, from its series by sums and products, which every
    processor rounds alike.

    Accurate to round-off up to |x| = 30, where the last term is 1e-20 of the sum.
    """
    square = x * x / 4
    term = total = np.ones_like(square)
    for k in range(1, 80):
        term = term * square / (k * k)
        total = total + term
    return np.asarray(total)


def half_band(taps: int, attenuation: float) -> FloatArray:
    """Return a Kaiser low-pass cut off at a quarter of the rate: centre tap 1/2, every second tap
    exactly 0, unit sum.
    """
    h = shifted_lowpass(taps, 0.25, attenuation)
    n = np.arange(taps) - (taps - 1) // 2
    h[n % 2 == 0] = 0.0
    h *= 0.5 / h.sum()
    h[n == 0] = 0.5
    return h


STAGE1_CUTOFF, STAGE1_ATTENUATION = 0.95 / 8, 108.0
STAGE1 = shifted_lowpass(57, STAGE1_CUTOFF, STAGE1_ATTENUATION)
STAGE2 = half_band(143, 110.0)
DELAY = (len(STAGE1) - 1) // 2 / 8 + (len(STAGE2) - 1) // 2 / 2  # output samples
HISTORY1 = (len(STAGE1) - 1) // 8  # columns of 8 inputs that precede a block
HISTORY2 = (len(STAGE2) - 1) // 2  # columns of 2 stage-1 outputs that precede a block


@dataclass(frozen=True, eq=False)
class Taps:
    """A symmetric filter as pairs of taps that share a weight, addressed in the flattened array
    (phases, width) of the inputs.

    left, right: (pairs,) addresses of the two inputs of output 0; those of output n lie n further
    on. weights: (pairs,), in number a multiple of four. centre, centre_weight: the single tap.
    """

    left: IntArray
    right: IntArray
    weights: FloatArray
    centre: int
    centre_weight: float


def taps_in(h: FloatArray, first: int, phases: int, width: int) -> Taps:
    """Return the taps of `h`, addressed in `phases` rows of `width` inputs.

    first: stream position of the oldest input of output 0.
    """
    position = first + np.arange(len(h))
    place = position % phases * width + position // phases
    half = (len(h) - 1) // 2
    # Half of a half-band filter's taps are zero, and are skipped.
    pairs = np.flatnonzero(h[:half])
    return Taps(place[pairs], place[len(h) - 1 - pairs], h[pairs], int(place[half]), float(h[half]))


@lru_cache
def stage_taps(outputs: int) -> tuple[Taps, Taps, Taps]:
    """Return stage 1 for the even and for the odd outputs, and stage 2, for blocks of `outputs`
    samples.
    """
    width1, width2 = HISTORY1 + outputs, HISTORY2 + outputs
    return (
        taps_in(STAGE1, 0, 8, width1),
        taps_in(STAGE1, 4, 8, width1),
        taps_in(STAGE2, 0, 2, width2),
    )


@lru_cache
def _skewed_taps(outputs: int, delay: float) -> tuple[tuple[IntArray, FloatArray], ...]:
    """Return stage 1 for the even and for the odd outputs: addresses and weights of all its taps,
    in multiples of four.
    """
    newest_last = shifted_lowpass(len(STAGE1), STAGE1_CUTOFF, STAGE1_ATTENUATION, delay)[::-1]
    h = np.concatenate([newest_last, np.zeros(3)])
    found = []
    for first in (0, 4):
        position = first + np.arange(len(h))
        position[len(STAGE1) :] = first  # padding of weight 0, at any valid address
        found.append((position % 8 * (HISTORY1 + outputs) + position // 8, h))
    return tuple(found)


class Decimator:
    """Streaming low-pass and decimation by 8 of one channel, in blocks of fixed size; zeros precede
    the stream.

    skew: inputs by which the channel is delayed beyond the common delay, negative where it comes
    early.
    """

    def __init__(self, outputs: int, skew: float = 0.0) -> None:
        self._inputs = np.zeros((8, HISTORY1 + outputs))
        self._halves = np.zeros((2, HISTORY2 + outputs))
        self._taps = tuple(
            (t.left, t.right, t.weights, t.centre, t.centre_weight) for t in stage_taps(outputs)
        )
        self._skewed = _skewed_taps(outputs, skew) if skew else None
        self._out = np.empty(outputs)

    def push(self, x: FloatArray) -> FloatArray:
        """Filter the next (8 outputs,) inputs; output n belongs to input 8 n.

        Always returns the same array.
        """
        if self._skewed is None:
            _decimate(x, self._inputs, self._halves, self._taps, self._out)
        else:
            _decimate_skewed(x, self._inputs, self._halves, self._skewed, self._taps[2], self._out)
        return self._out


@njit(cache=True, nogil=True)
def _decimate(
    x: FloatArray,
    inputs: FloatArray,
    halves: FloatArray,
    taps: tuple[tuple[IntArray, IntArray, FloatArray, int, float], ...],
    out: FloatArray,
) -> None:
    """Filter one block: append the inputs, sorted by phase, to their history; run stage 1 into
    `halves`, stage 2 into `out`.
    """
    n = out.size
    inputs[:, :HISTORY1] = inputs[:, n:]
    halves[:, :HISTORY2] = halves[:, n:]
    even, odd, last = taps
    # Tile by tile through both stages, so that each stage finds its inputs in the cache.
    for start in range(0, n, TILE):
        count = min(TILE, n - start)
        for phase in range(8):
            row = inputs[phase, HISTORY1 + start : HISTORY1 + start + count]
            for i in range(count):
                row[i] = x[8 * (start + i) + phase]
        _convolve(
            inputs.ravel(), even, start, halves[0, HISTORY2 + start : HISTORY2 + start + count]
        )
        _convolve(
            inputs.ravel(), odd, start, halves[1, HISTORY2 + start : HISTORY2 + start + count]
        )
        _convolve(halves.ravel(), last, start, out[start : start + count])


@njit(cache=True, nogil=True)
def _decimate_skewed(
    x: FloatArray,
    inputs: FloatArray,
    halves: FloatArray,
    stage1: tuple[tuple[IntArray, FloatArray], ...],
    stage2: tuple[IntArray, IntArray, FloatArray, int, float],
    out: FloatArray,
) -> None:
    """Filter one block as `_decimate` does, with a stage 1 that is not symmetric."""
    n = out.size
    inputs[:, :HISTORY1] = inputs[:, n:]
    halves[:, :HISTORY2] = halves[:, n:]
    even, odd = stage1
    for start in range(0, n, TILE):
        count = min(TILE, n - start)
        for phase in range(8):
            row = inputs[phase, HISTORY1 + start : HISTORY1 + start + count]
            for i in range(count):
                row[i] = x[8 * (start + i) + phase]
        _convolve_all(
            inputs.ravel(), even, start, halves[0, HISTORY2 + start : HISTORY2 + start + count]
        )
        _convolve_all(
            inputs.ravel(), odd, start, halves[1, HISTORY2 + start : HISTORY2 + start + count]
        )
        _convolve(halves.ravel(), stage2, start, out[start : start + count])


@njit(cache=True, nogil=True)
def _convolve_all(
    source: FloatArray, taps: tuple[IntArray, FloatArray], start: int, out: FloatArray
) -> None:
    """Compute outputs start, start + 1, ... of a filter without symmetry; four taps per pass over
    the outputs.
    """
    place, weights = taps
    n = out.size
    out[:] = 0.0
    for q in range(0, weights.size, 4):
        w0, w1, w2, w3 = weights[q], weights[q + 1], weights[q + 2], weights[q + 3]
        a0 = source[start + place[q] : start + place[q] + n]
        a1 = source[start + place[q + 1] : start + place[q + 1] + n]
        a2 = source[start + place[q + 2] : start + place[q + 2] + n]
        a3 = source[start + place[q + 3] : start + place[q + 3] + n]
        for i in range(n):
            out[i] += (w0 * a0[i] + w1 * a1[i]) + (w2 * a2[i] + w3 * a3[i])


@njit(cache=True, nogil=True)
def _convolve(
    source: FloatArray,
    taps: tuple[IntArray, IntArray, FloatArray, int, float],
    start: int,
    out: FloatArray,
) -> None:
    """Compute outputs start, start + 1, ... of a symmetric filter; four pairs of taps per pass over
    the outputs.
    """
    left, right, weights, centre, centre_weight = taps
    n = out.size
    middle = source[start + centre : start + centre + n]
    for i in range(n):
        out[i] = centre_weight * middle[i]
    for q in range(0, weights.size, 4):
        w0, w1, w2, w3 = weights[q], weights[q + 1], weights[q + 2], weights[q + 3]
        a0 = source[start + left[q] : start + left[q] + n]
        a1 = source[start + left[q + 1] : start + left[q + 1] + n]
        a2 = source[start + left[q + 2] : start + left[q + 2] + n]
        a3 = source[start + left[q + 3] : start + left[q + 3] + n]
        b0 = source[start + right[q] : start + right[q] + n]
        b1 = source[start + right[q + 1] : start + right[q + 1] + n]
        b2 = source[start + right[q + 2] : start + right[q + 2] + n]
        b3 = source[start + right[q + 3] : start + right[q + 3] + n]
        for i in range(n):  # the order of this sum is part of the result: codes must not change
            half = w0 * (a0[i] + b0[i]) + w1 * (a1[i] + b1[i])
            out[i] += half + (w2 * (a2[i] + b2[i]) + w3 * (a3[i] + b3[i]))
