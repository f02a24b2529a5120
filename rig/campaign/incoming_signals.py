"""Samples of a run during replay: the analysis consumes each stretch as its blocks arrive."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from daq.chain.block import Block
from daq.session.plan import ChannelSignal
from daq.session.record import Record


class IncomingSignals:
    """The samples of one run for `analysis.run_energy`, from `blocks`, which are pulled on demand.

    Sequential reads are served from the live blocks; only the current window is buffered. Earlier
    or repeated reads fall back to the file.
    """

    def __init__(self, record: Record, run: str, blocks: Iterator[Block]) -> None:
        self._record = record
        self._run = run
        self._blocks = blocks
        self._kept: list[Block] = []
        self._end = 0
        self._rows = {name: row for row, name in enumerate(record.channels)}

    def signal(self, run: str, name: str, start: int = 0, stop: int | None = None) -> ChannelSignal:
        """Return samples start..stop of a channel in engineering units."""
        last = self._record.run(run).samples if stop is None else stop
        self._pull(start, last)
        if run != self._run or not self._kept or start < self._kept[0].start:
            return self._record.signal(run, name, start, stop)
        return self._record.signal_of(run, name, start, self._codes(self._rows[name], start, last))

    def drain(self) -> None:
        """Consume the blocks that were not read."""
        self._kept.clear()
        for _ in self._blocks:
            pass

    def _pull(self, start: int, stop: int) -> None:
        # Only a read that moves forward may drop blocks; an earlier one is served from the file.
        if start >= self._end or (self._kept and self._kept[0].start <= start):
            self._kept = [block for block in self._kept if block.start + block.count > start]
        while self._end < stop:
            block = next(self._blocks, None)
            if block is None:
                return
            self._end = block.start + block.count
            if self._end > start:
                self._kept.append(block)

    def _codes(self, row: int, start: int, stop: int) -> NDArray[np.int32]:
        parts = []
        for block in self._kept:
            if block.start < stop and block.start + block.count > start:
                parts.append(block.codes[row, max(start - block.start, 0) : stop - block.start])
        return parts[0] if len(parts) == 1 else np.concatenate(parts)
