"""Live monitoring of a campaign while its samples arrive: levels, quality bits, and W of each
complete cycle.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from analysis.energy.live_energy import Online
from analysis.session.record import AnalysisError
from analysis.session.setting import LOOP_BACK, Setting
from daq.chain.block import Block, flag_names
from daq.session.plan import RunInfo
from daq.session.record import Record


@dataclass(frozen=True)
class LiveUpdate:
    """State after a block has been recorded.

    levels : largest magnitude in the block as a fraction of the range, by channel
    ranges : V, by channel
    flags : quality bits in the block, by channel
    W : energies of the cycles completed by the block, J
    cycles, of : cycles read so far, and their total number (0 if a run lacks the channels for
        energies)
    """

    run: str
    condition: str
    samples: int
    planned: int
    levels: dict[str, float]
    ranges: dict[str, float]
    flags: dict[str, tuple[str, ...]]
    W: tuple[float, ...]
    cycles: int
    of: int


class Watcher:
    """Takes a record's blocks, each run's in order, and reports after each. Memory: that of the
    runs in progress.
    """

    def __init__(self, record: Record, tell: Callable[[LiveUpdate], None]) -> None:
        self._record, self._tell = record, tell
        self._channels = tuple(record.channels.values())
        self._online: dict[str, Online | None] = {}

    def hear(self, name: str, block: Block) -> None:
        """Take a recorded block of a run."""
        run = self._record.run(name)
        if block.start == 0:
            self._online[name] = self._reader(run)
        online = self._online.get(name)
        W = () if online is None else tuple(online.hear(block).tolist())
        peaks = np.abs(block.codes.astype(np.int64)).max(axis=1)
        end = block.start + block.count
        self._tell(
            LiveUpdate(
                run=name,
                condition=run.condition,
                samples=end,
                planned=run.planned,
                levels={
                    c.name: float(p) * c.scale / c.range_V
                    for c, p in zip(self._channels, peaks, strict=True)
                },
                ranges={c.name: c.range_V for c in self._channels},
                flags={
                    c.name: flag_names(int(bits))
                    for c, bits in zip(self._channels, block.flags, strict=True)
                },
                W=W,
                cycles=0 if online is None else online.done,
                of=0 if online is None else online.cycles,
            )
        )
        if end >= run.planned:
            self._online.pop(name, None)

    def _reader(self, run: RunInfo) -> Online | None:
        """Return the energy reader of a run; None without force and acceleration, or without a
        whole cycle.
        """
        with suppress(ValueError, AnalysisError):
            setting = Setting.of(self._record.conditions[run.condition])
            if setting.bed == LOOP_BACK:
                return None
            return Online(self._channels, setting, run.rate, run.planned)
        return None
