"""A sentence where a command compiles its loops: at the first use on a machine, and after a change."""

import sys
from contextlib import suppress
from typing import Any

from numba.core import event

__all__ = ["announce_compiling"]

SENTENCE = "compiling for this processor, once: half a minute to a minute"


def announce_compiling() -> None:
    """Say on standard error, once, when numba begins to compile; code that it finds compiled is no reason to."""
    event.register("numba:compile", _Once())  # type: ignore[no-untyped-call, unused-ignore]


class _Once(event.Listener):  # type: ignore[misc, unused-ignore]
    def __init__(self) -> None:
        self._said = False

    def on_start(self, event: Any) -> None:  # noqa: ARG002  numba calls it so
        """Print the sentence."""
        if not self._said:
            self._said = True
            with suppress(OSError, ValueError):  # nobody there to hear it
                print(SENTENCE, file=sys.stderr, flush=True)

    def on_end(self, event: Any) -> None:
        """Say nothing."""
