"""Exports go piece by piece: memory does not grow with the record (of half an hour:
test_memory.py).
"""

import os
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.signals.corrected_signal import CorrectedSignal
from daq.formats.uff58 import write_uff58
from daq.formats.wave import CHUNK, RecordedSignal, Wave
from daq.formats.writing import write_csv

RATE = 10240.0
FEW = 2 * CHUNK  # samples; 1 MB a channel
WRITERS: dict[str, Callable[[Path, tuple[Wave, ...]], object]] = {
    "csv": write_csv,
    "uff58": lambda path, waves: write_uff58(path, "title", waves, []),
}


class Sine:
    """A record of a sine that is made when it is read, in whatever pieces."""

    def __init__(self, size: int) -> None:
        self._size = size

    def run(self, _run: str) -> Any:
        return SimpleNamespace(samples=self._size)

    def signal(self, _run: str, _name: str, start: int, stop: int) -> Any:
        return SimpleNamespace(samples=np.sin(2 * np.pi * 20.0 / RATE * np.arange(start, stop)))


def waves(size: int) -> tuple[Wave, ...]:
    """Two channels with a pole and a delay undone, which reads them several times over."""
    recorded = RecordedSignal(Sine(size), "run", "force")  # type: ignore[arg-type]
    signal = CorrectedSignal(recorded.read, size, (512.0, size - 512.0), 1 / RATE, (2.0,), 1e-5)
    return tuple(
        Wave(name, name, "N", signal, RATE, "", "+x") for name in ("force", "acceleration")
    )


def peak(to: str, size: int, path: Path) -> float:
    """Memory in bytes that the writing of an export adds at its peak, in a process of its own."""
    here, there = os.pipe()
    child = os.fork()
    if not child:
        WRITERS[to](path, waves(4000))  # tables that are made once
        Path("/proc/self/clear_refs").write_text("5")  # the peak starts anew
        before = resident()
        WRITERS[to](path, waves(size))
        os.write(there, str(resident() - before).encode())
        os._exit(0)
    assert os.waitpid(child, 0)[1] == 0
    os.close(there)
    with os.fdopen(here) as told:
        return float(told.read())


def resident() -> int:
    """Peak resident memory of this process, bytes."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


@pytest.mark.skipif(not os.path.exists("/proc/self/clear_refs"), reason="looks into /proc")
@pytest.mark.parametrize("to", sorted(WRITERS))
def test_a_longer_export_takes_no_more_memory(to: str, tmp_path: Path) -> None:
    """Where one channel is held whole, four times the samples are 24 FEW bytes more, 3 MB. Half of
    that is for the allocator, which keeps a piece (0.5 MB) or two, however many go by."""
    short, long = (peak(to, times * FEW, tmp_path / "export") for times in (1, 4))
    assert long - short < 0.5 * 24 * FEW
