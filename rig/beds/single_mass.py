"""Bed `single_mass` in prescribed motion: all grains as a single mass in the free gap that they
leave, event by event.
"""

import math

import numpy as np

from rig.beds.bed import Array, Reaction
from rig.beds.janssen_stack import Filling, bed_mass
from rig.catalog.entries import Rig
from rig.drive.waveform import Sampling
from rig.errors import InputError, Mistake
from rig.kernels.single_mass.many_cycles import follow
from rig.kernels.single_mass.one_cycle import State, no_events
from rig.protocol.spec import Scene
from rig.theory.single_mass import MassInGap

LOOK_BACK = 64
"""Longest period, in calls of `advance`, that is reported to the stand for replay."""


def free_gap(scene: Scene, rig: Rig, filling: Filling) -> float:
    """Return the clearance along the axis that a bed leaves, m.

    Vertical and zero gravity: (1 - w) H, the height above the settled bed. Resolved grains fly as
    one body that does not swell first: with the room of a bed at flowing density nothing would
    move above w = phi_f/phi_b, where they dissipate most. Horizontal: L (1 - w phi_b/phi_f), at
    least 0, beside a bed at flowing density.
    """
    fill = scene.grains.fill
    if scene.axis != "horizontal":
        return scene.cavity.height * (1.0 - fill)
    return max(scene.cavity.length * (1.0 - fill * filling.packing / rig.packing_loose), 0.0)


def single_mass(scene: Scene, rig: Rig, filling: Filling) -> MassInGap:
    """Return the single mass of a filling. Its gap comes from the scene, or from the fill if the
    scene gives none; without a gap it starts at rest.
    """
    settings, vertical = scene.single_mass, scene.axis == "vertical"
    if settings.gap == "none":
        low, high = 0.0 if vertical else -math.inf, math.inf
    else:
        low, high = (
            0.0,
            free_gap(scene, rig, filling) if settings.gap is None else float(settings.gap),
        )
    return MassInGap(
        mass=bed_mass(scene, filling.packing),
        low=low,
        high=high,
        weight=rig.gravity if vertical else 0.0,
        friction=settings.friction * rig.gravity if scene.axis == "horizontal" else 0.0,
        restitution=settings.restitution,
        start=min(settings.start, high),
        velocity=settings.velocity if high > low else 0.0,
    )


class SingleMassBed:
    """A single mass in a box that follows a waveform. `momentum` excludes its weight: `Stand` adds
    it.
    """

    def __init__(self, single_mass: MassInGap, sampling: Sampling) -> None:
        motion = sampling.motion
        self._single_mass = single_mass
        self._sampling = sampling
        self._coefficients = motion.coefficients
        self._world, self._table = single_mass.world(
            motion.acceleration, motion.frequency, *self._coefficients
        )
        self._state = single_mass.state(motion.acceleration, motion.frequency)
        self._events = no_events()
        self._cycles = 0
        self._passed: list[State] = []

    @property
    def mass(self) -> float:
        """Mass of the grains, kg."""
        return self._single_mass.mass

    @property
    def kinetic_at_start(self) -> float:
        """Energy when the motion starts, J: kinetic, plus potential above the floor where it has
        weight.
        """
        single_mass, velocity = self._single_mass, self._sampling.motion.start_velocity
        return single_mass.mass * (
            0.5 * (velocity + single_mass.velocity) ** 2 + single_mass.weight * single_mass.start
        )

    def advance(self, cycles: int) -> Reaction:
        """Advance by whole cycles of the drive. Raises InputError if there are too many events to
        follow.
        """
        unit = self._sampling.motion.velocity_unit
        velocity: Array = self._sampling.edges(self._cycles, cycles).velocity[1:] / unit
        repeats = self._repeats()
        momentum, found = follow(
            self._cycles,
            cycles,
            float(self._sampling.edges_per_cycle),
            velocity,
            self._single_mass.mass * unit,
            self._state,
            self._world,
            self._table,
            *self._coefficients,
            self._events,
        )
        if (found.counts[:, 0] < 0).any():
            raise too_many_events(self._single_mass)
        self._cycles += cycles
        mode, q, u = found.state[-1]
        self._state = State(int(mode), float(q), float(u))
        energy = self._single_mass.mass * unit**2 * found.energy
        return Reaction(
            momentum=momentum,
            work=energy[:, 0],
            friction=energy[:, 1],
            collision=energy[:, 2],
            viscous=np.zeros(cycles),
            kinetic=energy[:, 3],
            repeats=repeats * cycles,
        )

    def _repeats(self) -> int:
        """Return after how many calls of `advance` the current state has recurred exactly; 0 for
        none yet.
        """
        back = next(
            (n for n, state in enumerate(reversed(self._passed), 1) if state == self._state), 0
        )
        self._passed = [*self._passed[1 - LOOK_BACK :], self._state]
        return back


def too_many_events(single_mass: MassInGap) -> InputError:
    """Return the error for a single mass that bounces more often in a cycle than can be
    followed.
    """
    return InputError(
        Mistake(
            where="scene",
            field="scene.single_mass",
            found=f"a single mass of restitution {single_mass.restitution:.3g} in a gap of {single_mass.high - single_mass.low:.3g} m "
            "meets more events than can be followed: 65536 in one cycle, or 1e7 on the way to its mean",
            allowed="a larger gap, or a single mass that rebounds less",
        )
    )
