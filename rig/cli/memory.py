"""What memory this process may use: a limit turns into a sentence before libraries hang or crash over it."""

import os
from collections.abc import Iterable
from pathlib import Path

LEAST = 1200 * 10**6
"""Bytes of address space below which the libraries do not load: some crash, and some wait for ever for a thread."""

ALWAYS = 4 * 2**30
"""Bytes that reading files of strangers may take, however small they are."""

TIMES = 40
"""Times their size that files of strangers may take beyond that: text of one digit a number, objects of JSON."""


def memory_limit() -> int | None:
    """Return the limit of this process's address space (ulimit -v) in bytes, None for none."""
    try:
        import resource
    except ImportError:  # Windows
        return None
    soft = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if soft == resource.RLIM_INFINITY else soft


def short_of_memory() -> str:
    """Return what to say where the address space is too small for the libraries, "" where it is not.

    Under any limit, linear algebra goes on in one thread: each takes tens of MB, and one that cannot start its
    threads interrupts the process.
    """
    limit = memory_limit()
    if limit is None:
        return ""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if limit >= LEAST:
        return ""
    return f"too little memory: this process may use {limit / 1e6:.0f} MB (ulimit -v), {LEAST / 1e6:.0f} MB are needed"


def limit_memory(files: Iterable[Path]) -> None:
    """Limit what this process may allocate to what files of their size can honestly need.

    Whatever a foreign file makes a library allocate then ends in a MemoryError, and not in a machine that swaps.
    """
    try:
        import resource
    except ImportError:  # Windows
        return
    wanted = ALWAYS + TIMES * sum(map(_size, files))
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    known = [value for value in (soft, hard) if value != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_DATA, (min([wanted, *known]), hard))


def _size(path: Path) -> int:
    """Return the bytes of a file, or of all files in a folder."""
    try:
        if path.is_dir():
            return sum(entry.stat().st_size for entry in os.scandir(path) if entry.is_file())
        return path.stat().st_size
    except OSError:
        return 0
