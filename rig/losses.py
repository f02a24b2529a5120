"""Losses of the box itself, beside the grains: `noise` (viscous) and `air` (quadratic). Forces act ON the box."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rig.drive.waveform import Waveform

Array = NDArray[np.float64]

QUADRATURE_POINTS = 4096
AIR_DENSITY = 1.204
SOUND_SPEED = 343.0


@dataclass(frozen=True)
class Losses:
    """Coefficients of the loss channels that a scene switches on; 0 where it does not.

    noise : N s/m, force -c v; the viscous equivalent of radiated sound (the paper's "noise")
    air : N s^2/m^2, force -k v |v|
    """

    noise: float = 0.0
    air: float = 0.0


def viscous_energy(coefficient: float, motion: Waveform) -> float:
    """Energy that -c v takes per cycle, J: closed-loop integral of c v^2 dt, exact; pi c w X^2 for a sine."""
    harmonics = np.arange(1, len(motion.sine) + 1)
    power = float(np.sum((np.square(motion.sine) + np.square(motion.cosine)) / harmonics**2))
    return float(0.5 * coefficient * motion.velocity_unit**2 * power / motion.frequency)


def quadratic_energy(coefficient: float, motion: Waveform) -> float:
    """Energy that -k v |v| takes per cycle, J: quadrature of k |v|^3 over the motion; 8/3 k w^2 X^3 for a sine."""
    if coefficient == 0.0:
        return 0.0
    phase = 2.0 * np.pi * (np.arange(QUADRATURE_POINTS) + 0.5) / QUADRATURE_POINTS
    return float(coefficient * np.mean(np.abs(motion.at(phase)[1]) ** 3) / motion.frequency)


def mean_force(losses: Losses, position: Array, velocity: Array, interval: float) -> Array:
    """Mean force of the losses on the box over each interval between edges, N, shape (edges - 1,).

    The viscous part is exact (-c dx/dt); the quadratic part is the trapezoid of v |v|, off by (w h)^2/12 of itself:
    2e-7 at 4096 intervals per cycle.
    """
    force: Array = (-losses.noise / interval) * np.diff(position)
    if losses.air != 0.0:
        pull = velocity * np.abs(velocity)
        force -= (0.5 * losses.air) * (pull[1:] + pull[:-1])
    return force


def drag_of_box(height: float, width: float) -> float:
    """First-principles size of `air`: k = rho C_d A / 2 of a blunt box, N s^2/m^2; C_d = 10 is a ceiling (assumed)."""
    return 0.5 * AIR_DENSITY * 10.0 * height * width


def sound_of_box(height: float, width: float, length: float, omega: float) -> float:
    """First-principles size of `noise`: viscous equivalent of dipole sound, N s/m: (rho V + m_a)^2 w^4/(12 pi rho c^3).

    m_a = 1.19 rho pi/4 of the larger face's side squared per length is the added mass of the air (Koss 1974 form).
    """
    side = max(height, width)
    moved = AIR_DENSITY * (height * width * length + 1.19 * np.pi / 4.0 * side**2 * min(height, width))
    return float(moved**2 * omega**4 / (12.0 * np.pi * AIR_DENSITY * SOUND_SPEED**3))
