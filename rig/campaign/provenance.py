"""Where a session comes from: versions, seeds, platform, command line."""

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
    "NPY_DISABLE_CPU_FEATURES", "NPY_ENABLE_CPU_FEATURES", "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES", "NUMBA_NUM_THREADS",
    "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_CORETYPE",
)  # fmt: skip
"""Variables of the environment that choose instructions and threads."""


def now() -> str:
    """The time, ISO 8601 with zone."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def provenance(protocol_text: str, seed: int, rig_time: float) -> dict[str, Any]:
    """What a session states about its making; none of it goes into the report, so that equal runs give equal bytes."""
    return {
        **_making(),
        "protocol_sha256": hashlib.sha256(protocol_text.encode()).hexdigest(),
        "seed": seed,
        "seeds": "numpy SFC64 over SeedSequence(seed, SHA-256 of the stream's words); see docs/conventions.md",
        "rig_time_s": rig_time,
    }


def replay_provenance(speed: float | None) -> dict[str, Any]:
    """What a replayed session adds to the provenance of the one it was made from. speed: None for max."""
    return {**_making(), "speed": "max" if speed is None else speed}


def _making() -> dict[str, Any]:
    """When, by which command, on what."""
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
    """Return what of the processor the numbers hang on: kernels and numpy choose their instructions by it, and with
    them the order of sums (docs/conventions.md); and what the environment says of both."""
    binding: Any = importlib.import_module("llvmlite.binding")  # untyped; heavy
    features = binding.get_host_cpu_features()
    return {
        "name": binding.get_host_cpu_name(),
        "features": " ".join(sorted(name for name, there in features.items() if there)),
        "cores": str(os.cpu_count()),
        **{name: os.environ[name] for name in CHOSEN if name in os.environ},
    }


def version_of(name: str) -> str:
    """Version of an installed distribution, or that there is none."""
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def commit() -> str:
    """Commit of the source tree that runs, "" where it is not a checkout or git is not there."""
    tree = Path(__file__).resolve().parents[2]
    if not (tree / ".git").exists():
        return ""
    try:
        found = subprocess.run(
            ("git", "-C", str(tree), "rev-parse", "HEAD"), capture_output=True, text=True, timeout=5, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return found.stdout.strip()
