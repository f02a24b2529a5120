"""A record whose samples come from its replay: the analysis takes each stretch as the blocks of it come in."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from daq.chain.block import Block
from daq.chain.channel import ChannelInfo
from daq.session.plan import RunInfo, Signal
from daq.session.record import Record, Truth


class Fed:
    """What `analysis.run_energy` reads of one run, its samples taken from `blocks`, which it pulls as it needs them.

    Stretches are asked for in order, so that only the blocks of the last one are kept; what lies before them, or has a
    second look taken at it, is read from the record.
    """

    def __init__(self, record: Record, run: str, blocks: Iterator[Block]) -> None:
        self._record = record
        self._run = run
        self._blocks = blocks
        self._kept: list[Block] = []
        self._end = 0
        self._rows = {name: row for row, name in enumerate(record.channels)}

    def signal(self, run: str, name: str, start: int = 0, stop: int | None = None) -> Signal:
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

    @property
    def runs(self) -> tuple[RunInfo, ...]:
        """As the record's; so are all that follow."""
        return self._record.runs

    @property
    def conditions(self) -> Mapping[str, Mapping[str, Any]]:
        """Conditions by id."""
        return self._record.conditions

    @property
    def channels(self) -> Mapping[str, ChannelInfo]:
        """The channel table."""
        return self._record.channels

    @property
    def synthetic(self) -> bool:
        """Whether it was simulated."""
        return self._record.synthetic

    @property
    def truth(self) -> Truth | None:
        """What only a simulation can know."""
        return self._record.truth

    def run(self, name: str) -> RunInfo:
        """One run."""
        return self._record.run(name)

    def blocks(self, run: str) -> NDArray[np.void]:
        """The block table of a run."""
        return self._record.blocks(run)

    def document(self, name: str) -> Any:
        """A document of the session."""
        return self._record.document(name)

    def scalars(self, run: str) -> dict[str, float]:
        """The floats that the run ended with."""
        return self._record.scalars(run)
