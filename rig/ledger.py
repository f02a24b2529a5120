"""The energy account of a run: what the exciter gave, cycle by cycle, and where it went."""

import numpy as np
from numpy.typing import NDArray

from rig.beds.bed import Reaction
from rig.losses import LOST

Array = NDArray[np.float64]

IN_BED = ("W_f", "W_c", "W_viscous")
SPENT = (*IN_BED, *LOST, "dKE_bed", "dKE_box")
COLUMNS = (*SPENT, "W_gauge", "closure")
"""Joules per cycle, except `closure`: what is left over, as a share of max(|W_gauge|, pi M V^2)."""

CLOSES = 1e-9
"""Largest closure of an account that closes, servo drive."""


def account(reaction: Reaction, kinetic_before: float, lost: Array, inertial: float) -> Array:
    """Rows of `COLUMNS` for the cycles of a reaction, shape (cycles, columns).

    W_gauge is the work through the gauge plane: the box's kinetic energy (unchanged over whole cycles of a programmed
    motion), the work at the contacts with the bed, and the losses of the channels `LOST` (J per cycle). Its balance is
    W_gauge = dKE_box + dKE_bed + W_f + W_c + W_viscous + W_noise + W_air + W_gas + W_mount. `inertial` is pi M V^2, the
    scale of the energy that goes back and forth.
    """
    rows = np.zeros((reaction.work.size, len(COLUMNS)))
    gauge = reaction.work + float(lost.sum())
    rows[:, 0] = reaction.friction
    rows[:, 1] = reaction.collision
    rows[:, 2] = reaction.viscous
    rows[:, len(IN_BED) : len(IN_BED) + len(LOST)] = lost
    rows[:, SPENT.index("dKE_bed")] = np.diff(reaction.kinetic, prepend=kinetic_before)
    rows[:, len(SPENT)] = gauge
    spent = rows[:, : len(SPENT)].sum(axis=1)
    rows[:, -1] = (gauge - spent) / np.maximum(np.maximum(np.abs(gauge), inertial), np.finfo(float).tiny)
    return rows
