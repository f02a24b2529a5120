"""Losses other than those of the grains: noise, air, gas, mount. Forces act ON the box; energies
are J per cycle.

`noise` is a viscous loss, -c v, `air` a quadratic one, -k v |v|. In the rig `clean` they are sound
radiation and drag of the box by first principles. In the rig `paper` the names are the paper's
terms for its offset and not an explanation: its coefficients are 317 000 and 12 000 times those
values (`over_first_principles`). `gas` is the viscous
equivalent of the drag inside the bed (rig/stand/gas.py). `mount` is the support of the box. Guides
have Coulomb friction -f sign(v); cords have structural damping, in every harmonic -eta k v_h/(h w),
whose energy pi eta k X^2 is independent of frequency. The stiffness of the cords is omitted because
it dissipates nothing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rig.catalog.entries import Rig
from rig.drive.waveform import Waveform, harmonic_sum, viscous_energy
from rig.protocol.spec import Cavity

Array = NDArray[np.float64]

QUADRATURE_POINTS = 4096
AIR_DENSITY = 1.204
AIR_VISCOSITY = 1.81e-5
SOUND_SPEED = 343.0
"""Properties of air at 20 degrees Celsius and 101 kPa: kg/m^3, Pa s, m/s."""

LOST = ("W_noise", "W_air", "W_gas", "W_mount")
"""Ledger columns of the loss channels, in the order of `Losses.energies`."""


@dataclass(frozen=True)
class Losses:
    """Coefficients of the loss channels that a scene switches on; 0 for those that it does not.

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
        """Return the energy dissipated per cycle in each channel of `LOST`, J."""
        return np.array(
            [
                viscous_energy(self.noise, motion),
                quadratic_energy(self.air, motion),
                viscous_energy(self.gas, motion),
                friction_energy(self.guide, motion) + structural_energy(self.cords, motion),
            ]
        )


def quadratic_energy(coefficient: float, motion: Waveform) -> float:
    """Return the energy dissipated per cycle by -k v |v|, J: 8/3 k w^2 X^3 for a sine.

    Midpoint quadrature of k |v|^3 over the motion.
    """
    if coefficient == 0.0:
        return 0.0
    phase = 2.0 * np.pi * (np.arange(QUADRATURE_POINTS) + 0.5) / QUADRATURE_POINTS
    return float(coefficient * np.mean(np.abs(motion.at(phase)[1]) ** 3) / motion.frequency)


def friction_energy(force: float, motion: Waveform) -> float:
    """Return the energy dissipated per cycle by -f sign(v), J: f times the path length; 4 f X for a
    sine.
    """
    return 0.0 if force == 0.0 else force * way(motion)


def structural_energy(coefficient: float, motion: Waveform) -> float:
    """Return the energy dissipated per cycle by structural damping, J, exact: pi eta k X_h^2 in
    each cycle of harmonic h.
    """
    return float(np.pi * coefficient * motion.length_unit**2 * harmonic_sum(motion, 3))


def way(motion: Waveform) -> float:
    """Return the path length of the box in one cycle, m: 4 X for a sine.

    It is the sum of the distances between turning points. Those are found between samples by a
    secant: the position is stationary there, so an error of 1e-7 rad is one of 1e-14 of X.
    """
    phase = 2.0 * np.pi * (np.arange(QUADRATURE_POINTS + 1) + 0.5) / QUADRATURE_POINTS
    velocity = motion.at(phase)[1]
    before = np.flatnonzero((velocity[:-1] >= 0.0) != (velocity[1:] >= 0.0))
    share = velocity[before] / (velocity[before] - velocity[before + 1])
    turning = motion.at(phase[before] + share * (phase[1] - phase[0]))[0]
    return float(np.abs(np.diff(turning, append=turning[:1])).sum())


def by_order(motion: Waveform) -> Waveform:
    """Return the motion with each harmonic divided by its order: the structural damping force is
    -(eta k/w) times its velocity.
    """
    orders = range(1, len(motion.sine) + 1)
    return replace(
        motion,
        sine=tuple(p / h for p, h in zip(motion.sine, orders, strict=True)),
        cosine=tuple(q / h for q, h in zip(motion.cosine, orders, strict=True)),
    )


def mean_force(losses: Losses, position: Array, velocity: Array, interval: float) -> Array:
    """Return the mean force of all channels except the cords in each interval, N, shape (edges -
    1,).

    The viscous part is exact (-c dx/dt). The quadratic part is the trapezoid of v |v|, with a
    relative error of (w h)^2/12: 2e-7 at 4096 intervals per cycle. The friction part is exact up to
    the secant that finds a turning point inside an interval.
    """
    force: Array = (-(losses.noise + losses.gas) / interval) * np.diff(position)
    if losses.air != 0.0:
        pull = velocity * np.abs(velocity)
        force -= (0.5 * losses.air) * (pull[1:] + pull[:-1])
    if losses.guide != 0.0:
        force -= losses.guide * mean_sign(velocity)
    return force


def mean_sign(velocity: Array) -> Array:
    """Return the mean of sign(v) in each interval between edges for a velocity that is linear in
    between; 0 at rest.
    """
    speed = np.abs(velocity)
    both = speed[1:] + speed[:-1]
    mean = np.zeros_like(both)
    np.divide(velocity[1:] + velocity[:-1], both, out=mean, where=both > 0.0)
    return mean


def mean_cord_force(coefficient: float, omega: float, position: Array, interval: float) -> Array:
    """Return the mean force of the cords in each interval between edges, N, exact; `position` (m)
    is that of `by_order`.
    """
    force: Array = (-coefficient / (omega * interval)) * np.diff(position)
    return force


def guide_force(friction: float, mass: float, gravity: float) -> float:
    """Return the friction of a guide under the moving weight, N: mu M g."""
    return friction * mass * gravity


def cord_coefficient(loss_factor: float, frequency: float, mass: float) -> float:
    """Return eta k of cords on which a mass (kg) swings at a frequency (Hz), N/m."""
    return float(loss_factor * mass * (2.0 * np.pi * frequency) ** 2)


def first_principles(cavity: Cavity, frequency: float) -> dict[str, float]:
    """Return the first-principles values of `noise` (N s/m) and `air` (N s^2/m^2): sound and drag
    of the closed box.
    """
    height, width, length = (
        side + 2.0 * cavity.wall for side in (cavity.height, cavity.width, cavity.length)
    )
    sound = sound_of_box(height, width, length, 2.0 * np.pi * frequency)
    return {"noise": sound, "air": drag_of_box(height, width)}


def loss_coefficients(rig: Rig, cavity: Cavity, frequency: float) -> dict[str, float]:
    """Return the coefficients `noise` (N s/m) and `air` (N s^2/m^2) of a rig with this box: the
    rig file's, by first principles where it has none.
    """
    own = {"noise": rig.loss_noise, "air": rig.loss_air}
    physics = first_principles(cavity, frequency)
    return {name: physics[name] if value is None else value for name, value in own.items()}


def over_first_principles(
    coefficients: Mapping[str, float], cavity: Cavity, frequency: float
) -> dict[str, float]:
    """Return, by channel, the ratio of the coefficients `noise` and `air` to first-principles
    values for sound and drag of the closed box.
    """
    physics = first_principles(cavity, frequency)
    return {name: value / physics[name] for name, value in coefficients.items()}


def drag_of_box(height: float, width: float) -> float:
    """Return the first-principles value of `air`, N s^2/m^2: k = rho C_d A / 2 of a blunt box; C_d
    = 10 is an upper bound (assumed).
    """
    return 0.5 * AIR_DENSITY * 10.0 * height * width


def sound_of_box(height: float, width: float, length: float, omega: float) -> float:
    """Return the first-principles value of `noise`, N s/m: the viscous equivalent of dipole sound.

    (rho V + m_a)^2 w^4/(12 pi rho c^3), where m_a is the added mass of the air, per unit length
    1.19 rho pi/4 times the square of the larger face's side (Koss 1974 form).
    """
    side = max(height, width)
    moved = AIR_DENSITY * (
        height * width * length + 1.19 * np.pi / 4.0 * side**2 * min(height, width)
    )
    return float(moved**2 * omega**4 / (12.0 * np.pi * AIR_DENSITY * SOUND_SPEED**3))
