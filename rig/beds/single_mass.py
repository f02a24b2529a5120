"""Bed `slug` in servo drive: all grains as one mass in the free gap that they leave, event by event."""

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
from rig.theory.single_mass import Slug

LOOK_BACK = 64
"""Longest period, in cycles, of which the stand is told that it may replay it."""


def free_gap(scene: Scene, rig: Rig, filling: Filling) -> float:
    """Room along the axis beside a bed at flowing density, m: L (1 - w phi_b/phi_f), 0 where there is none."""
    along = scene.cavity.length if scene.axis == "horizontal" else scene.cavity.height
    return max(along * (1.0 - scene.grains.fill * filling.packing / rig.packing_loose), 0.0)


def slug(scene: Scene, rig: Rig, filling: Filling) -> Slug:
    """The slug of a filling: its gap as the scene gives it, or from the fill. Without room it starts at rest."""
    settings, vertical = scene.slug, scene.axis == "vertical"
    if settings.gap == "none":
        low, high = 0.0 if vertical else -math.inf, math.inf
    else:
        low, high = 0.0, free_gap(scene, rig, filling) if settings.gap is None else float(settings.gap)
    return Slug(
        mass=bed_mass(scene, filling.packing),
        low=low,
        high=high,
        weight=rig.gravity if vertical else 0.0,
        friction=settings.friction * rig.gravity if scene.axis == "horizontal" else 0.0,
        restitution=settings.restitution,
        start=min(settings.start, high),
        velocity=settings.velocity if high > low else 0.0,
    )


class SlugBed:
    """A slug in a box that follows a waveform. Its weight is not in the momentum: the stand carries it (`Stand`)."""

    def __init__(self, slug: Slug, sampling: Sampling) -> None:
        motion = sampling.motion
        self._slug = slug
        self._sampling = sampling
        self._coefficients = motion.coefficients
        self._world, self._table = slug.world(motion.acceleration, motion.frequency, *self._coefficients)
        self._state = slug.state(motion.acceleration, motion.frequency)
        self._events = no_events()
        self._cycles = 0
        self._passed: list[State] = []

    @property
    def mass(self) -> float:
        """Mass of the grains, kg."""
        return self._slug.mass

    @property
    def kinetic_at_start(self) -> float:
        """Energy when the motion starts, J: kinetic, and potential above the floor where it has weight."""
        slug, velocity = self._slug, self._sampling.motion.start_velocity
        return slug.mass * (0.5 * (velocity + slug.velocity) ** 2 + slug.weight * slug.start)

    def advance(self, cycles: int) -> Reaction:
        """The next whole cycles of the drive. Raises InputError where there are more events than can be followed."""
        unit = self._sampling.motion.velocity_unit
        velocity: Array = self._sampling.edges(self._cycles, cycles).velocity[1:] / unit
        repeats = self._repeats()
        momentum, found = follow(
            self._cycles, cycles, float(self._sampling.edges_per_cycle), velocity, self._slug.mass * unit,
            self._state, self._world, self._table, *self._coefficients, self._events,
        )  # fmt: skip
        if (found.counts[:, 0] < 0).any():
            raise too_many_events(self._slug)
        self._cycles += cycles
        mode, q, u = found.state[-1]
        self._state = State(int(mode), float(q), float(u))
        energy = self._slug.mass * unit**2 * found.energy
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
        """Calls of `advance` after which the very same state has come back, 0 for none yet."""
        back = next((n for n, state in enumerate(reversed(self._passed), 1) if state == self._state), 0)
        self._passed = [*self._passed[1 - LOOK_BACK :], self._state]
        return back


def too_many_events(slug: Slug) -> InputError:
    """The error for a slug that bounces more often in a cycle than can be followed."""
    return InputError(
        Mistake(
            where="scene",
            field="scene.slug",
            found=f"a slug of restitution {slug.restitution:.3g} in a gap of {slug.high - slug.low:.3g} m "
            "meets more events than can be followed: 65536 in one cycle, or 1e7 on the way to its mean",
            allowed="a larger gap, or a slug that rebounds less",
        )
    )
