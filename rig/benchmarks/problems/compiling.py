"""The cost of compiling, once per installation, and the work after which it has paid: with an empty
and a full cache.
"""

import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from rig.benchmarks.machine import ROOT
from rig.benchmarks.process import as_users_have_it, timed_process

Row = dict[str, Any]

COMPILED = (
    "event-driven (ours)",
    "RK4, events located",
    "semi-implicit Euler",
    "Moreau time stepping",
)

FIRST_CALL = """
import sys, time
from rig.benchmarks.methods import METHODS
from rig.benchmarks.problems.sliders import single_mass, rough
method = next(one for one in METHODS if one.name == sys.argv[1])
start = time.perf_counter()
for problem in (rough(0.1, 1.3), single_mass(1.5)):
    method.solve(problem, method.ladder[0], 1, 1)
print(time.perf_counter() - start)
"""


def compiling(protocol: Path, fixed: tuple[str, ...]) -> list[Row]:
    """Measure the first call of every compiled method and the fill protocol, s, with an empty and a
    full cache.

    The difference is the compiling time; for the fill protocol it includes everything that the
    protocol calls.
    """
    rows = [_row(name, *(_first_calls(name))) for name in COMPILED]
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", "from rig.cli.app import main; main()", "run", str(protocol), *fixed, "--out",
                   f"{folder}/s", "--force", "--json"]  # fmt: skip
        environment = as_users_have_it(NUMBA_CACHE_DIR=f"{folder}/cache")
        cold, warm = (timed_process(command, ROOT, environment) for _ in range(2))
    return [*rows, _row("rig run, fill protocol", cold, warm)]


def _first_calls(name: str) -> tuple[float, float]:
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-c", FIRST_CALL, name]
        environment = as_users_have_it(NUMBA_CACHE_DIR=folder)
        cold, warm = (
            float(
                subprocess.run(
                    command, cwd=ROOT, check=True, capture_output=True, env=environment
                ).stdout
            )
            for _ in range(2)
        )
    return cold, warm


def _row(what: str, cold: float, warm: float) -> Row:
    return {"kind": "compiling", "problem": "compiling", "method": what, "first_s": cold, "later_s": warm,
            "compiling_s": max(cold - warm, 0.0), "failure": None}  # fmt: skip
