"""Exports go piece by piece: memory does not grow with the record (of half an hour: test_memory.py)."""

import tracemalloc
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from analysis.corrected_signal import CorrectedSignal
from daq.formats.uff58 import write_uff58
from daq.formats.wave import CHUNK, RecordedSignal, Wave
from daq.formats.writing import write_csv

RATE = 10240.0
FEW = CHUNK + 4464  # samples, more than a piece; 0.56 MB a channel
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


def waves(size: int, corrected: bool) -> tuple[Wave, ...]:
    """Two channels, as recorded or with a pole and a delay undone."""
    recorded = RecordedSignal(Sine(size), "run", "force")  # type: ignore[arg-type]
    undone = CorrectedSignal(recorded.read, size, (512.0, size - 512.0), 1 / RATE, (2.0,), 1e-5)
    signal = undone if corrected else recorded
    return tuple(Wave(name, name, "N", signal, RATE, "", "+x") for name in ("force", "acceleration"))


def peak(to: str, size: int, corrected: bool, path: Path) -> int:
    tracemalloc.start()
    WRITERS[to](path, waves(size, corrected))
    found = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return found


@pytest.mark.parametrize("corrected", [False, True])
@pytest.mark.parametrize("to", sorted(WRITERS))
def test_a_longer_export_takes_no_more_memory(to: str, corrected: bool, tmp_path: Path) -> None:
    """Twice the samples are 0.56 MB more a channel where one is held whole; a tenth of that is for what Python keeps."""
    path = tmp_path / "export"
    peak(to, 4000, corrected, path)  # tables that are made once
    short, long = (peak(to, times * FEW, corrected, path) for times in (1, 2))
    assert long - short < 0.1 * 8 * FEW
