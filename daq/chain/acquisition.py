"""Acquisition: anything that delivers blocks of codes.

Today it is an emulated analyzer or a replayed record, later a card; the code after it cannot tell
them apart.
"""

from typing import Protocol, runtime_checkable

import numpy as np

from daq.chain.block import Block, Flag
from daq.chain.fir import DELAY, OVERSAMPLING
from daq.chain.frontend import FILTER_DELAY, Codes, FrontEnd
from daq.chain.source import AnalogSource, Clipping

__all__ = ["Acquisition", "Emulated"]

LARGEST_CLOCK_ERROR = 1e-3
"""Largest relative difference of the rates of source and front end: the source runs at the
analyzer's actual rate, the front end states the nominal one, and they differ by the clock's error.
"""


@runtime_checkable
class Acquisition(Protocol):
    """A stream of blocks of codes; the sample index is its only clock."""

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel names in row order."""

    @property
    def rate(self) -> float:
        """Samples per second and channel, Hz."""

    def read(self, n: int) -> Block:
        """Return the next n samples of every channel."""


class Emulated:
    """An analyzer's front end fed by an analog source.

    The source is read in internal blocks of fixed size (up to one block ahead), so that codes do
    not depend on the sizes of the reads. Blocks that start before the filter has filled (2 x 39
    samples) are marked as settling.
    """

    def __init__(self, source: AnalogSource, frontend: FrontEnd) -> None:
        if source.names != frontend.names:
            raise ValueError(
                f"the source has the channels {source.names}, the front end {frontend.names}"
            )
        if abs(source.rate - OVERSAMPLING * frontend.rate) > LARGEST_CLOCK_ERROR * source.rate:
            raise ValueError(
                f"the source runs at {source.rate} Hz, expected {OVERSAMPLING} x {frontend.rate} Hz"
            )
        self._source = source
        # Asked once: isinstance of a Protocol is slow.
        self._clipping = source if isinstance(source, Clipping) else None
        self._frontend = frontend
        self._next = 0
        self._converted = 0  # samples, including those read ahead
        # Per channel: indices, from the next sample on, of samples in whose interval the sensor
        # clipped.
        self._clips = [np.empty(0, dtype=np.intp) for _ in frontend.names]
        self._ahead: Codes = np.empty((len(frontend.names), 0), dtype=np.int32)

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel names in row order."""
        return self._frontend.names

    @property
    def rate(self) -> float:
        """Samples per second and channel, Hz."""
        return self._frontend.rate

    def read(self, n: int) -> Block:
        """Return the next n samples of every channel. Raises ValueError for n < 1.

        Overload bits are set where a code lies at a rail, `sensor_clip` where a sensor reached its
        own limit.
        """
        if n < 1:
            raise ValueError(f"{n} samples were asked for")
        parts, have = [self._ahead], self._ahead.shape[1]
        while have < n:
            parts.append(
                self._frontend.convert(self._source.volts(OVERSAMPLING * self._frontend.block))
            )
            if self._clipping is not None:
                self._note(self._clipping)
            self._converted += self._frontend.block
            have += self._frontend.block
        # The remainder of the last block is kept for the next read.
        codes = np.concatenate(parts, axis=1) if len(parts) > 1 else parts[0]
        self._ahead = codes[:, n:].copy()
        return self._block(codes[:, :n])

    def _note(self, source: Clipping) -> None:
        """Note the samples whose filter is centred on an interval in which a sensor clipped."""
        for row, places in enumerate(source.clipped()):
            if places.size:
                # An interval's effect is centred FILTER_DELAY samples later in the output.
                samples = np.unique(places // OVERSAMPLING) + self._converted + round(FILTER_DELAY)
                self._clips[row] = np.concatenate([self._clips[row], samples])

    def _block(self, codes: Codes) -> Block:
        """Return the next block from `codes` (channels, n), with its flags and counts."""
        start = self._next
        self._next += codes.shape[1]
        sensor = np.array([np.searchsorted(samples, self._next) for samples in self._clips])
        self._clips = [samples[count:] for samples, count in zip(self._clips, sensor, strict=True)]
        # A converter that saturates delivers its extreme codes: that is all an analyzer can see.
        high = np.count_nonzero(codes == self._frontend.highest, axis=1)
        low = np.count_nonzero(codes == self._frontend.lowest, axis=1)
        settling = start < 2 * DELAY
        flags = (
            Flag.OVERLOAD_HI * (high > 0)
            + Flag.OVERLOAD_LO * (low > 0)
            + Flag.NOT_SETTLED * settling
        )
        flags += Flag.SENSOR_CLIP * (sensor > 0)
        return Block(
            start, codes, flags.astype(np.uint16), (high + low + sensor).astype(np.uint32), settling
        )
