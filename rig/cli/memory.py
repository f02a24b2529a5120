"""The memory that this process may use: a limit gives a clear message before libraries hang or
crash.
"""

import os
from collections.abc import Iterable
from pathlib import Path

LEAST = 1200 * 10**6
"""Bytes of address space below which the libraries do not load: some crash, others wait for ever
for a thread.
"""

ALWAYS = 4 * 2**30
"""Bytes that reading a stranger's files may take, however small they are."""

TIMES = 40
"""Multiple of the files' size that reading may take beyond that: text with one digit per number,
JSON objects.
"""


def memory_limit() -> int | None:
    """Return the limit of this process's address space (ulimit -v) in bytes, None where there is
    none.
    """
    try:
        import resource
    except ImportError:  # Windows
        return None
    soft = resource.getrlimit(resource.RLIMIT_AS)[0]
    return None if soft == resource.RLIM_INFINITY else soft


def short_of_memory() -> str:
    """Return a message where the address space is too small for the libraries, "" where it
    suffices.

    Under any limit, linear algebra is set to one thread: each takes tens of MB, and a library that
    cannot start its threads interrupts the process.
    """
    limit = memory_limit()
    if limit is None:
        return ""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if limit >= LEAST:
        return ""
    return f"too little memory: this process may use {limit / 1e6:.0f} MB (ulimit -v), {LEAST / 1e6:.0f} MB are needed"


def limit_memory(files: Iterable[Path]) -> None:
    """Limit this process's allocations to the amount that valid files of this size can need.

    An absurd allocation caused by a foreign file then raises MemoryError instead of making the
    machine swap.
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
