"""The energy ledger of a run: the energy supplied by the exciter, cycle by cycle, and its uses."""

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
"""Joules per cycle, except `closure`: the residual of the energy balance, as a fraction of
max(|W_gauge|, pi M V^2).
"""

LOST_IN_EXCITER = ("W_copper", "W_flexure", "W_stinger", "W_isolation")
OF_EXCITER = ("W_electric", *LOST_IN_EXCITER, "W_coil", "dE_exciter", "closure_exciter")
"""Columns of shaker-coupled drive, joules per cycle.

W_electric is the electrical energy from the amplifier, with the balance W_electric = W_copper +
W_flexure + W_stinger + W_isolation + dE_exciter + W_gauge. `closure_exciter` is its residual, as a
fraction of the larger of the scale of `closure` and |W_electric|. W_coil is the work of BL i on the
motion of the coil relative to the body; W_gauge is the work of the stinger on the box, at whichever
end the gauge sits.
"""

COUPLED_COLUMNS = (*COLUMNS, *OF_EXCITER)

CLOSES = 1e-9
"""Largest residual (closure) of a balanced account in prescribed motion."""


def account(reaction: Reaction, kinetic_before: float, lost: Array, inertial: float) -> Array:
    """Return ledger rows (`COLUMNS`) for the cycles of a reaction, shape (cycles, columns).

    reaction : of the bed; kinetic_before : energy of the bed before its first cycle, J
    lost : energy per cycle in the channels `LOST`, J
    inertial : pi M V^2, the scale of the energy that is exchanged back and forth, J

    W_gauge is the work through the gauge plane: the kinetic energy of the box (unchanged over whole
    cycles of a prescribed motion), the work at the contacts with the bed, and the losses `LOST`.
    dKE_bed is the change of the bed's energy, including potential energy where it has weight along
    the axis. The balance is W_gauge = dKE_box + dKE_bed + W_f + W_c + W_viscous + W_noise + W_air +
    W_gas + W_mount.
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
    rows[:, -1] = (gauge - spent) / np.maximum(
        np.maximum(np.abs(gauge), inertial), sys.float_info.min
    )
    return rows
