"""A time limit for a call into a C library, which nothing in Python can interrupt."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ["limited"]


@contextmanager
def limited(seconds: float | None) -> Iterator[None]:
    """End the process by SIGALRM where the block takes longer than `seconds`; None, or a system
    without SIGALRM: no limit.

    For the main thread of a process watched by its parent; limits do not nest.
    """
    if seconds is None or not hasattr(signal, "setitimer"):
        yield
        return
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
