"""A channel of a whole run with its poles and its delay corrected, for other tools, in constant
memory.

Inside the window of whole cycles the result equals the signal from which the energies are computed,
except for a constant: there each pole is corrected as in `analysis.signals.correction`, by adding
the integral of the signal over its time constant. Here the integral runs on from the first sample
of the record, by the trapezoidal rule: a harmonic h of N samples per cycle is off by (2 pi h / N)^2
/ 12 of its correction 1 / (h w tau), 2e-5 of it at most for h = 1 and N = 400.
"""

import math
from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

__all__ = ["CorrectedSignal", "SampleReader"]

Array = NDArray[np.float64]

CHUNK = 65536  # samples read at a time
HALF = 32  # taps of the delay filter on either side
KAISER = 10.0  # beta of its window: stop band 100 dB down, flat up to 0.45 of the rate


class SampleReader(Protocol):
    """A function that returns samples start..stop of the channel in engineering units."""

    def __call__(self, start: int, stop: int) -> Array: ...


class CorrectedSignal:
    """The corrected samples of one channel, read in order.

    read : returns the channel's samples
    size : number of samples of the record
    window : first sample of the whole cycles that are analysed, and one past the last; the mean
        over them is removed, since a high pass does not transmit it
    step : s
    time_constants : of the high-pass poles, s
    lag : time by which the channel is late, s
    """

    def __init__(
        self, read: SampleReader, size: int, window: tuple[float, float], step: float,
        time_constants: Sequence[float] = (), lag: float = 0.0,
    ) -> None:  # fmt: skip
        self._read, self.size, self._window, self._step = read, size, window, step
        self._weights = [step / tau for tau in time_constants]
        samples = lag / step
        self._shift = math.floor(samples + 0.5)
        self._taps = _delay_taps(samples - self._shift)
        self._means: list[float] = []
        for _ in self._weights:
            self._means.append(self._mean())

    def chunks(self, length: int = CHUNK) -> Iterator[Array]:
        """Yield the corrected samples in order, at most `length` at a time."""
        poles = list(zip(self._weights, self._means, strict=False))
        state = [(0.0, 0.0)] * len(poles)
        for start in range(0, self.size, length):
            signal = self._on_time(start, min(start + length, self.size))
            for number, (weight, mean) in enumerate(poles):
                signal, state[number] = _without_pole(
                    signal - mean, weight, state[number], start == 0
                )
            yield signal

    def samples(self) -> Array:
        """Return all corrected samples at once."""
        return np.concatenate(list(self.chunks()))

    def _mean(self) -> float:
        """Return the mean over the window of the signal as corrected so far."""
        first, last = self._window
        start, sums = 0, []
        for chunk in self.chunks():
            index = start + np.arange(chunk.size)
            weights = np.clip(index + 1 - first, 0, 1) * np.clip(
                last - index, 0, 1
            )  # the window begins and ends within a sample
            sums.append(float(weights @ chunk))
            start += chunk.size
        return math.fsum(sums) / (last - first)

    def _on_time(self, start: int, stop: int) -> Array:
        """Return samples start..stop of the signal without its delay."""
        if self._taps is None:
            return self._mirrored(start + self._shift, stop + self._shift)
        padded = self._mirrored(start + self._shift - HALF, stop + self._shift + HALF)
        return np.asarray(np.convolve(padded, self._taps, "valid"))

    def _mirrored(self, start: int, stop: int) -> Array:
        """Return samples start..stop; beyond either end the record is reflected about its last
        sample there.
        """
        inside = self._read(min(max(start, 0), self.size - 1), max(min(stop, self.size), 1))
        before, after = max(-start, 0), max(stop - self.size, 0)
        if not before and not after:
            return inside
        reach = max(before, after) + 1
        head, tail = (
            self._read(0, min(reach, self.size)),
            self._read(max(self.size - reach, 0), self.size),
        )
        padded = np.concatenate([
            2 * head[0] - head[before:0:-1], inside, 2 * tail[-1] - tail[-2 : -2 - after : -1],
        ])  # fmt: skip
        return padded[: stop - start]


def _delay_taps(fraction: float) -> Array | None:
    """Return the taps that move a signal a fraction of a sample earlier: a sinc in a Kaiser window;
    None for none.
    """
    if fraction == 0.0:
        return None
    taps = np.sinc(np.arange(-HALF, HALF + 1) + fraction) * np.kaiser(2 * HALF + 1, KAISER)
    return np.asarray(taps / taps.sum())


def _without_pole(
    signal: Array, weight: float, state: tuple[float, float], first: bool
) -> tuple[Array, tuple[float, float]]:
    """Return a chunk plus `weight` times its running integral, and (last sample, integral so far)
    for the next.
    """
    before, total = (signal[0], 0.0) if first else state
    halves = 0.5 * (signal + np.concatenate(([before], signal[:-1])))
    if first:
        halves[0] = 0.0
    integral = total + np.cumsum(halves)
    return signal + weight * integral, (float(signal[-1]), float(integral[-1]))
