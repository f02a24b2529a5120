"""Play a recorded run back through the `Acquisition` interface; consumers cannot tell it from
the emulated analyzer.
"""

import numpy as np

from daq.chain.block import Block, Flag
from daq.session.plan import SessionError
from daq.session.record import Record

__all__ = ["Replayed"]

NOT_SETTLED = np.uint16(Flag.NOT_SETTLED)
OVERLOAD = np.uint16(Flag.OVERLOAD_HI | Flag.OVERLOAD_LO)


class Replayed:
    """An acquisition that delivers the recorded codes of one run of a session.

    Reads of the sizes in `sizes` return the recorded blocks, with their quality bits. Any other
    read counts the samples at the rails anew and combines all other bits of the recorded blocks
    that it touches. The caller keeps the record open.
    """

    def __init__(self, record: Record, run: str) -> None:
        self._record = record
        self._info = record.run(run)
        self._rows = record.blocks(run)
        self._starts = self._rows["start"].astype(np.int64)
        self._ends = self._starts + self._rows["count"]
        # In codes: range over volts per code.
        rails = [round(info.range_V / info.scale) for info in record.channels.values()]
        self._rails = np.array(rails, dtype=np.int64)[:, np.newaxis]
        self._next = 0

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel names in row order."""
        return tuple(self._record.channels)

    @property
    def rate(self) -> float:
        """Samples per second and channel, Hz."""
        return self._info.rate

    @property
    def sizes(self) -> tuple[int, ...]:
        """Samples per channel of each recorded block, in order."""
        return tuple(int(count) for count in self._rows["count"])

    def read(self, n: int) -> Block:
        """Return the next n samples of every channel.

        Raises ValueError for n < 1, SessionError past the end of the run.
        """
        if n < 1:
            raise ValueError(f"{n} samples were asked for")
        start, stop = self._next, self._next + n
        if stop > self._info.samples:
            raise SessionError(
                f"{self._info.name} ends at sample {self._info.samples}; {start} to {stop} was asked for"
            )
        codes = self._record.all_codes(self._info.name, start, stop)
        self._next = stop
        touched = self._rows[(self._starts < stop) & (self._ends > start)]
        flags = np.bitwise_or.reduce(touched["flags"], axis=0, initial=np.uint16(0))
        # The recorded counts hold for whole blocks only.
        if start in self._starts and stop in self._ends:
            clipped = touched["clipped"].sum(axis=0, dtype=np.uint32)
        else:
            high = np.count_nonzero(codes >= self._rails - 1, axis=1)
            low = np.count_nonzero(codes <= -self._rails, axis=1)
            clipped = (high + low).astype(np.uint32)
            counted = Flag.OVERLOAD_HI * (high > 0) + Flag.OVERLOAD_LO * (low > 0)
            flags = (flags & ~OVERLOAD) | counted.astype(np.uint16)
        return Block(start, codes, flags, clipped, bool((flags & NOT_SETTLED).any()))
