"""Grains in a box on LAMMPS, advanced stretch by stretch as our own engine."""

from __future__ import annotations

from dataclasses import dataclass
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from rig.kernels.grains.arrays import Law, Room
from rig.kernels.grains.engine import LostGrains, Packing, Stretch
from rig.lammps_engine.account import Snapshot, energies
from rig.lammps_engine.commands import commands
from rig.lammps_engine.process import LammpsProcess, opening
from rig.lammps_engine.wall_test import try_walls

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LammpsStretch(Stretch):
    """What a stretch of the motion gave. LAMMPS does not tell losses by kind: `loss` is not a
    number there.

    lost : work of the box less what it raised and the change of energy, J; what the tangential
        springs hold counts as lost
    """

    lost: float


class LammpsEngine:
    """Grains in a box that moves as it is told, moved by LAMMPS on a number of MPI ranks.

    As `rig.kernels.grains.engine.Engine`, in another process: `close` it, or use it in `with`.
    Forces are summed in another order on another number of ranks: last bits differ.
    """

    def __init__(self, packing: Packing, law: Law, room: Room, dt: float, ranks: int = 1) -> None:
        """Start LAMMPS, try its walls, and give it the grains.

        Raises InputError where LAMMPS is not installed, its walls fail, or it does not have what
        the scene asks for; LammpsFailed where it reports an error.
        """
        self.law, self.room, self.dt, self.ranks = law, room, dt, ranks
        self.impulse = 0.0
        self._packing = packing
        self._process = LammpsProcess(ranks)
        try:
            try_walls(
                self._process,
                law,
                float(packing.radius.max(initial=0.0)),
                float(packing.mass.max(initial=0.0)),
                dt,
            )
            file = self._process.file("force.txt")
            given = commands(packing, law, room, dt, file)
            self._shift = given.shift
            self._process.ask(opening(packing, room, dt, given, file))
            self._now = self._snapshot()
        except BaseException:
            self._process.close()
            raise
        self._force = float(np.sum(self._now.force[:, room.axis])) - self._weight

    @property
    def grains(self) -> int:
        """Number of grains."""
        return self._packing.radius.size

    @property
    def mass(self) -> float:
        """Mass of the grains, kg."""
        return float(np.sum(self._packing.mass))

    def packing(self) -> Packing:
        """Return the grains as they are, in the order of their numbers; velocities half a step
        ago.
        """
        return self._now.grains

    def advance(self, velocity: Floats) -> LammpsStretch:
        """Follow a motion of the box over `velocity.size - 1` steps.

        velocity : of the box along its axis half a step before and after each step, m/s
        Raises LostGrains if the grains cannot be followed, LammpsFailed if LAMMPS cannot go on.
        """
        kicks = np.diff(velocity) / self.dt
        start = self._energy(float(velocity[0]))
        answer = self._process.ask({"do": "advance", "kicks": kicks})
        weight = self._weight
        # LAMMPS sums all forces: those of the walls are what is left without weight and kick.
        walls = answer["force"] - weight
        walls[:-1] += self.mass * kicks[1:]
        force = np.append(self._force, walls)
        self._now = self._snapshot()
        self._force = float(force[-1])
        impulse = self.impulse + np.append(0.0, np.cumsum(self.dt * force[:-1]))
        self.impulse = float(impulse[-1])
        after = velocity[1:] + np.append(0.0, velocity[1:-1])
        work = 0.5 * self.dt * float(force[:-1] @ after + force[-1] * velocity[-1])
        energy = self._energy(float(velocity[-1]))
        # Weight is counted from the box, which itself was raised.
        raised = -weight * self.dt * float(np.sum(velocity[1:]))
        return LammpsStretch(
            impulse=impulse,
            force=self._force,
            work=work,
            loss=np.full(4, np.nan),
            energy=energy,
            lost=work - raised - float(np.sum(energy - start)),
        )

    def energy(self, before: float) -> Floats:
        """Return the energy of the grains: kinetic (laboratory), rotational, weight, elastic, J,
        the last without that of the tangential springs.

        before : velocity of the box half a step ago, m/s
        """
        return self._energy(before)

    def close(self) -> None:
        """End LAMMPS; a second call does nothing."""
        self._process.close()

    def __enter__(self) -> LammpsEngine:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def _weight(self) -> float:
        """Weight of all grains along the axis, N."""
        room = self.room
        gravity = (room.gravity_x, room.gravity_y, room.gravity_z)
        return self.mass * gravity[room.axis]

    def _energy(self, before: float) -> Floats:
        return energies(self._now, self.law, self.room, before, self.dt)

    def _snapshot(self) -> Snapshot:
        """Return the grains; velocities of LAMMPS are those of the whole step."""
        found, given = self._process.ask({"do": "state"}), self._packing
        if not np.all(np.isfinite(found["x"])):
            raise LostGrains("a grain is not a number: the step is too long")
        inertia = 0.4 * given.mass * given.radius**2
        grains = Packing(
            found["x"] - self._shift,
            given.radius,
            given.mass,
            found["v"] - 0.5 * self.dt * found["f"] / given.mass[:, None],
            found["omega"] - 0.5 * self.dt * found["torque"] / inertia[:, None],
            given.cavity,
        )
        return Snapshot(grains, found["f"], found["torque"])
