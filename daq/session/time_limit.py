"""A limit on the time that a call into a C library may take: nothing in Python can interrupt one."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["limited"]


@contextmanager
def limited(seconds: float | None) -> Iterator[None]:
    """End the process by SIGALRM where the block takes longer; no limit for None, or without such a signal (Windows).

    For the main thread of a process that its parent watches, one block at a time.
    """
    if seconds is None or not hasattr(signal, "setitimer"):
        yield
        return
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
