"""The stand in prescribed motion: force and acceleration at the transducers, chunk by chunk."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from rig.beds.bed import Bed
from rig.beds.janssen_stack import Filling
from rig.beds.registry import BEDS
from rig.catalog.entries import Rig
from rig.drive.losses import by_order, mean_cord_force, mean_force
from rig.drive.waveform import Edges, Sampling, Waveform
from rig.protocol.spec import Scene
from rig.stand.box import box_mass, losses_of
from rig.stand.gas import gas_damping
from rig.stand.ledger import COLUMNS, account

Array = NDArray[np.float64]

CHUNK_CYCLES = 2
"""Cycles per chunk: few enough that the sums over their sampling edges stay in the second-level
cache.
"""


@dataclass(frozen=True)
class Chunk:
    """Whole cycles of the stand: force and acceleration, shape (2, intervals), and rows of the
    ledger.
    """

    means: Array
    ledger: Array


@dataclass
class Replay:
    """Chunks of a periodic stand: the first period is stored and then returned in turn."""

    _wanted: int = 0
    _kept: list[Chunk] = field(default_factory=list)
    _turn: int = 0

    def note(self, chunk: Chunk, repeats: int) -> None:
        """Register a simulated chunk; `repeats` is the period in cycles of everything from it on, 0
        for none.

        The first periodic chunk is not stored: it begins with the step from the momentum before the
        periodic part.
        """
        if self._wanted:
            self._kept.append(chunk)
        elif repeats:
            self._wanted = math.lcm(repeats, CHUNK_CYCLES) // CHUNK_CYCLES

    def next(self) -> Chunk | None:
        """Return the next chunk, None while it has to be simulated."""
        if not self._wanted or len(self._kept) < self._wanted:
            return None
        chunk = self._kept[self._turn % self._wanted]
        self._turn += 1
        return chunk


@dataclass(frozen=True)
class BoxMeans:
    """Means of the box alone over the intervals that end at some edges: acceleration, and force
    without the bed.
    """

    edges: Edges
    acceleration: Array
    force: Array


class Stand:
    """A `PhysicalSource`: force at the gauge (N) and acceleration of the box (m/s^2), means over
    the same intervals.

    F_gauge = (M_box + m_gauge) a - F_bed - F_losses; forces on the box are positive along the drive
    axis. On a vertical axis the gauge also carries the weight of the moving parts, unless cords do:
    a mean force, which does no net work over a cycle. The stream starts with the motion and is
    endless, in constant memory.
    """

    names = ("force", "acceleration")

    def __init__(
        self, scene: Scene, rig: Rig, motion: Waveform, filling: Filling, rate: float
    ) -> None:
        self.rate = rate
        self.motion = motion
        self._sampling = Sampling(motion, rate / motion.frequency)
        self._bed: Bed = BEDS[scene.bed](scene, rig, filling, self._sampling)
        self._rigid = box_mass(scene.cavity, rig.wall_density) + rig.gauge_mass
        gas = gas_damping(scene, rig, filling, motion) if "gas" in scene.losses else 0.0
        self._losses = losses_of(scene, rig, self._rigid + self._bed.mass, motion.frequency, gas)
        self._lost = self._losses.energies(motion)
        on_gauge = scene.axis == "vertical" and scene.support != "cords"
        self.weight = (self._rigid + self._bed.mass) * rig.gravity if on_gauge else 0.0
        self._cords = (
            Sampling(by_order(motion), rate / motion.frequency) if self._losses.cords else None
        )
        self._kinetic = self._bed.kinetic_at_start
        self._inertial = np.pi * (self._rigid + self._bed.mass) * motion.velocity_unit**2
        self._cycles = 0
        self._last_momentum = 0.0
        self._box: BoxMeans | None = None
        self._waiting = np.zeros((2, 0))
        self._latest = np.zeros(0)
        self._rows: list[Array] = []
        self._replay = Replay()

    @property
    def bed_mass(self) -> float:
        """Mass of the grains in this filling, kg."""
        return self._bed.mass

    @property
    def latest_force(self) -> Array:
        """Gauge force (N) over the latest chunk of whole cycles."""
        return self._latest

    def read(self, n: int) -> Array:
        """Return the next n interval means, shape (2, n)."""
        ready = [self._waiting]
        size = self._waiting.shape[1]
        while size < n:
            ready.append(self.advance())
            size += ready[-1].shape[1]
        joined = np.concatenate(ready, axis=1) if len(ready) > 1 else ready[0]
        self._waiting = joined[:, n:]
        return joined[:, :n]

    def drain_ledger(self) -> Array:
        """Return the ledger rows of the cycles simulated since the last call, shape (cycles,
        len(ledger.COLUMNS)).
        """
        rows = np.concatenate([np.zeros((0, len(COLUMNS))), *self._rows])
        self._rows = []
        return rows

    def advance(self) -> Array:
        """Return the interval means of the next chunk of whole cycles, shape (2, intervals); one
        less at the very start.

        In a periodic state earlier chunks are returned again, bit for bit.
        """
        chunk = self._replay.next() or self._simulated()
        at_start = self._cycles == 0
        self._cycles += CHUNK_CYCLES
        self._rows.append(chunk.ledger)
        self._latest = chunk.means[0]
        return chunk.means[:, 1:] if at_start else chunk.means

    def _simulated(self) -> Chunk:
        before = self._box
        box = self._box_means(self._sampling.edges(self._cycles, CHUNK_CYCLES))
        reaction = self._bed.advance(CHUNK_CYCLES)
        ledger = account(reaction, self._kinetic, self._lost, self._inertial)
        self._kinetic = float(reaction.kinetic[-1])
        means = np.empty((2, reaction.momentum.size))
        force, momentum = means[0], reaction.momentum
        # Force of the bed as the difference of its momentum: an impact counts in full, whatever its
        # duration.
        force[0] = momentum[0] - self._last_momentum
        np.subtract(momentum[1:], momentum[:-1], out=force[1:])
        force *= self.rate
        force += box.force
        means[1] = box.acceleration
        self._last_momentum = float(momentum[-1])
        chunk = Chunk(means, ledger)
        self._replay.note(chunk, reaction.repeats if box is before else 0)
        return chunk

    def _box_means(self, edges: Edges) -> BoxMeans:
        """Return the means of the box alone, computed once if the edges repeat."""
        if self._box is None or self._box.edges is not edges:
            acceleration = np.diff(edges.velocity) * self.rate
            lost = mean_force(self._losses, edges.position, edges.velocity, 1.0 / self.rate)
            if self._cords is not None:
                position = self._cords.edges(self._cycles, CHUNK_CYCLES).position
                lost += mean_cord_force(
                    self._losses.cords, self.motion.omega, position, 1.0 / self.rate
                )
            self._box = BoxMeans(
                edges, acceleration, self._rigid * acceleration + (self.weight - lost)
            )
        return self._box
