"""Physical sources seen through an instrument with a fault that no channel table tells: AC coupling, lag, own clock,
offset. Each takes a source and is one; every other channel passes as it is."""

import math
from collections.abc import Sequence

import numpy as np

from daq.chain.channel import ChannelState
from daq.chain.source import FloatArray, PhysicalSource
from daq.chain.transducer import Transduced

__all__ = ["AcCoupled", "Drifting", "Late", "Offset"]


class AcCoupled:
    """One more high-pass pole in every channel, at `corners` (Hz)."""

    def __init__(self, source: PhysicalSource, corners: Sequence[float]) -> None:
        self.names, self.rate = source.names, source.rate
        self._through = Transduced(source, [ChannelState(1.0, 1 / (2 * math.pi * corner), 1.0) for corner in corners])

    def read(self, n: int) -> FloatArray:
        """Next n interval means, shape (channels, n)."""
        return self._through.volts(n)


class Late:
    """Channel `row` comes `intervals` oversampled intervals late; it reads 0 before."""

    def __init__(self, source: PhysicalSource, row: int, intervals: int) -> None:
        self.names, self.rate = source.names, source.rate
        self._source, self._row = source, row
        self._held = np.zeros(intervals)

    def read(self, n: int) -> FloatArray:
        """Next n interval means, shape (channels, n)."""
        seen = self._source.read(n).copy()
        joined = np.concatenate([self._held, seen[self._row]])
        seen[self._row], self._held = joined[:n], joined[n:]
        return seen


class Drifting:
    """Channel `row` is sampled by a clock of its own that runs fast by `fast` (relative, > 0): sample j shows the time
    j / (1 + fast).

    Linear between intervals: amplitude error (w h)^2 / 8, 3e-7 at 4096 intervals per cycle. It holds what the channel
    has fallen behind: `fast` times all that was read.
    """

    def __init__(self, source: PhysicalSource, row: int, fast: float) -> None:
        self.names, self.rate = source.names, source.rate
        self._source, self._row, self._pace = source, row, 1 / (1 + fast)
        self._held, self._first, self._next = np.zeros(0), 0, 0

    def read(self, n: int) -> FloatArray:
        """Next n interval means, shape (channels, n)."""
        seen = self._source.read(n).copy()
        joined = np.concatenate([self._held, seen[self._row]])
        position = np.arange(self._next, self._next + n) * self._pace
        seen[self._row] = np.interp(position - self._first, np.arange(joined.size), joined)
        self._next += n
        keep = math.floor(self._next * self._pace) - self._first
        self._held, self._first = joined[keep:], self._first + keep
        return seen


class Offset:
    """A constant, in the channel's unit, is added to channel `row`."""

    def __init__(self, source: PhysicalSource, row: int, amount: float) -> None:
        self.names, self.rate = source.names, source.rate
        self._source, self._row, self._amount = source, row, amount

    def read(self, n: int) -> FloatArray:
        """Next n interval means, shape (channels, n)."""
        seen = self._source.read(n).copy()
        seen[self._row] += self._amount
        return seen
