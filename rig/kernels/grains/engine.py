"""The state of a box of grains between calls of the compiled loops: memory, threads, account."""

from __future__ import annotations

import math
import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rig.kernels.grains.advance import advance, begin
from rig.kernels.grains.arrays import (
    FAULT,
    LISTS_FULL,
    REBUILDS,
    SLABS,
    SUMS,
    TOTALS,
    WALL_X,
    WALL_Z,
    WORK_OF_BOX,
    Cells,
    Floats,
    Ghosts,
    GrainArrays,
    Law,
    Lists,
    Room,
)
from rig.kernels.grains.barrier import new_flags
from rig.kernels.grains.energy import elastic, energies
from rig.kernels.grains.state import EngineState, contacts, restore

SKIN = 0.1
"""Neighbours are closer than touching by this fraction of the smallest diameter."""
ROOM_FOR = 12
"""Neighbours listed per grain at most, on average; a dense packing of equal balls has about 5."""


class LostGrains(ArithmeticError):
    """The grains cannot be followed: one left the box, or the lists have no room."""


@dataclass(frozen=True)
class Packing:
    """Grains at rest or in motion, in the order of their numbers; SI units, frame of the box.

    place : x, y, z, shape (n, 3); radius, mass : shape (n,); velocity, spin : shape (n, 3)
    cavity : number of the cavity of each grain, shape (n,)
    """

    place: Floats
    radius: Floats
    mass: Floats
    velocity: Floats
    spin: Floats
    cavity: NDArray[np.int32]

    @staticmethod
    def at_rest(place: Floats, radius: Floats, density: float) -> Packing:
        """Return balls of one density (kg/m^3) at rest in cavity 0."""
        n = radius.size
        still = np.zeros((n, 3))
        mass = density * 4.0 / 3.0 * np.pi * radius**3
        return Packing(place, radius, mass, still, still.copy(), np.zeros(n, np.int32))


@dataclass(frozen=True)
class Stretch:
    """What a stretch of the motion gave.

    impulse : of the walls on the grains along the axis up to half a step before each step, N s,
        counted from the start of the engine, shape (steps + 1,)
    force : wall force on the grains along the axis at the end, N
    work : of the box on the grains over the stretch, J
    loss : by kind (`PAIR_NORMAL` ...), J, shape (4,)
    energy : of the grains at the end: kinetic (laboratory), rotational, weight, elastic, J
    """

    impulse: Floats
    force: float
    work: float
    loss: Floats
    energy: Floats


class Engine:
    """Grains in a box that moves as it is told; advanced stretch by stretch.

    It begins with the forces of its packing and with the energy that its contacts store; tangential
    springs are relaxed. The same bits come out whatever the number of threads.
    """

    def __init__(self, packing: Packing, law: Law, room: Room, dt: float, threads: int = 1) -> None:
        """Take a packing. Raises LostGrains if its grains cannot be followed."""
        self._make_room(packing, law, room, dt, threads)
        begin(
            self._grains,
            self._lists,
            self._ghosts,
            self._old_grains,
            self._old_lists,
            self._grid,
            law,
            room,
            self._sums,
            self._totals,
        )
        self._check()
        self._elastic = elastic(self._grains, self._lists, law, room)

    @classmethod
    def resumed(
        cls, state: EngineState, law: Law, room: Room, dt: float, threads: int = 1
    ) -> Engine:
        """Return an engine that goes on from a state with the same bits, on any number of threads.

        law, room, dt : those of the engine that gave the state
        """
        engine = cls.__new__(cls)
        grains = GrainArrays(state.place, state.motion, state.load, state.ident, state.cavity)
        engine._make_room(_packing(grains), law, room, dt, threads)
        restore(state, engine._grains, engine._lists)
        engine._elastic = state.elastic.copy()
        engine._totals[:] = state.totals
        engine._sums[:, WALL_X : WALL_Z + 1] = state.force
        engine.impulse = float(state.impulse)
        engine.steps = int(state.steps)
        return engine

    def state(self) -> EngineState:
        """Return all that `resumed` needs, copied."""
        grains = {name: part.copy() for name, part in self._grains._asdict().items()}
        return EngineState(
            **grains,
            **contacts(self._lists)._asdict(),
            elastic=self._elastic.copy(),
            totals=self._totals.copy(),
            force=self._sums[:, WALL_X : WALL_Z + 1].copy(),
            impulse=np.array(self.impulse),
            steps=np.array(self.steps),
        )

    def _make_room(self, packing: Packing, law: Law, room: Room, dt: float, threads: int) -> None:
        """Make the arrays for a packing, without forces."""
        self.law, self.room, self.dt, self.threads = law, room, dt, threads
        n = packing.radius.size
        self._grains = _grains(packing)
        self._old_grains = _grains(packing)
        largest = float(packing.radius.max(initial=0.0))
        smallest = float(packing.radius.min(initial=math.inf))
        # A large grain among small ones has as many neighbours as fit around it.
        per_grain = math.ceil(ROOM_FOR * (largest / smallest) ** 2) if n else 1
        rolls = law.pair_rolling > 0.0 or law.wall_rolling > 0.0
        self._lists = _lists(n, per_grain, rolls)
        self._old_lists = _lists(n, per_grain, rolls)
        room_for_ghosts = n * per_grain
        self._ghosts = Ghosts(np.empty(room_for_ghosts, np.int32), np.empty((room_for_ghosts, 6)))
        self._grid = _grid(n, largest, smallest, room)
        self._sums = np.zeros((SLABS, SUMS))
        self._totals = np.zeros(TOTALS)
        self.impulse, self.steps = 0.0, 0
        self._elastic = np.zeros(4)

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return self.steps * self.dt

    @property
    def grains(self) -> int:
        """Number of grains."""
        return self._grains.ident.size

    @property
    def mass(self) -> float:
        """Mass of the grains, kg."""
        return float(np.sum(1.0 / self._grains.motion[:, 6]))

    @property
    def rebuilds(self) -> int:
        """Number of times that the neighbour lists were made."""
        return int(self._totals[REBUILDS])

    def packing(self) -> Packing:
        """Return the grains as they are, in the order of their numbers; velocities half a step
        ago.
        """
        return _packing(self._grains)

    def advance(self, velocity: Floats) -> Stretch:
        """Follow a motion of the box over `velocity.size - 1` steps.

        velocity : of the box along its axis half a step before and after each step, m/s
        Raises LostGrains if the grains cannot be followed.
        """
        steps = velocity.size - 1
        impulse = np.empty(steps + 1)
        impulse[0] = self.impulse
        self._totals[WORK_OF_BOX] = 0.0
        self._sums[:, :4] = 0.0
        self._run(velocity, impulse)
        self._check()
        self.impulse = float(impulse[-1])
        self.steps += steps
        work = self._sums[0, :4] + self._sums[1, :4]
        stored = elastic(self._grains, self._lists, self.law, self.room)
        loss = -work - (stored - self._elastic)
        self._elastic = stored
        column = WALL_X + self.room.axis
        return Stretch(
            impulse=impulse,
            force=float(self._sums[0, column] + self._sums[1, column]),
            work=float(self._totals[WORK_OF_BOX]),
            loss=loss,
            energy=self.energy(float(velocity[-1])),
        )

    def energy(self, before: float) -> Floats:
        """Return the energy of the grains: kinetic (laboratory), rotational, weight, elastic, J.

        before : velocity of the box half a step ago, m/s
        """
        moving = energies(self._grains, self.room, before, self.dt)
        return np.append(moving, self._elastic.sum())

    def _check(self) -> None:
        if self._totals[FAULT]:
            raise LostGrains(
                "more neighbours than the lists have room for"
                if self._totals[FAULT] == LISTS_FULL
                else "a grain left the box or is not a number: the step is too long"
            )

    def _run(self, velocity: Floats, impulse: Floats) -> None:
        flags = new_flags(self.threads)

        def run(thread: int) -> None:
            advance(
                thread,
                self.threads,
                flags,
                self._grains,
                self._lists,
                self._ghosts,
                self._old_grains,
                self._old_lists,
                self._grid,
                self.law,
                self.room,
                velocity,
                self.dt,
                self._sums,
                self._totals,
                impulse,
            )

        others = [threading.Thread(target=run, args=(k,)) for k in range(1, self.threads)]
        for other in others:
            other.start()
        run(0)
        for other in others:
            other.join()


def _packing(grains: GrainArrays) -> Packing:
    """Return the grains in the order of their numbers."""
    order = np.argsort(grains.ident)
    place, motion = grains.place[order], grains.motion[order]
    return Packing(
        place[:, :3].copy(),
        place[:, 3].copy(),
        1.0 / motion[:, 6],
        motion[:, :3].copy(),
        motion[:, 3:6].copy(),
        grains.cavity[order].copy(),
    )


def _grains(packing: Packing) -> GrainArrays:
    n = packing.radius.size
    motion = np.empty((n, 8))
    motion[:, :3], motion[:, 3:6] = packing.velocity, packing.spin
    motion[:, 6] = 1.0 / packing.mass
    motion[:, 7] = 1.0 / (0.4 * packing.mass * packing.radius**2)
    return GrainArrays(
        np.column_stack((packing.place, packing.radius)),
        motion,
        np.zeros((n, 8)),
        np.arange(n, dtype=np.int32),
        packing.cavity.astype(np.int32),
    )


def _lists(n: int, per_grain: int, rolls: bool) -> Lists:
    pairs, entries = n * per_grain, 4 * n
    return Lists(
        first=np.zeros(n + 1, np.int32),
        other=np.empty(pairs, np.int32),
        touching=np.empty(pairs, np.uint8),
        memory=np.empty((pairs, 6)),
        rolling=np.empty((pairs if rolls else 0, 6)),
        wall_grain=np.empty(entries, np.int32),
        wall=np.empty(entries, np.uint8),
        wall_touching=np.empty(entries, np.uint8),
        wall_memory=np.empty((entries, 6)),
        wall_rolling=np.empty((entries if rolls else 0, 6)),
        made_at=np.zeros((n, 3)),
        sizes=np.zeros(4, np.int64),
    )


def _grid(n: int, largest: float, smallest: float, room: Room) -> Cells:
    reach = 2.0 * SKIN * smallest if n else 1.0
    cell = 2.0 * largest + reach if n else 1.0
    width = room.pitch * (room.cavities - 1) + room.width
    nx, ny, nz = (max(math.ceil(size / cell), 1) for size in (room.length, width, room.height))
    return Cells(
        reach,
        cell,
        nx,
        ny,
        nz,
        np.zeros(nx * ny * nz + 1, np.int32),
        np.zeros(n, np.int32),
        np.zeros(n, np.int32),
    )
