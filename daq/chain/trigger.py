"""A triggered acquisition: the record begins a given number of samples before a channel passes a
level.
"""

from typing import Literal

import numpy as np
import numpy.typing as npt

from daq.chain.acquisition import Acquisition
from daq.chain.block import Block, Flag
from daq.chain.fir import DELAY

__all__ = ["NoTrigger", "Triggered"]

PIECE = 1024  # samples read at a time while waiting
ARMED = 2 * int(DELAY)  # samples until the filter has filled; none of them may trigger
RAILS = np.uint16(Flag.OVERLOAD_HI | Flag.OVERLOAD_LO)

Codes = npt.NDArray[np.int32]


class NoTrigger(Exception):
    """The channel did not pass the level within the allowed number of samples."""


class Triggered:
    """An acquisition whose sample 0 lies `before` samples ahead of the sample that triggered.

    row: channel to watch. level: in codes. slope: rising (values above the level) or falling
    (below). kind: "edge" needs a sample on the other side first, "level" does not. patience:
    samples to wait at most, counted from the arming of the trigger, when the filter has filled and
    `before` samples are available. rails: lowest and highest code.
    """

    def __init__(
        self,
        acquisition: Acquisition,
        row: int,
        level: float,
        slope: Literal["rising", "falling"] = "rising",
        kind: Literal["edge", "level"] = "edge",
        before: int = 0,
        patience: int = 10**6,
        rails: tuple[int, int] = (-(2**23), 2**23 - 1),
    ) -> None:
        if before < 0 or patience < 1:
            raise ValueError(f"{before} samples before a trigger, {patience} to wait for it")
        self._inner, self._row, self._level = acquisition, row, level
        self._sign, self._kind = (1 if slope == "rising" else -1), kind
        self._before, self._patience, self._rails = before, patience, rails
        self._left: Block | None = None
        self._next = 0
        self.first: int | None = None

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel names in row order."""
        return self._inner.channels

    @property
    def rate(self) -> float:
        """Samples per second and channel, Hz."""
        return self._inner.rate

    def read(self, n: int) -> Block:
        """Return the next n samples of every channel; the first call waits for the trigger.

        Sets `first` to the index of sample 0 in the inner acquisition, counted from where that was
        handed over. Raises NoTrigger, and ValueError for n < 1.
        """
        if n < 1:
            raise ValueError(f"{n} samples were asked for")
        if self.first is None:
            self._left, self.first = self._wait()
        parts, have = [], 0
        if self._left is not None:
            parts, have = [self._left], self._left.count
        if have < n:
            parts.append(self._inner.read(n - have))
        whole = parts[0] if len(parts) == 1 else _joined(parts)
        found, self._left = (
            self._cut(whole, 0, n),
            self._cut(whole, n, whole.count) if whole.count > n else None,
        )
        start, self._next = self._next, self._next + n
        return Block(start, found.codes, found.flags, found.clipped, found.settling)

    def _wait(self) -> tuple[Block, int]:
        """Return the samples read so far, from the record's first on, and the index of that first
        sample.
        """
        kept = self._inner.read(PIECE)
        origin, looked = kept.start, max(ARMED, self._before)
        armed = looked
        while True:
            place = self._passed(kept, looked + origin - kept.start)
            if place is not None:
                at = place - self._before
                return self._cut(kept, at, kept.count), kept.start - origin + at
            # All samples up to here are done with, as numbers from the origin; the next piece is
            # searched from there.
            looked = max(looked, kept.start - origin + kept.count)
            if looked - armed > self._patience:
                raise NoTrigger(f"no trigger within {self._patience} samples")
            # One sample more than `before`: an edge may lie between two pieces.
            tail = self._cut(kept, max(kept.count - self._before - 1, 0), kept.count)
            kept = _joined([tail, self._inner.read(PIECE)])

    def _passed(self, block: Block, first: int) -> int | None:
        """Return the index of the first sample from `first` on that triggers; None if none does."""
        if first >= block.count:
            return None
        # The sign turns a falling slope into a rising one, so that one comparison serves both.
        beyond = self._sign * (block.codes[self._row] - self._level) > 0
        hits = beyond.copy()
        if self._kind == "edge":
            # An edge needs the sample before on the other side; before the first sample of a block
            # nothing is known.
            hits[1:] &= ~beyond[:-1]
            hits[0] = False
        found = np.flatnonzero(hits[first:])
        return int(found[0]) + first if found.size else None

    def _cut(self, block: Block, first: int, last: int) -> Block:
        """Return samples first..last of a block, overload counted anew; every other bit is taken
        from the whole block.
        """
        codes = block.codes[:, first:last]
        low, high = (np.count_nonzero(codes == rail, axis=1) for rail in self._rails)
        counted = Flag.OVERLOAD_HI * (high > 0) + Flag.OVERLOAD_LO * (low > 0)
        flags = (block.flags & ~RAILS) | counted.astype(np.uint16)
        return Block(
            block.start + first, codes, flags, (low + high).astype(np.uint32), block.settling
        )


def _joined(blocks: list[Block]) -> Block:
    """Return consecutive blocks as one."""
    codes = np.concatenate([block.codes for block in blocks], axis=1)
    flags = np.bitwise_or.reduce([block.flags for block in blocks])
    clipped = np.sum([block.clipped for block in blocks], axis=0).astype(np.uint32)
    return Block(blocks[0].start, codes, flags, clipped, any(block.settling for block in blocks))
