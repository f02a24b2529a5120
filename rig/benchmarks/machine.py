"""The machine and software of a measurement, written as the first line of every output."""

import os
import platform
from pathlib import Path
from typing import Any

from rig.campaign.provenance import commit, now, version_of

PACKAGES = ("particle-damper-rig", "numpy", "scipy", "numba", "llvmlite", "h5py", "matplotlib")
ROOT = Path(__file__).resolve().parents[2]


def cores() -> int:
    """Return the number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def cpu() -> str:
    """Return the processor's name as the system states it."""
    listing = Path("/proc/cpuinfo")
    if listing.exists():
        for line in listing.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def header(quick: bool) -> dict[str, Any]:
    """Return machine, versions, commit (empty without a checkout) and the load at the start."""
    return {
        "kind": "machine",
        "quick": quick,
        "cpu": cpu(),
        "cores": cores(),
        "load": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
        "platform": platform.platform(),
        "python": platform.python_version(),
        "packages": {name: version_of(name) for name in PACKAGES},
        "git_commit": commit(),
        "created": now(),
    }
