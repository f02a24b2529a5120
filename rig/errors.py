"""Invalid input: what was found, what is allowed, and where, for every mistake at once."""

from __future__ import annotations

from daq.documents.notes import Mistake, in_order, nearest, quote
from daq.strange_text import visible

__all__ = ["InputError", "Mistake", "WorkerFailed", "WorkerLost", "in_order", "nearest", "quote"]


class InputError(Exception):
    """Input that cannot be used. `mistakes` lists everything that is wrong with it; str() has one
    line for each.
    """

    def __init__(self, *mistakes: Mistake) -> None:
        super().__init__(*mistakes)
        self.mistakes: tuple[Mistake, ...] = mistakes

    def __str__(self) -> str:
        return "\n".join(visible(str(mistake)) for mistake in self.mistakes)


class WorkerLost(Exception):
    """All workers were terminated from outside; the message names the runs in progress."""


class WorkerFailed(RuntimeError):
    """A program defect: the message contains the worker's traceback."""
