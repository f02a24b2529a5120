"""The oversampled grid laid over the motion: edges of the intervals over which force and acceleration are averaged."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rig.drive.waveform import Waveform

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Edges:
    """Box position (m) and velocity (m/s) at the sampling edges of some whole cycles, and at the edge before them.

    Both of shape (1 + edges,): entry k + 1 ends the interval that entry k begins.
    """

    position: Array
    velocity: Array


@dataclass
class Sampling:
    """A waveform seen at sampling edges j = 0, 1, ..: edge j lies j / edges_per_cycle cycles after the start.

    Cycle n owns the edges in [n, n + 1) cycles. Where a cycle holds a whole number of edges, every stretch of the
    same length is the same: one object, computed once.
    """

    motion: Waveform
    edges_per_cycle: float
    _kept: dict[int, Edges] = field(default_factory=dict, init=False, repr=False)

    def first_edge(self, cycle: int) -> int:
        """Number of the first edge that belongs to a cycle."""
        return int(np.ceil(cycle * self.edges_per_cycle))

    def edges(self, first_cycle: int, cycles: int) -> Edges:
        """The motion at the edges of `cycles` cycles from `first_cycle` on."""
        if float(self.edges_per_cycle).is_integer():
            if cycles not in self._kept:
                self._kept = {cycles: self._repeated(cycles)}
            return self._kept[cycles]
        edge = np.arange(self.first_edge(first_cycle) - 1, self.first_edge(first_cycle + cycles))
        turns = edge / self.edges_per_cycle
        return Edges(*self.motion.at(2.0 * np.pi * (turns - np.floor(turns))))

    def _repeated(self, cycles: int) -> Edges:
        one = int(self.edges_per_cycle)
        position, velocity = self.motion.at(2.0 * np.pi * np.arange(one) / one)
        return Edges(*(np.concatenate((x[-1:], np.tile(x, cycles))) for x in (position, velocity)))
