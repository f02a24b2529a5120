"""Pilot run of a bed without a stand: its steady energy row by row, and the work of the box in each
cycle.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rig.beds.janssen_stack import Filling, stack
from rig.beds.layers import cannot_follow
from rig.catalog.entries import Rig
from rig.drive.waveform import Waveform
from rig.kernels.rows.many_rows import HISTORY
from rig.kernels.rows.one_row import MAX_EVENTS
from rig.kernels.rows.transient import transient
from rig.protocol.spec import Drive, Scene
from rig.theory.total import sliding_rows

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pilot:
    """A bed from rest on an exact sine at the set acceleration.

    energy : steady energy per cycle of each sliding row, J, shape (layers, rows); of a bed without
        rows (1, 1)
    work : of the box on the bed in each cycle, J, shape (cycles,)
    layers, flowing : number of layers in total, and of those that slide
    repeating : fraction of the energy in periodic rows
    averaging : error of the energy of rows without a period, as a fraction of the total
        (`_averaging`)
    simulated : number of row cycles simulated
    """

    energy: Array
    work: Array
    layers: int
    flowing: int
    repeating: float
    averaging: float
    simulated: int

    @property
    def W(self) -> float:
        """Steady energy per cycle, J."""
        return float(self.energy.sum())


PilotRun = Callable[[int], Pilot]
"""A pilot run: number of cycles -> the bed over its first cycles."""


def rows_pilot(scene: Scene, rig: Rig, drive: Drive, filling: Filling, cycles: int) -> Pilot:
    """Run a pilot of bed `layers`: every row until it is periodic. Raises InputError if a row has
    too many events.
    """
    bed = stack(scene, rig, filling)
    rows = sliding_rows(
        bed.threshold, bed.clearance, bed.restitution, drive.acceleration, drive.frequency
    )
    found = transient(rows, np.ones(1), np.zeros(1), cycles)
    if (found.period < 0).any():
        raise cannot_follow(bed, f"meets more than {MAX_EVENTS} events in one cycle")
    unit = bed.row_mass * Waveform(drive.frequency, drive.acceleration).velocity_unit ** 2
    taken = float(found.energy.sum())
    return Pilot(
        energy=unit * found.energy.reshape(-1, scene.layers.rows),
        work=unit * found.work,
        layers=bed.threshold.size
        + round(bed.carried_mass / (bed.row_mass * scene.layers.rows) if bed.row_mass else 0),
        flowing=rows.band.size,
        repeating=float(found.energy[found.period > 0].sum()) / taken if taken > 0.0 else 1.0,
        averaging=_averaging(found.loose[HISTORY:]) / taken if taken > 0.0 else 0.0,
        simulated=found.simulated,
    )


def _averaging(loose: Array) -> float:
    """Return the error of the mean of a series: half the range of the means over its quarters, or
    the difference between its halves if that is larger.

    This is about twice the standard error of four independent means, and covers rows that settle
    late.
    """
    quarters = np.array([part.mean() for part in np.array_split(loose, 4)])
    halves = np.array([part.mean() for part in np.array_split(loose, 2)])
    return float(max(0.5 * np.ptp(quarters), np.ptp(halves)))
