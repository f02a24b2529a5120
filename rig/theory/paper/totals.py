"""Totals: eqs 23 to 25."""

import numpy as np
from numpy.typing import ArrayLike


def collision_energy(losses: ArrayLike) -> float:
    """Return W_c, J: the sum of the losses of every *pair*, wall hits in the wall frame (eq 23
    corrected).

    Erratum: printed as the sum over grains of their own drop of kinetic energy, which counts a
    transfer as a loss.
    """
    return float(np.sum(np.asarray(losses, dtype=np.float64)))


def total_energy(friction: float, collision: float) -> float:
    """Return W_T = W_f + W_c, J (eq 24).

    Here friction *during* hits is part of W_c, and sliding between hits of W_f; the paper does not
    say.
    """
    return friction + collision


def measured_energy(excitation: float, kinetic: float) -> float:
    """Return W_exp = W_exc - W_kin, J (eq 25).

    excitation : work of the gauge force on the box over the window
    kinetic : change of the box's kinetic energy over the same window, 0 over whole cycles of a
        steady motion. Neither contains the change of the bed's own energy, so only whole cycles of
        a periodic bed give its dissipation
    """
    return excitation - kinetic
