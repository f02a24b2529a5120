"""One box of grains in prescribed sinusoidal motion: its packings, and the energy that they take.

Linear contacts without rolling friction, tangential stiffness 2/7 of the normal one, tangential
dashpot half of the normal one; walls have the stiffness of pairs.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rig.beds.pouring import pour, supply
from rig.kernels.grains.arrays import Law, Room
from rig.kernels.grains.engine import Engine, Packing
from rig.theory.contact import contact_time, damping_ratio

Array = NDArray[np.float64]

G = 9.80665


@dataclass(frozen=True)
class ShakenBox:
    """A box of equal balls that is shaken along an axis; SI units.

    axis : 0 along `length`, 2 vertical
    fill : settled height over `height`
    acceleration : peak, m/s^2
    stiffness : of the normal spring of a contact, N/m
    resolution : steps in the duration of an elastic contact of two grains
    """

    axis: int
    length: float
    width: float
    height: float
    diameter: float
    fill: float
    frequency: float
    acceleration: float
    stiffness: float = 1e5
    restitution: float = 0.6
    grain_friction: float = 0.25
    wall_friction: float = 0.45
    density: float = 7900.0
    resolution: float = 14.0

    @property
    def ball_mass(self) -> float:
        """Mass of one ball, kg."""
        return self.density * math.pi / 6.0 * self.diameter**3

    @property
    def steps(self) -> int:
        """Steps in a cycle: as many as make each t_c/resolution or a little less."""
        duration = contact_time(0.0, self.stiffness, 0.5 * self.ball_mass)
        return math.ceil(self.resolution / (duration * self.frequency))

    @property
    def dt(self) -> float:
        """Step, s."""
        return 1.0 / (self.frequency * self.steps)

    @property
    def law(self) -> Law:
        """The contact law."""
        damping = 2.0 * damping_ratio(self.restitution)
        shear = 2.0 / 7.0 * self.stiffness
        return Law(
            hertz=0,
            pair_stiffness=self.stiffness,
            wall_stiffness=self.stiffness,
            pair_shear=shear,
            wall_shear=shear,
            pair_damping=damping,
            wall_damping=damping,
            shear_damping=0.5,
            pair_friction=self.grain_friction,
            wall_friction=self.wall_friction,
            pair_rolling=0.0,
            wall_rolling=0.0,
        )

    @property
    def room(self) -> Room:
        """The cavity with its lid."""
        sides = (self.length, self.width, self.height)
        return Room(*sides, 0, 1, 1.0, 1, 0.0, 0.0, -G, self.axis)

    @property
    def bed(self) -> tuple[float, ...]:
        """What a packing depends on, apart from its seed."""
        sides = (self.length, self.width, self.height, self.diameter, self.fill)
        friction = (self.grain_friction, self.wall_friction)
        return (*sides, self.stiffness, self.restitution, *friction, self.density)

    def poured(self, seed: int) -> Packing:
        """Return a settled packing."""
        volume = math.pi / 6.0 * self.diameter**3
        radii = np.full(supply(self.fill, self.room, volume), 0.5 * self.diameter)
        return pour(radii, self.density, self.fill, self.law, self.room, self.dt, seed)

    def velocity(self, cycles: int) -> Array:
        """Return the velocity of the box half a step around each step of a number of cycles, m/s.

        The box starts in its middle, where its acceleration is zero.
        """
        n = np.arange(cycles * self.steps + 1) - 0.5
        peak = self.acceleration / (2.0 * math.pi * self.frequency)
        return np.asarray(peak * np.cos(2.0 * math.pi * n / self.steps))

    def scale(self, mass: float) -> float:
        """Return M V^2 of a mass, J."""
        return mass * (self.acceleration / (2.0 * math.pi * self.frequency)) ** 2


@dataclass(frozen=True)
class GrainResponse:
    """What the grains took from the box in each cycle that counts.

    work : J, shape (cycles,)
    in_phase : mass that moves in phase with the box over the grains' mass, shape (cycles,)
    mass : of the grains, kg
    gap : in the account over all cycles, settling included, over the work of all
    """

    work: Array
    in_phase: Array
    mass: float
    gap: float


def shake(
    box: ShakenBox, packing: Packing, settle: int, cycles: int, threads: int = 1
) -> GrainResponse:
    """Return the response of a packing: `settle` cycles that do not count, then `cycles`."""
    engine = Engine(packing, box.law, box.room, box.dt, threads)
    one = box.velocity(1)
    shape = -np.sin(2.0 * math.pi * np.arange(box.steps) / box.steps)
    start = engine.energy(float(one[0])).sum()
    work, in_phase, spent = [], [], 0.0
    for _ in range(settle + cycles):
        found = engine.advance(one)
        work.append(found.work)
        spent += found.work - float(found.loss.sum())
        force = np.diff(found.impulse) / box.dt
        in_phase.append(2.0 * float(np.mean(force * shape)) / box.acceleration)
    gap = (spent - (float(found.energy.sum()) - float(start))) / sum(np.abs(work))
    mass = engine.mass
    return GrainResponse(
        np.array(work[settle:]), np.array(in_phase[settle:]) / mass, mass, abs(float(gap))
    )
