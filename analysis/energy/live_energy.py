"""W of each cycle while a run is still being recorded: the analysis itself, block by block."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.energy.per_cycle import window_energy
from analysis.session.setting import Setting
from analysis.signals.cycles import Window, on_grid, whole_cycles
from daq.chain.block import Block
from daq.chain.channel import ChannelInfo

__all__ = ["Online"]

Array = NDArray[np.float64]


class Online:
    """A live reading of a run: takes its blocks in order and returns W of every completed cycle, in
    constant memory.

    Window, corrections and loop integral are those of run_energy. But poles are corrected over the
    cycles that one block completes, instead of 64 at a time: the mean that is removed first
    differs, and W of a cycle by about 1/(w tau) of the scatter between cycles. ValueError where no
    whole cycle fits into the planned samples, and for a sweep.
    """

    def __init__(
        self,
        channels: Sequence[ChannelInfo],
        setting: Setting,
        rate: float,
        samples: int,
        phase: float = 0.0,
    ) -> None:
        """Prepare to read a run of `samples` samples at `rate` (Hz); phase: samples from its first
        one to the start of a drive cycle.
        """
        if setting.sweep_to is not None:
            raise ValueError("a sweep has no cycles that close")
        names = [channel.name for channel in channels]
        self._rows = [names.index(name) for name in ("force", "acceleration")]
        self._channels = [channels[row] for row in self._rows]
        force, acceleration = self._channels
        self._window = whole_cycles(
            samples,
            rate,
            setting.frequency,
            filter_delay=force.filter_delay + phase,
            settle=setting.settle_cycles,
            cycles=int(setting.record_cycles),
        )
        self._frequency = setting.frequency
        self._delay = (
            (acceleration.filter_delay - force.filter_delay) / rate + force.skew - acceleration.skew
        )
        self._done = 0
        self._first = 0
        self._kept: Array = np.empty((2, 0))

    @property
    def cycles(self) -> int:
        """Number of cycles of the window."""
        return self._window.cycles

    @property
    def done(self) -> int:
        """Number of cycles read so far."""
        return self._done

    def hear(self, block: Block) -> Array:
        """Return W (J) of the cycles that this block completes; empty while the run settles."""
        units = [
            (block.codes[row] * channel.scale + channel.offset) / channel.sensitivity
            for row, channel in zip(self._rows, self._channels, strict=True)
        ]
        self._kept = np.concatenate([self._kept, units], axis=1)
        end, period = self._first + self._kept.shape[1], self._window.grid.period
        left = self._window.cycles - self._done
        ready = min(left, max(math.floor((end - self._window.start) / period) - self._done, 0))
        while ready and self._next(ready).sample_range()[1] > end:
            ready -= 1
        found = np.empty(0)
        if ready:
            part = self._next(ready)
            force, acceleration = (
                np.ascontiguousarray(row) for row in on_grid(self._kept, self._first, part)
            )
            poles = (self._channels[0].time_constants, self._channels[1].time_constants)
            found = window_energy(
                force, acceleration, ready, self._frequency, time_constants=poles, delay=self._delay
            ).W_cycles
            self._done += ready
        # Samples before the next cycle's interpolation points are not needed any more.
        needed = self._next(1).sample_range()[0] if self._done < self._window.cycles else end
        drop = min(max(needed - self._first, 0), self._kept.shape[1])
        self._kept, self._first = self._kept[:, drop:].copy(), self._first + drop
        return found

    def _next(self, cycles: int) -> Window:
        """Return the next cycles of the window."""
        window = self._window
        return Window(window.grid, window.start + self._done * window.grid.period, cycles)
