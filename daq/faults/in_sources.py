"""Physical sources measured by an instrument with a fault that its channel table does not show.

AC coupling, delay, a clock of its own, offset. Each takes a source and is one; all other channels
pass unchanged.
"""

import math
from collections.abc import Sequence

import numpy as np

from daq.chain.channel import ChannelState
from daq.chain.source import FloatArray, PhysicalSource
from daq.chain.transducer import Transduced

__all__ = ["AcCoupled", "Drifting", "Late", "Offset"]


class AcCoupled:
    """An additional high-pass pole in every channel, at `corners` (Hz)."""

    def __init__(self, source: PhysicalSource, corners: Sequence[float]) -> None:
        self.names, self.rate = source.names, source.rate
        self._through = Transduced(
            source, [ChannelState(1.0, 1 / (2 * math.pi * corner), 1.0) for corner in corners]
        )

    def read(self, n: int) -> FloatArray:
        """Return the next n interval means, shape (channels, n)."""
        return self._through.volts(n)


class Late:
    """Delays channel `row` by `intervals` oversampled intervals; it reads 0 before."""

    def __init__(self, source: PhysicalSource, row: int, intervals: int) -> None:
        self.names, self.rate = source.names, source.rate
        self._source, self._row = source, row
        self._held = np.zeros(intervals)

    def read(self, n: int) -> FloatArray:
        """Return the next n interval means, shape (channels, n)."""
        seen = self._source.read(n).copy()
        joined = np.concatenate([self._held, seen[self._row]])
        seen[self._row], self._held = joined[:n], joined[n:]
        return seen


class Drifting:
    """Samples channel `row` by a clock of its own that runs fast by `fast` (relative, > 0): sample
    j shows time j / (1 + fast).

    Linear interpolation between intervals: amplitude error (w h)^2 / 8 (h: interval), 3e-7 at 4096
    intervals per cycle. Keeps the samples by which the channel has fallen behind: `fast` times the
    number read.
    """

    def __init__(self, source: PhysicalSource, row: int, fast: float) -> None:
        self.names, self.rate = source.names, source.rate
        self._source, self._row, self._pace = source, row, 1 / (1 + fast)
        self._held, self._first, self._next = np.zeros(0), 0, 0

    def read(self, n: int) -> FloatArray:
        """Return the next n interval means, shape (channels, n)."""
        seen = self._source.read(n).copy()
        joined = np.concatenate([self._held, seen[self._row]])
        position = np.arange(self._next, self._next + n) * self._pace
        seen[self._row] = np.interp(position - self._first, np.arange(joined.size), joined)
        self._next += n
        keep = math.floor(self._next * self._pace) - self._first
        self._held, self._first = joined[keep:], self._first + keep
        return seen


class Offset:
    """Adds a constant, in the channel's unit, to channel `row`."""

    def __init__(self, source: PhysicalSource, row: int, amount: float) -> None:
        self.names, self.rate = source.names, source.rate
        self._source, self._row, self._amount = source, row, amount

    def read(self, n: int) -> FloatArray:
        """Return the next n interval means, shape (channels, n)."""
        seen = self._source.read(n).copy()
        seen[self._row] += self._amount
        return seen
