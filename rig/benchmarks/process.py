"""Time and peak memory of whole processes, measured from outside."""

import os
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

EVERY = 0.02
"""Seconds between readings of a process's memory: the system keeps the peak, so only the last
reading must be late.
"""

RIG = "import sys; sys.argv = ['rig', *sys.argv[1:]]; from rig.cli.app import main; main()"

LISTED = """
import sys
sys.argv = ["rig", *sys.argv[1:]]
from rig.cli.app import main
try:
    main()
finally:
    print("imported", *sorted(sys.modules), file=sys.stderr)
"""

IMPORTS = """
import importlib, sys
for name in sys.argv[1:]:
    try:
        importlib.import_module(name)
    except ImportError:
        pass  # made by another module, not imported by its name
with open("/proc/self/status", encoding="ascii", errors="replace") as status:
    print(next(line.split()[1] for line in status if line.startswith("VmHWM")))
"""


def as_users_have_it(**more: str) -> dict[str, str]:
    """Return an environment in which Python may keep compiled modules, as by default."""
    kept = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return {**kept, **more}


def timed_process(
    command: Sequence[str], folder: Path, environment: Mapping[str, str] | None = None
) -> float:
    """Return the wall seconds of one process. Raises CalledProcessError where it fails."""
    environment = as_users_have_it() if environment is None else environment
    start = time.perf_counter()
    subprocess.run(command, cwd=folder, check=True, capture_output=True, env=environment)
    return time.perf_counter() - start


def imported_by(arguments: Sequence[str], folder: Path) -> tuple[str, ...]:
    """Return the modules that a `rig` command has imported. Raises CalledProcessError."""
    command = [sys.executable, "-c", LISTED, *arguments]
    done = subprocess.run(
        command, cwd=folder, check=True, capture_output=True, text=True, env=as_users_have_it()
    )
    return tuple(done.stderr.rpartition("imported")[2].split())


def weighed_imports(modules: Sequence[str], folder: Path) -> float:
    """Return the peak memory, MB, of an interpreter that imports modules and does nothing else
    (Linux).

    The interpreter reads its own peak at its end: one that lives for milliseconds may end before
    anyone outside has looked twice. Raises OSError, CalledProcessError.
    """
    command = [sys.executable, "-c", IMPORTS, *modules]
    done = subprocess.run(
        command, cwd=folder, check=True, capture_output=True, text=True, env=as_users_have_it()
    )
    return int(done.stdout.split()[-1]) / 1024.0


def run_process(arguments: Sequence[str], folder: Path) -> tuple[float, float]:
    """Return the peak memory, MB, of a `rig` command and of its largest worker. See `weighed`."""
    return weighed([sys.executable, "-c", RIG, *arguments], folder)


def weighed(command: Sequence[str], folder: Path) -> tuple[float, float]:
    """Return the peak resident memory, MB, of a process and of its largest child, from /proc
    (Linux).

    `getrusage` is not used: the peak of a new process begins with that of its parent. Raises
    OSError, CalledProcessError.
    """
    own = largest = 0.0
    with subprocess.Popen(
        command,
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=as_users_have_it(),
    ) as process:
        while process.poll() is None:
            own = max(own, _peak(process.pid))
            largest = max(largest, *map(_peak, _children(process.pid)), 0.0)
            time.sleep(EVERY)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    return own, largest


def _peak(pid: int) -> float:
    """Return the peak resident memory of a process, MB; 0 where it has ended."""
    try:
        status = Path(f"/proc/{pid}/status").read_text(encoding="ascii", errors="replace")
    except (FileNotFoundError, ProcessLookupError):
        return 0.0
    lines = (line.split() for line in status.splitlines() if line.startswith("VmHWM"))
    return next((int(fields[1]) / 1024.0 for fields in lines), 0.0)


def _children(pid: int) -> tuple[int, ...]:
    """Return the processes started by a process's first thread."""
    try:
        return tuple(
            map(int, Path(f"/proc/{pid}/task/{pid}/children").read_text(encoding="ascii").split())
        )
    except (FileNotFoundError, ProcessLookupError):
        return ()
