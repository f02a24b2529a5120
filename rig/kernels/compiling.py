"""Notification of compilation, which happens at the first use on a machine and after a change."""

from collections.abc import Callable
from typing import Any

from numba.core import event

__all__ = ["tell_of_compiling"]


def tell_of_compiling(tell: Callable[[], None]) -> None:
    """Call `tell` once, when numba starts to compile; loading cached code does not count."""
    event.register("numba:compile", _Once(tell))  # type: ignore[no-untyped-call, unused-ignore]


class _Once(event.Listener):  # type: ignore[misc, unused-ignore]
    def __init__(self, tell: Callable[[], None]) -> None:
        self._tell = tell
        self._told = False

    def on_start(self, event: Any) -> None:  # noqa: ARG002  numba calls it so
        """Call the listener, the first time only."""
        if not self._told:
            self._told = True
            self._tell()

    def on_end(self, event: Any) -> None:
        """Do nothing."""
