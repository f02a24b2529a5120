"""A running LAMMPS: started, asked, and ended with whoever asks."""

import contextlib
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from rig.kernels.grains.arrays import Room
from rig.kernels.grains.engine import LostGrains, Packing
from rig.lammps_engine.commands import LammpsCommands
from rig.lammps_engine.installed import launch
from rig.lammps_engine.messages import Message, packed, receive, send, unpacked

_PATIENCE = 10.0
"""Seconds that a process gets to end by itself."""


def opening(
    packing: Packing, room: Room, dt: float, given: LammpsCommands, file: str
) -> dict[str, Any]:
    """Return the message that gives LAMMPS its grains. given : the commands, which name `file`"""
    return {
        "do": "open",
        "before": given.before,
        "after": given.after,
        "output": file,
        "axis": room.axis,
        "dt": dt,
        "place": packing.place + given.shift,
        "velocity": packing.velocity,
        "spin": packing.spin,
        "radius": packing.radius,
        "mass": packing.mass,
        "inertia": 0.4 * packing.mass * packing.radius**2,
        "kind": packing.cavity + 1,
    }


class LammpsFailed(RuntimeError):
    """LAMMPS reported an error or ended; the message has its own words."""


class LammpsProcess:
    """LAMMPS on a number of MPI ranks, and a folder for what it writes."""

    def __init__(self, ranks: int) -> None:
        command, environment = launch(ranks)
        self._folder = tempfile.TemporaryDirectory(prefix="rig-lammps-")
        self._said = (Path(self._folder.name) / "said.txt").open("w+b")
        self._process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._said,
            env=environment,
            cwd=self._folder.name,
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._to, self._from = self._process.stdin, self._process.stdout
        self._words = ""

    def file(self, name: str) -> str:
        """Return the path of a file in the folder of this process."""
        return str(Path(self._folder.name) / name)

    def ask(self, message: Mapping[str, Any]) -> Message:
        """Return the answer to a message. Raises LammpsFailed, or LostGrains where grains left."""
        try:
            send(self._to, packed(message))
            answer = unpacked(receive(self._from))
        except (OSError, EOFError):
            self.close()
            raise LammpsFailed(f"LAMMPS ended: {self._last_words()}") from None
        if "error" in answer:
            error = str(answer["error"])
            self.close()
            if "Lost atoms" in error or "Non-numeric" in error:
                raise LostGrains(
                    "a grain left the box or is not a number: the step is too long"
                ) from None
            raise LammpsFailed(f"LAMMPS: {error}")
        return answer

    def close(self) -> None:
        """End the process; a second call does nothing."""
        if self._process.poll() is None:
            with contextlib.suppress(OSError):
                send(self._to, packed({"do": "end"}))
            try:
                self._process.wait(_PATIENCE)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        for pipe in (self._to, self._from):
            with contextlib.suppress(OSError):
                pipe.close()
        if not self._said.closed:
            self._words = self._read_words()
            self._said.close()
            self._folder.cleanup()

    def _last_words(self) -> str:
        return self._words or f"exit code {self._process.returncode}"

    def _read_words(self) -> str:
        self._said.seek(0)
        lines = self._said.read().decode(errors="replace").strip().splitlines()
        return lines[-1] if lines else ""

    def __enter__(self) -> "LammpsProcess":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
