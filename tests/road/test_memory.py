"""Memory does not grow with the length of a record."""

import subprocess
import sys
from pathlib import Path

import pytest

PEAK = """
import resource, sys
sys.argv = ["rig", *sys.argv[1:]]
from rig.cli.app import main
try:
    main()
finally:
    peaks = [resource.getrusage(who).ru_maxrss / 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    print("peak", *peaks, file=sys.stderr)
"""


def peak_megabytes(protocol: Path, out: Path, cycles: int, *sets: str) -> list[float]:
    """Peak memory of the writer and of its largest worker."""
    words = [
        "run",
        str(protocol),
        "--out",
        str(out),
        "--json",
        "--set",
        "vary={}",
        "--set",
        f"acquire.record={cycles}",
    ]
    words += [word for one in sets for word in ("--set", one)]
    done = subprocess.run(
        [sys.executable, "-c", PEAK, *words], capture_output=True, text=True, check=True
    )
    return [float(word) for word in done.stderr.rpartition("peak")[2].split()]


def test_a_long_record_takes_no_more_memory(small: Path, tmp_path: Path) -> None:
    """1500 cycles are 12 MB of volts per channel and run, 100 MB oversampled: held anywhere whole,
    they would show. 8 MB allow for the allocator: full blocks of 16384 samples on their way,
    against a few thousand in a short run."""
    short, long = (peak_megabytes(small, tmp_path / str(n), n) for n in (40, 1500))
    for before, after in zip(short, long, strict=True):
        assert after - before < 8.0


@pytest.mark.slow
def test_a_hundred_minutes_take_no_more_than_one(small: Path, tmp_path: Path) -> None:
    """Writer, worker, analysis and report; 120 000 cycles at 20 Hz, a file of half a gigabyte."""
    one, hundred = (
        peak_megabytes(small, tmp_path / str(n), 1200 * n, "repeats=1") for n in (1, 100)
    )
    for before, after in zip(one, hundred, strict=True):
        assert after - before < 5.0


def exported_megabytes(protocol: Path, folder: Path, cycles: int, to: str) -> float:
    """Peak memory of an export of one run of `cycles` cycles."""
    peak_megabytes(protocol, folder, cycles, "repeats=1")
    words = [
        "export",
        str(folder),
        "--to",
        to,
        "--run",
        "1",
        "--out",
        str(folder / "exported"),
        "--json",
    ]
    done = subprocess.run(
        [sys.executable, "-c", PEAK, *words], capture_output=True, text=True, check=True
    )
    return max(float(word) for word in done.stderr.rpartition("peak")[2].split())


@pytest.mark.slow
@pytest.mark.parametrize("to", ["csv", "uff58"])
def test_the_export_of_half_an_hour_takes_no_more_than_of_a_minute(
    small: Path, tmp_path: Path, to: str
) -> None:
    """36 000 cycles: 150 MB of a channel's volts, half a gigabyte of text. Fast twin:
    test_export_pieces.py.
    """
    minute, half_hour = (
        exported_megabytes(small, tmp_path / str(n), 1200 * n, to) for n in (1, 30)
    )
    assert half_hour - minute < 8.0
