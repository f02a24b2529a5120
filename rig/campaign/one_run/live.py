"""Watching a campaign while its samples come in: levels, quality bits, and W of each cycle when it is complete."""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from analysis.energy.online import Online
from analysis.session.record import AnalysisError
from analysis.session.setting import LOOP_BACK, Setting
from daq.chain.block import Block, flag_names
from daq.session.plan import RunInfo
from daq.session.record import Record


@dataclass(frozen=True)
class Look:
    """A block has been recorded. levels: largest magnitude in it over the range, by channel; flags: quality bits in it,
    by channel; W: J, of the cycles that it completes; cycles: read so far, `of` so many (none where a run has not what
    energies need)."""

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
    """Takes a record's blocks, each run's in order, and tells of each. Memory: of the runs that are under way."""

    def __init__(self, record: Record, tell: Callable[[Look], None]) -> None:
        self._record, self._tell = record, tell
        self._channels = tuple(record.channels.values())
        self._online: dict[str, Online | None] = {}

    def hear(self, name: str, block: Block) -> None:
        """A block of a run has been recorded."""
        run = self._record.run(name)
        if block.start == 0:
            self._online[name] = self._reader(run)
        online = self._online.get(name)
        W = () if online is None else tuple(online.hear(block).tolist())
        peaks = np.abs(block.codes.astype(np.int64)).max(axis=1)
        end = block.start + block.count
        self._tell(
            Look(
                run=name,
                condition=run.condition,
                samples=end,
                planned=run.planned,
                levels={c.name: float(p) * c.scale / c.range_V for c, p in zip(self._channels, peaks, strict=True)},
                ranges={c.name: c.range_V for c in self._channels},
                flags={c.name: flag_names(int(bits)) for c, bits in zip(self._channels, block.flags, strict=True)},
                W=W,
                cycles=0 if online is None else online.done,
                of=0 if online is None else online.cycles,
            )
        )
        if end >= run.planned:
            self._online.pop(name, None)

    def _reader(self, run: RunInfo) -> Online | None:
        """What reads a run's energies; None for a run without force and acceleration, or without a whole cycle."""
        with suppress(ValueError, AnalysisError):
            setting = Setting.of(self._record.conditions[run.condition])
            if setting.bed == LOOP_BACK:
                return None
            return Online(self._channels, setting, run.rate, run.planned)
        return None
