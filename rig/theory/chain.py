"""A file of grains struck by a wall: eqs 17 and 20 to 23, first wave and whole collision."""

from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rig.kernels.chain import rebound

Array = NDArray[np.float64]

COLLAPSE = 2.5
"""n (1 - e) from which a row of n grains is taken as plastic: its rebound is below 0.001 there, hits diverge near pi."""


def first_grain_velocity(wall_velocity: float, restitution_wall: float) -> float:
    """Velocity of a resting grain struck by a heavy wall, m/s: (1 + e0) V (eq 22 with V1 = V2 = V)."""
    return (1.0 + restitution_wall) * wall_velocity


def chain_velocities(masses: ArrayLike, restitution: float, first_velocity: float) -> Array:
    """Velocity that each grain of a resting chain receives from its predecessor, m/s, shape (n,) (eqs 20, 21)."""
    m = np.asarray(masses, dtype=np.float64)
    gain = m[:-1] * (1.0 + restitution) / (m[:-1] + m[1:])
    return first_velocity * np.concatenate(([1.0], np.cumprod(gain)))


def first_wave_loss(masses: ArrayLike, restitution: float, first_velocity: float) -> float:
    """Energy lost in the first wave along a resting chain, J (eq 23 over pairs: sum of m_r (1 - e^2) w^2 / 2).

    For n equal grains: m v1^2 (1 + e)/(3 + e) (1 - q^(2(n-1))), q = (1 + e)/2.
    """
    m = np.asarray(masses, dtype=np.float64)
    approach = chain_velocities(m, restitution, first_velocity)[:-1]
    reduced = m[:-1] * m[1:] / (m[:-1] + m[1:])
    return float(np.sum(0.5 * reduced * (1.0 - restitution**2) * approach**2))


def wall_loss(mass: float, restitution_wall: float, wall_velocity: float) -> float:
    """Energy lost between a heavy wall and a resting mass, J, in the wall frame: m (1 - e0^2) V^2 / 2 (eq 23)."""
    return 0.5 * mass * (1.0 - restitution_wall**2) * wall_velocity**2


@lru_cache(maxsize=256)
def row_restitution(grains: int, restitution: float, restitution_wall: float) -> float:
    """Rebound of the centre of mass of a row of equal grains thrown together onto a wall, in [0, 1].

    All hits until separation, event by event, the grains starting at equal (vanishing) gaps. A row whose
    n (1 - e) reaches `COLLAPSE` is plastic: 0.
    """
    if grains <= 1:
        return restitution_wall
    if grains * (1.0 - restitution) >= COLLAPSE * (1.0 - 1e-12):
        return 0.0
    return float(rebound(grains, restitution, restitution_wall))
