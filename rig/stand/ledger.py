"""The energy account of a run: what the exciter gave, cycle by cycle, and where it went."""

import sys

import numpy as np
from numpy.typing import NDArray

from rig.beds.bed import Reaction
from rig.drive.losses import LOST

Array = NDArray[np.float64]

IN_BED = ("W_f", "W_c", "W_viscous")
SPENT = (*IN_BED, *LOST, "dKE_bed", "dKE_box")
CHANGE = SPENT.index("dKE_bed")
COLUMNS = (*SPENT, "W_gauge", "closure")
"""Joules per cycle, except `closure`: what is left over, as a share of max(|W_gauge|, pi M V^2)."""

LOST_IN_EXCITER = ("W_copper", "W_flexure", "W_stinger", "W_isolation")
OF_EXCITER = ("W_electric", *LOST_IN_EXCITER, "W_coil", "dE_exciter", "closure_exciter")
"""Coupled drive, joules per cycle: W_electric is what the amplifier gives, its balance W_electric = W_copper +
W_flexure + W_stinger + W_isolation + dE_exciter + W_gauge, and `closure_exciter` what is left over, as a share of the
larger of the scale of `closure` and |W_electric|. W_coil is BL i times the velocity of the coil in the body, W_gauge
the work of the stinger on the box, whichever end the gauge sits at."""

COUPLED_COLUMNS = (*COLUMNS, *OF_EXCITER)

CLOSES = 1e-9
"""Largest closure of an account that closes, servo drive."""


def account(reaction: Reaction, kinetic_before: float, lost: Array, inertial: float) -> Array:
    """Rows of `COLUMNS` for the cycles of a reaction, shape (cycles, columns).

    W_gauge is the work through the gauge plane: the box's kinetic energy (unchanged over whole cycles of a programmed
    motion), the work at the contacts with the bed, and the losses of the channels `LOST` (J per cycle). dKE_bed is the
    change of the bed's energy, potential included where it has weight along the axis. The balance is
    W_gauge = dKE_box + dKE_bed + W_f + W_c + W_viscous + W_noise + W_air + W_gas + W_mount. `inertial` is pi M V^2, the
    scale of the energy that goes back and forth.
    """
    rows = np.zeros((reaction.work.size, len(COLUMNS)))
    gauge = reaction.work + float(lost.sum())
    rows[:, 0] = reaction.friction
    rows[:, 1] = reaction.collision
    rows[:, 2] = reaction.viscous
    rows[:, len(IN_BED) : len(IN_BED) + len(LOST)] = lost
    change = rows[:, CHANGE]
    change[0] = reaction.kinetic[0] - kinetic_before
    change[1:] = reaction.kinetic[1:] - reaction.kinetic[:-1]
    rows[:, len(SPENT)] = gauge
    spent = rows[:, : len(SPENT)].sum(axis=1)
    rows[:, -1] = (gauge - spent) / np.maximum(np.maximum(np.abs(gauge), inertial), sys.float_info.min)
    return rows
