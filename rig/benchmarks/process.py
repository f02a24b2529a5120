"""Whole processes, timed and weighed from outside."""

import subprocess
import sys
import time
from collections.abc import Sequence
from pathlib import Path

MEMORY = """
import resource, sys
sys.argv = ["rig", *sys.argv[1:]]
from rig.cli import main
try:
    main()
finally:
    peak = [resource.getrusage(who).ru_maxrss / 1024 for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    print("peak", *peak, file=sys.stderr)
"""


def timed_process(command: Sequence[str], folder: Path) -> float:
    """Wall seconds of one process, which has to succeed. Raises CalledProcessError."""
    start = time.perf_counter()
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return time.perf_counter() - start


def run_process(arguments: Sequence[str], folder: Path) -> tuple[float, float]:
    """Peak memory of a `rig` command and of its largest worker, MB. Raises CalledProcessError."""
    command = [sys.executable, "-c", MEMORY, *arguments]
    done = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    own, children = done.stderr.rpartition("peak")[2].split()
    return float(own), float(children)
