"""Samples of a run while its replay brings them: the analysis takes each stretch as its blocks come in."""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from daq.chain.block import Block
from daq.session.plan import ChannelSignal
from daq.session.record import Record


class IncomingSignals:
    """The samples of one run, for `analysis.run_energy`: taken from `blocks`, which are pulled as they are needed.

    Stretches are asked for in order, so that only the blocks of the last one are kept. Earlier samples, and those asked
    for again, are read from the record.
    """

    def __init__(self, record: Record, run: str, blocks: Iterator[Block]) -> None:
        self._record = record
        self._run = run
        self._blocks = blocks
        self._kept: list[Block] = []
        self._end = 0
        self._rows = {name: row for row, name in enumerate(record.channels)}

    def signal(self, run: str, name: str, start: int = 0, stop: int | None = None) -> ChannelSignal:
        """Samples start..stop of a channel in engineering units."""
        last = self._record.run(run).samples if stop is None else stop
        self._pull(start, last)
        if run != self._run or not self._kept or start < self._kept[0].start:
            return self._record.signal(run, name, start, stop)
        return self._record.signal_of(run, name, start, self._codes(self._rows[name], start, last))

    def drain(self) -> None:
        """Take the blocks that nothing asked for."""
        self._kept.clear()
        for _ in self._blocks:
            pass

    def _pull(self, start: int, stop: int) -> None:
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
        parts = [
            block.codes[row, max(start - block.start, 0) : stop - block.start]
            for block in self._kept
            if block.start < stop and block.start + block.count > start
        ]
        return parts[0] if len(parts) == 1 else np.concatenate(parts)
