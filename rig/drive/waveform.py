"""The prescribed motion of the box, harmonics of one fundamental in closed form, and its sampling
grid.

The grid consists of the edges of the oversampled intervals over which force and acceleration are
averaged.
"""

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from rig.kernels.waveform import sines
from rig.protocol.spec import Drive

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Waveform:
    """A periodic motion: x = X sum_h (sine_h sin h wt + cosine_h cos h wt)/h^2, X = A/w^2, v = x',
    a = v'.

    `acceleration` (m/s^2) is the unit A of the harmonic coefficients `sine` and `cosine`, harmonics
    1..H. A pure sine of amplitude A is sine = (1,), cosine = (0,): a = -A sin wt, v = (A/w) cos wt.
    """

    frequency: float
    acceleration: float
    sine: tuple[float, ...] = (1.0,)
    cosine: tuple[float, ...] = (0.0,)

    @property
    def omega(self) -> float:
        """Angular frequency of the fundamental, rad/s."""
        return 2.0 * np.pi * self.frequency

    @property
    def velocity_unit(self) -> float:
        """A/w, m/s: the velocity amplitude of a pure sine."""
        return self.acceleration / self.omega

    @property
    def length_unit(self) -> float:
        """A/w^2, m: the displacement amplitude of a pure sine."""
        return self.acceleration / self.omega**2

    @property
    def coefficients(self) -> tuple[Array, Array]:
        """Harmonic coefficients as arrays, for the kernels."""
        return np.array(self.sine, dtype=np.float64), np.array(self.cosine, dtype=np.float64)

    @cached_property
    def start_velocity(self) -> float:
        """Box velocity at the start of every cycle, m/s."""
        return float(self.at(np.zeros(1))[1][0])

    def at(self, phase: Array) -> tuple[Array, Array]:
        """Return the box position (m) and velocity (m/s) at phases of the fundamental (rad)."""
        position, velocity = np.zeros_like(phase), np.zeros_like(phase)
        for h, (p, q) in enumerate(zip(self.sine, self.cosine, strict=True), start=1):
            if p == 0.0 and q == 0.0:
                continue
            s, c = sines(h * phase)
            position += (p / h**2) * s + (q / h**2) * c
            velocity += (p / h) * c - (q / h) * s
        return self.length_unit * position, self.velocity_unit * velocity


def viscous_energy(coefficient: float, motion: Waveform) -> float:
    """Return the energy dissipated per cycle by -c v, J: integral of c v^2 dt, exact; pi c w X^2
    for a sine.
    """
    return float(
        0.5 * coefficient * motion.velocity_unit**2 * harmonic_sum(motion, 2) / motion.frequency
    )


def harmonic_sum(motion: Waveform, power: int) -> float:
    """Return sum_h (sine_h^2 + cosine_h^2)/h^power, dimensionless."""
    harmonics = np.arange(1, len(motion.sine) + 1)
    return float(np.sum((np.square(motion.sine) + np.square(motion.cosine)) / harmonics**power))


def waveform(
    drive: Drive,
    level_error: float,
    third_harmonic: float,
    rng: np.random.Generator | None,
    clock: float = 1.0,
) -> Waveform:
    """Return the motion that ideal waveform control (`prescribed`) reaches for a drive setting.

    level_error : relative standard deviation of the level, normal (assumed, rig file)
    third_harmonic : relative amplitude of a third harmonic at a random phase (assumed, rig file)
    rng : None for an exact waveform
    clock : factor of the generator's frequency error
    """
    if rng is None:
        return Waveform(drive.frequency * clock, drive.acceleration)
    level = 1.0 + level_error * rng.standard_normal()
    angle = rng.uniform(0.0, 2.0 * np.pi)
    third = third_harmonic * level
    return Waveform(
        drive.frequency * clock,
        drive.acceleration,
        (level, 0.0, third * math.cos(angle)),
        (0.0, 0.0, third * math.sin(angle)),
    )


@dataclass(frozen=True)
class Edges:
    """Box position (m) and velocity (m/s) at the sampling edges of whole cycles, preceded by one
    more edge.

    Both have shape (1 + edges,): the interval between entries k and k + 1 is interval k.
    """

    position: Array
    velocity: Array


@dataclass
class Sampling:
    """A waveform at sampling edges j = 0, 1, ..: edge j lies j / edges_per_cycle cycles after the
    start.

    Cycle n contains the edges in [n, n + 1) cycles. If the number of edges per cycle is whole, all
    stretches of equal length are identical: one object, computed once.
    """

    motion: Waveform
    edges_per_cycle: float
    _kept: dict[int, Edges] = field(default_factory=dict, init=False, repr=False)

    def first_edge(self, cycle: int) -> int:
        """Return the number of the first edge of a cycle."""
        return int(np.ceil(cycle * self.edges_per_cycle))

    def edges(self, first_cycle: int, cycles: int) -> Edges:
        """Return the motion at the edges of `cycles` cycles from `first_cycle` on."""
        if float(self.edges_per_cycle).is_integer():
            if cycles not in self._kept:
                self._kept = {cycles: self._repeated(cycles)}
            return self._kept[cycles]
        edge = np.arange(self.first_edge(first_cycle) - 1, self.first_edge(first_cycle + cycles))
        turns = edge / self.edges_per_cycle
        # Whole turns are removed first: the sine of a large phase would lose digits.
        return Edges(*self.motion.at(2.0 * np.pi * (turns - np.floor(turns))))

    def _repeated(self, cycles: int) -> Edges:
        one = int(self.edges_per_cycle)
        position, velocity = self.motion.at(2.0 * np.pi * np.arange(one) / one)
        return Edges(*(np.concatenate((x[-1:], np.tile(x, cycles))) for x in (position, velocity)))
