"""Losses beside the grains' own: noise, air, gas, mount. Forces act ON the box, energies are J per cycle.

`noise` is a viscous loss, -c v, `air` a quadratic one, -k v |v|. The names are the paper's words for its offset and no
explanation: the shipped coefficients are 317 000 and 12 000 times what sound and drag of the box take
(`over_first_principles`). `gas` is the viscous equivalent of drag inside the bed (rig/stand/gas.py); `mount` is what
carries the box: guides, Coulomb friction -f sign(v), or cords, structural damping, in every harmonic -eta k v_h/(h w),
whose energy pi eta k X^2 does not know the frequency. The stiffness of the cords is left out: it takes no energy.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rig.drive.waveform import Waveform, harmonic_sum, viscous_energy
from rig.protocol.spec import Cavity

Array = NDArray[np.float64]

QUADRATURE_POINTS = 4096
AIR_DENSITY = 1.204
AIR_VISCOSITY = 1.81e-5
SOUND_SPEED = 343.0
"""Air at 20 degrees and 101 kPa: kg/m^3, Pa s, m/s."""

LOST = ("W_noise", "W_air", "W_gas", "W_mount")
"""Ledger columns of the loss channels, in the order of `Losses.energies`."""


@dataclass(frozen=True)
class Losses:
    """Coefficients of the loss channels that a scene switches on; 0 where it does not.

    noise : N s/m, force -c v; a viscous loss (the paper's "noise")
    air : N s^2/m^2, force -k v |v|; a quadratic loss (the paper's "air")
    gas : N s/m, force -c v; the viscous equivalent of the gas drag inside the bed
    guide : N, force -f sign(v), f = mu M g of the moving weight
    cords : N/m, eta k of the cords
    """

    noise: float = 0.0
    air: float = 0.0
    gas: float = 0.0
    guide: float = 0.0
    cords: float = 0.0

    def energies(self, motion: Waveform) -> Array:
        """Energy that each channel of `LOST` takes per cycle, J."""
        return np.array(
            [
                viscous_energy(self.noise, motion),
                quadratic_energy(self.air, motion),
                viscous_energy(self.gas, motion),
                friction_energy(self.guide, motion) + structural_energy(self.cords, motion),
            ]
        )


def quadratic_energy(coefficient: float, motion: Waveform) -> float:
    """Energy that -k v |v| takes per cycle, J: quadrature of k |v|^3 over the motion; 8/3 k w^2 X^3 for a sine."""
    if coefficient == 0.0:
        return 0.0
    phase = 2.0 * np.pi * (np.arange(QUADRATURE_POINTS) + 0.5) / QUADRATURE_POINTS
    return float(coefficient * np.mean(np.abs(motion.at(phase)[1]) ** 3) / motion.frequency)


def friction_energy(force: float, motion: Waveform) -> float:
    """Energy that -f sign(v) takes per cycle, J: f times the way that the box goes; 4 f X for a sine."""
    return 0.0 if force == 0.0 else force * way(motion)


def structural_energy(coefficient: float, motion: Waveform) -> float:
    """Energy that structural damping takes per cycle, J, exact: pi eta k X_h^2 in each cycle of harmonic h."""
    return float(np.pi * coefficient * motion.length_unit**2 * harmonic_sum(motion, 3))


def way(motion: Waveform) -> float:
    """Way that the box goes in one cycle, m: positions at the turning points, added up; 4 X for a sine.

    Turning points are found between samples, by a secant: the position there is flat, an error of 1e-7 rad is one of
    1e-14 of X.
    """
    phase = 2.0 * np.pi * (np.arange(QUADRATURE_POINTS + 1) + 0.5) / QUADRATURE_POINTS
    velocity = motion.at(phase)[1]
    before = np.flatnonzero((velocity[:-1] >= 0.0) != (velocity[1:] >= 0.0))
    share = velocity[before] / (velocity[before] - velocity[before + 1])
    turning = motion.at(phase[before] + share * (phase[1] - phase[0]))[0]
    return float(np.abs(np.diff(turning, append=turning[:1])).sum())


def by_order(motion: Waveform) -> Waveform:
    """The motion, each harmonic divided by its order: structural damping pulls with -(eta k/w) times its velocity."""
    orders = range(1, len(motion.sine) + 1)
    return replace(
        motion,
        sine=tuple(p / h for p, h in zip(motion.sine, orders, strict=True)),
        cosine=tuple(q / h for q, h in zip(motion.cosine, orders, strict=True)),
    )


def mean_force(losses: Losses, position: Array, velocity: Array, interval: float) -> Array:
    """Mean force of all channels but the cords over each interval between edges, N, shape (edges - 1,).

    The viscous part is exact (-c dx/dt); the quadratic part is the trapezoid of v |v|, off by (w h)^2/12 of itself:
    2e-7 at 4096 intervals per cycle; the friction part is exact up to the secant that finds a turning point inside an
    interval.
    """
    force: Array = (-(losses.noise + losses.gas) / interval) * np.diff(position)
    if losses.air != 0.0:
        pull = velocity * np.abs(velocity)
        force -= (0.5 * losses.air) * (pull[1:] + pull[:-1])
    if losses.guide != 0.0:
        force -= losses.guide * mean_sign(velocity)
    return force


def mean_sign(velocity: Array) -> Array:
    """Mean of sign(v) over each interval between edges, for a velocity that is straight in between; 0 at rest."""
    speed = np.abs(velocity)
    both = speed[1:] + speed[:-1]
    mean = np.zeros_like(both)
    np.divide(velocity[1:] + velocity[:-1], both, out=mean, where=both > 0.0)
    return mean


def mean_cord_force(coefficient: float, omega: float, position: Array, interval: float) -> Array:
    """Mean force of the cords over each interval between edges, N, exact; `position` (m) is that of `by_order`."""
    force: Array = (-coefficient / (omega * interval)) * np.diff(position)
    return force


def guide_force(friction: float, mass: float, gravity: float) -> float:
    """Friction of a guide under the moving weight, N: mu M g."""
    return friction * mass * gravity


def cord_coefficient(loss_factor: float, frequency: float, mass: float) -> float:
    """eta k of cords on which a mass (kg) swings at a frequency (Hz), N/m."""
    return float(loss_factor * mass * (2.0 * np.pi * frequency) ** 2)


def over_first_principles(noise: float, air: float, cavity: Cavity, frequency: float) -> dict[str, float]:
    """Coefficients of `noise` and `air` over what sound and drag of the closed box are by first principles, by loss."""
    height, width, length = (side + 2.0 * cavity.wall for side in (cavity.height, cavity.width, cavity.length))
    sound = sound_of_box(height, width, length, 2.0 * np.pi * frequency)
    return {"noise": noise / sound, "air": air / drag_of_box(height, width)}


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
