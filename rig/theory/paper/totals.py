"""Totals: eqs 23 to 25."""

import numpy as np
from numpy.typing import ArrayLike


def collision_energy(losses: ArrayLike) -> float:
    """W_c, J: the sum of what every *pair* lost, wall hits in the wall's frame (eq 23 corrected).

    Erratum: printed as the sum over grains of their own drop of kinetic energy, which calls a transfer a loss.
    """
    return float(np.sum(np.asarray(losses, dtype=np.float64)))


def total_energy(friction: float, collision: float) -> float:
    """W_T = W_f + W_c, J (eq 24).

    Friction *inside* hits is part of W_c here and sliding between hits of W_f; the paper leaves open which owns what.
    """
    return friction + collision


def measured_energy(excitation: float, kinetic: float) -> float:
    """W_exp = W_exc - W_kin, J (eq 25).

    excitation : work of the gauge force on the box over the window
    kinetic : change of the box's kinetic energy over the same window, 0 over whole cycles of a steady motion; the bed's
        own change is in neither, so that only whole cycles of a periodic bed give its dissipation
    """
    return excitation - kinetic
