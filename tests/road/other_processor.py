"""What another kind of processor makes of the same seed: one protocol run twice, here and with
instructions left out.

    PYTHONPATH=. python tests/road/other_processor.py [PROTOCOL [--set PATH=VALUE ...]]

The second run has numpy without any of the instructions that it found beyond its baseline, and
kernels compiled for a plain x86-64. Prints how many codes differ, and the largest relative
difference of W_exp and W_T of a condition.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from daq.session.record import open_session

SHORT = ("fill_rate", "--set", "repeats.n=1")


def plain_processor() -> dict[str, str]:
    """Environment of a process that may use no more than the baseline."""
    show: Any = np.show_config  # its stubs know no mode
    found = show(mode="dicts")["SIMD Extensions"]["found"]
    return {
        "NPY_DISABLE_CPU_FEATURES": " ".join(found),
        "NUMBA_CPU_NAME": "x86-64",
        "NUMBA_CPU_FEATURES": "",
    }


def recorded(arguments: list[str], folder: Path, environment: dict[str, str]) -> Path:
    """Run a protocol into a folder. Raises CalledProcessError where nothing was recorded."""
    command = [
        sys.executable,
        "-c",
        "from rig.cli.app import main; main()",
        "run",
        *arguments,
        "--out",
        str(folder),
    ]
    done = subprocess.run(
        command, env={**os.environ, **environment}, capture_output=True, check=False
    )
    if not (folder / "report.json").exists():
        raise subprocess.CalledProcessError(done.returncode, command, done.stdout, done.stderr)
    return folder


def different_codes(one: Path, other: Path) -> tuple[int, int]:
    """How many codes of two sessions differ, and of how many."""
    different = total = 0
    with open_session(one / "session.h5") as a, open_session(other / "session.h5") as b:
        for run in a.runs:
            for channel in a.channels:
                left, right = a.codes(run.name, channel), b.codes(run.name, channel)
                different, total = (
                    different + int(np.count_nonzero(left != right)),
                    total + left.size,
                )
    return different, total


def largest(one: Path, other: Path, name: str) -> float:
    """Largest relative difference of a number between the conditions of two reports."""
    rows = [
        json.loads((folder / "report.json").read_text(encoding="utf-8"))["conditions"]
        for folder in (one, other)
    ]
    pairs = [(a[name], b[name]) for a, b in zip(*rows, strict=True) if a[name]]
    return float(max(abs(b / a - 1.0) for a, b in pairs))


def main(arguments: list[str]) -> None:
    """Run both and print what differs."""
    with tempfile.TemporaryDirectory() as name:
        elsewhere = plain_processor()
        here, there = (
            recorded(arguments, Path(name) / which, environment)
            for which, environment in (("here", {}), ("there", elsewhere))
        )
        different, total = different_codes(here, there)
        print(
            f"left out: {elsewhere['NPY_DISABLE_CPU_FEATURES']}; kernels for {elsewhere['NUMBA_CPU_NAME']}"
        )
        print(f"{different} of {total} codes differ")
        print(f"largest relative difference: W_exp {largest(here, there, 'W_exp'):.1e}, "
              f"W_T {largest(here, there, 'W_T'):.1e}")  # fmt: skip


if __name__ == "__main__":
    main(sys.argv[1:] or list(SHORT))
