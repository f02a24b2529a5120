"""Speed of the main job and its parts, each beside what it is compared with: `make bench`, or with --json lines.

Whole processes, started here, timed from outside; medians and the spread of several runs. Absolute times are this
machine's; the ratios are what to quote.
"""

import argparse
import json
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
RIG = [sys.executable, "-c", "from rig.cli import main; main()"]
BARE = "import typer\napp = typer.Typer()\n@app.command()\ndef a(): 'One.'\n@app.command()\ndef b(): 'Two.'\napp()\n"
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


def timed(command: list[str]) -> float:
    """Wall seconds of one process, which has to succeed."""
    start = time.perf_counter()
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    return time.perf_counter() - start


def spread(values: list[float]) -> dict[str, float]:
    """Median, least and largest."""
    return {"median": statistics.median(values), "min": min(values), "max": max(values)}


def main_job(repeats: int) -> dict[str, Any]:
    """The shipped fill-rate protocol, process start and report included, against the rig time that it simulates."""
    with tempfile.TemporaryDirectory() as folder:
        command = [*RIG, "run", "protocols/fill_rate.yaml", "--out", f"{folder}/s", "--force", "--json"]
        timed(command)
        walls = [timed(command) for _ in range(repeats)]
    rig_time = 10 * 4 * 4 * 50 / 20.0
    return {"name": "fill_rate, whole process", "wall_s": spread(walls), "rig_time_s": rig_time,
            "times_faster": rig_time / statistics.median(walls)}  # fmt: skip


def help_text(repeats: int) -> dict[str, Any]:
    """`rig --help` against the help of a bare Typer program, in turn."""
    bare = [sys.executable, "-c", BARE, "--help"]
    ours = [*RIG, "--help"]
    timed(ours), timed(bare)
    pairs = [(timed(ours), timed(bare)) for _ in range(3 * repeats)]
    ratios = [a / b for a, b in pairs]
    return {"name": "rig --help over bare Typer", "wall_s": spread([a for a, _ in pairs]), "ratio": spread(ratios)}


def model(repeats: int) -> list[dict[str, Any]]:
    """`rig model` per condition: time in a warm process, and error against rows averaged over 4096 cycles."""
    from rig.catalog import load_rig
    from rig.model import predict
    from rig.protocol import load_protocol

    rig = load_rig("default")
    rows = []
    for a in (1.0, 2.0, 3.0, 4.0, 5.0, 6.0):
        condition = load_protocol("schema: rig/protocol/1\nname: x\n", sets=[f"drive.acceleration={a}"]).conditions()[0]
        predict(condition, rig)
        walls = []
        for _ in range(3 * repeats):
            start = time.perf_counter()
            found = predict(condition, rig)
            walls.append(1e3 * (time.perf_counter() - start))
        exact = predict(condition, rig, 4096).W_T
        rows.append({"name": f"closed tier, 4 mm, 85 %, {a:g} m/s2", "wall_ms": spread(walls),
                     "error": found.W_T / exact - 1})  # fmt: skip
    return rows


def huge_bed(repeats: int) -> dict[str, Any]:
    """A box ten times as large with 1 mm grains (1e10 of them) against the standard bed: cost follows rows."""
    from rig.catalog import load_rig
    from rig.model import predict
    from rig.protocol import load_protocol

    rig = load_rig("default")
    text = "schema: rig/protocol/1\nname: x\n"
    big = ["scene.cavity={length: 1.5, width: 1.5, height: 4, wall: 0.05}", "scene.grains.diameter=1 mm"]
    conditions = [load_protocol(text, sets=sets).conditions()[0] for sets in ([], big)]
    walls = []
    for condition in conditions:
        predict(condition, rig)
        times = []
        for _ in range(repeats):
            start = time.perf_counter()
            predict(condition, rig)
            times.append(time.perf_counter() - start)
        walls.append(statistics.median(times))
    layers = [predict(condition, rig).layers for condition in conditions]
    ratios = {"time_ratio": walls[1] / walls[0], "layer_ratio": layers[1] / layers[0]}
    return {"name": "1e10 grains over 1.4e5 grains", **ratios}


def memory() -> dict[str, Any]:
    """Peak memory of `rig run` and of its workers for records of 40 and of 4000 cycles."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for cycles in (40, 4000):
            command = [sys.executable, "-c", MEMORY, "run", "protocols/fill_rate.yaml", "--out", f"{folder}/{cycles}",
                       "--set", "vary={}", "--set", f"acquire.record={cycles} cycles", "--json"]  # fmt: skip
            done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
            writer, worker = done.stderr.rpartition("peak")[2].split()
            found[cycles] = {"writer_MB": float(writer), "worker_MB": float(worker)}
    return {"name": "peak memory, 40 and 4000 cycles", "peak": found}


def main() -> None:
    """Print a JSON line per measurement."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    repeats = parser.parse_args().repeats
    print(json.dumps({"machine": platform.platform(), "python": platform.python_version(), "cores": len_cores()}))
    rows = [help_text(repeats), main_job(repeats), *model(repeats), huge_bed(repeats), memory()]
    for row in rows:
        print(json.dumps(row))


def len_cores() -> int:
    """Processors that this process may use."""
    import os

    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


if __name__ == "__main__":
    main()
