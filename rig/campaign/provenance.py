"""Origin of a session: versions, seeds, platform, command line."""

import hashlib
import importlib
import os
import platform
import subprocess
import sys
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from daq.strange_text import visible

PACKAGES = ("particle-damper-rig", "numpy", "scipy", "numba", "h5py")
CHOSEN = (
    "NPY_DISABLE_CPU_FEATURES",
    "NPY_ENABLE_CPU_FEATURES",
    "NUMBA_CPU_NAME",
    "NUMBA_CPU_FEATURES",
    "NUMBA_NUM_THREADS",
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "OPENBLAS_CORETYPE",
)
"""Environment variables that select instruction sets and threads."""


def now() -> str:
    """Return the time, ISO 8601 with zone."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def provenance(protocol_text: str, seed: int, rig_time: float) -> dict[str, Any]:
    """Return the provenance of a session. It does not enter the report, so that equal runs give
    equal bytes.
    """
    return {
        **_making(),
        "protocol_sha256": hashlib.sha256(protocol_text.encode()).hexdigest(),
        "seed": seed,
        "seeds": "numpy SFC64 over SeedSequence(seed, SHA-256 of the stream's words); see docs/conventions.md",
        "rig_time_s": rig_time,
    }


def replay_provenance(speed: float | None) -> dict[str, Any]:
    """Return the addition of a replay to the provenance of the original session. speed : None for
    maximum.
    """
    return {**_making(), "speed": "max" if speed is None else speed}


def _making() -> dict[str, Any]:
    """Return time, command and platform."""
    return {
        "created": now(),
        "command": visible(" ".join(sys.argv)),
        "platform": platform.platform(),
        "python": platform.python_version(),
        "cpu": cpu(),
        "packages": {name: version_of(name) for name in PACKAGES},
        "git_commit": commit(),
    }


def cpu() -> dict[str, str]:
    """Return the processor properties and environment variables on which the numbers depend.

    Kernels and numpy select instructions by them, and thereby the order of sums
    (docs/conventions.md).
    """
    binding: Any = importlib.import_module("llvmlite.binding")  # untyped; heavy
    features = binding.get_host_cpu_features()
    return {
        "name": binding.get_host_cpu_name(),
        "features": " ".join(sorted(name for name, there in features.items() if there)),
        "cores": str(os.cpu_count()),
        **{name: os.environ[name] for name in CHOSEN if name in os.environ},
    }


def version_of(name: str) -> str:
    """Return the version of an installed distribution, or "not installed"."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def commit() -> str:
    """Return the commit of the running source tree, "" if it is not a checkout or git
    is missing.
    """
    tree = Path(__file__).resolve().parents[2]
    if not (tree / ".git").exists():
        return ""
    try:
        found = subprocess.run(
            ("git", "-C", str(tree), "rev-parse", "HEAD"),
            capture_output=True,
            text=True,
            timeout=5,
            check=False,
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return found.stdout.strip()
