"""The whole bed as a single mass in a free gap: energy per cycle, its upper bound, and closed-form
orbits.

The closed forms are in units of m (A/w)^2 (mass m, peak acceleration A, angular frequency w), for
an exact sine: `level` is A/g; `gap` and `eta` are in units of A/w^2 and A. They hold for the orbit
that starts at rest on the floor.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from rig.kernels.single_mass.flight import LATE, LOW
from rig.kernels.single_mass.many_cycles import AVERAGE, SETTLE, MeanCycle, steady
from rig.kernels.single_mass.one_cycle import State, World, world
from rig.kernels.waveform import Array
from rig.theory.total import ModelEnergy, TooManyEvents, plastic_bound


@dataclass(frozen=True)
class MassInGap:
    """A single mass in a box, SI units.

    low, high : positions of the walls along the axis, m, infinite if there is none
    weight : acceleration towards the low wall, m/s^2
    friction : of the floor of a horizontal box, mu g, m/s^2
    start, velocity : initial position and velocity relative to the box, m and m/s
    """

    mass: float
    low: float
    high: float
    weight: float
    friction: float
    restitution: float
    start: float
    velocity: float

    def world(
        self, acceleration: float, frequency: float, P: Array, Q: Array
    ) -> tuple[World, Array]:
        """Return the kernel's description of box and mass, in units of a waveform of peak
        `acceleration` (m/s^2).
        """
        length = acceleration / (2.0 * math.pi * frequency) ** 2
        weight, band = self.weight / acceleration, self.friction / acceleration
        return world(weight, band, self.low / length, self.high / length, self.restitution, P, Q)

    def state(self, acceleration: float, frequency: float) -> State:
        """Return the initial state in units of the waveform: at rest, or moving (on a rough floor,
        in one direction).
        """
        omega = 2.0 * math.pi * frequency
        u = self.velocity * omega / acceleration
        towards = int(math.copysign(1.0, u)) if self.friction > 0.0 else 1
        # Same expression as in `world`: a start at a wall must equal the wall position bit for bit.
        length = (
            acceleration / omega**2
        )  # as in `world`: a start at a wall is at the wall to the last bit
        return State(0 if u == 0.0 else towards, self.start / length, u)


@dataclass(frozen=True)
class SingleMassTotal:
    """Energy per cycle of a single mass.

    total : J
    bound : upper bound, J
    moves : whether it ever moves relative to the box
    error : relative standard error of the mean, 0 for a periodic orbit
    """

    total: ModelEnergy
    bound: float
    moves: bool
    error: float


def single_mass_total(
    single_mass: MassInGap,
    acceleration: float,
    frequency: float,
    settle: int = SETTLE,
    average: int = AVERAGE,
    window: tuple[int, int] | None = None,
) -> SingleMassTotal:
    """Return the energy per cycle of a single mass on an exact sine of peak `acceleration` (m/s^2),
    once settled.

    settle, average : cycles before the mean, and cycles of the mean, of an orbit without a period
    window : (first cycle, one past the last) of an additional mean; None for none

    Raises TooManyEvents.
    """
    P, Q = np.ones(1), np.zeros(1)
    start = single_mass.state(acceleration, frequency)
    found = steady(
        start,
        *single_mass.world(acceleration, frequency, P, Q),
        P,
        Q,
        settle,
        average,
        window or (0, 0),
    )
    if found.period < 0:
        raise TooManyEvents("a single mass meets more events in one cycle than can be followed")
    velocity = acceleration / (2.0 * math.pi * frequency)
    unit = single_mass.mass * velocity**2
    taken = found.friction + found.collision
    return SingleMassTotal(
        total=ModelEnergy(
            unit * found.friction,
            unit * found.collision,
            found.period,
            1.0 if found.period else 0.0,
            None if window is None else unit * found.window,
        ),
        bound=bound(single_mass, velocity, frequency, found),
        moves=found.moves,
        error=found.error / taken if taken > 0.0 else 0.0,
    )


def bound(single_mass: MassInGap, velocity: float, frequency: float, found: MeanCycle) -> float:
    """Return the upper bound of the energy per cycle at a box velocity amplitude (m/s), J.

    m g V/f if gravity acts and no lid is hit: the mean contact force is m g and never negative, and
    the box velocity is at most V. Otherwise `plastic_bound`, two hits per cycle at 2 V.
    """
    if single_mass.weight > 0.0 and not found.lid:
        return single_mass.mass * single_mass.weight * velocity / frequency
    return plastic_bound(single_mass.mass, velocity, single_mass.restitution)


def thrown_height(velocity: float, frequency: float, gravity: float) -> float:
    """Return the height above the floor, m, that a grain of a vertical box does not reach, at a box
    velocity amplitude (m/s): thrown at 2 V, an elastic hit of the floor at its fastest, while the
    floor comes back from one end of its stroke to the other.
    """
    stroke = velocity / (2.0 * math.pi * frequency)
    return (2.0 * velocity) ** 2 / (2.0 * gravity) + 2.0 * stroke


def zero_gravity_energy(gap: float) -> float:
    """Return W per cycle of a plastic mass between two walls without weight, gap <= pi: (1 - cos
    t)^2, t - sin t = gap.
    """
    t = _root(lambda t: t - math.sin(t) - gap, 0.0, math.pi + 1e-9)
    # 1 - cos t = 2 sin^2(t/2), without cancellation.
    return (2.0 * math.sin(0.5 * t) ** 2) ** 2


def friction_block_energy(eta: float) -> float:
    """Return W per cycle of a block that never stops on a rough floor, eta = mu g/A < 2/sqrt(4 +
    pi^2) = 0.537.
    """
    return 4.0 * eta * math.sqrt(1.0 - (0.5 * math.pi * eta) ** 2)


def plastic_energy(level: float) -> float:
    """Return W per cycle of a plastic mass on a floor without lid, 1 < level <= sqrt(1 + pi^2).

    It takes off at sin phi = 1/level and lands while the floor pushes, once per cycle. The flight
    is expressed in the phase since take-off, where height and relative speed start as t^3 and t^2:
    no cancellation.
    """
    # sin and cos of the take-off phase.
    pull, lead = 1.0 / level, math.sqrt((level - 1.0) * (level + 1.0)) / level

    def height(t: float) -> float:
        return lead * _late(t) - pull * _low(t)

    t = _root(height, lead, 2.0 * math.pi)
    speed = lead * 2.0 * math.sin(0.5 * t) ** 2 - pull * _late(t)
    return 0.5 * speed**2


def locking_band(k: int) -> tuple[float, float]:
    """Return the levels between which a plastic mass lands k cycles after each take-off, at the
    phase of the take-off.
    """
    return math.sqrt(1.0 + (k * math.pi) ** 2), math.sqrt(4.0 + (k * math.pi) ** 2)


def locked_energy(level: float, k: int) -> float:
    """Return W per cycle of the drive in the k-th locking band: 2 pi^2 k m g^2/w^2; k times that in
    each landing.
    """
    return 2.0 * math.pi**2 * k / level**2


def bouncing_loss(level: float, k: int, e: float) -> float:
    """Return the loss per hit of a mass that bounces once in k cycles: 2 pi^2 k^2 (1 - e)/(1 + e) m
    g^2/w^2.
    """
    return 2.0 * (math.pi * k / level) ** 2 * (1.0 - e) / (1.0 + e)


def bouncing_band(k: int, e: float) -> tuple[float, float]:
    """Return the levels between which the orbit of `bouncing_loss` exists and is stable.

    Its multipliers have the product e^2 and the sum 1 + e^2 - (1 + e)^2 level sin(phi), with
    cos(phi) = pi k (1 - e)/((1 + e) level) at the hit.
    """
    # Lower end: cos(phi) = 1. Upper end: the sum of the multipliers reaches -(1 + e^2), period
    # doubling.
    least = math.pi * k * (1.0 - e) / (1.0 + e)
    return least, math.hypot(least, 2.0 * (1.0 + e * e) / (1.0 + e) ** 2)


def _late(t: float) -> float:
    """Return t - sin t without cancellation."""
    return t - math.sin(t) if t > 1.0 else t**3 * sum(c * t ** (2 * n) for n, c in enumerate(LATE))


def _low(t: float) -> float:
    """Return t^2/2 - 1 + cos t without cancellation."""
    return (
        0.5 * t * t - 1.0 + math.cos(t)
        if t > 1.0
        else t**4 * sum(c * t ** (2 * n) for n, c in enumerate(LOW))
    )


def _root(f: Callable[[float], float], lo: float, hi: float) -> float:
    """Return the sign change of f in a bracket, by bisection."""
    # To the last bit: the bracket ends when no number lies between its ends.
    side = f(lo) > 0.0
    while True:
        middle = 0.5 * (lo + hi)
        if middle <= lo or middle >= hi:
            return middle
        if (f(middle) > 0.0) == side:
            lo = middle
        else:
            hi = middle
