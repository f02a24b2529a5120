"""Work on many items that do not depend on each other, done here or shared out among processes."""

import multiprocessing
import signal
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from multiprocessing.connection import Connection
from typing import Any, Protocol, TypeVar

from daq.child_processes import killed_at_the_end

__all__ = ["ForEach", "both", "here", "shared_by"]

A = TypeVar("A")
B = TypeVar("B")


class ForEach(Protocol):
    """A way to apply a function to every item of a sequence."""

    def __call__(self, function: Callable[[A], B], items: Sequence[A], /) -> list[B]:
        """Return the values of the function, in the order of the items."""
        ...


def here(function: Callable[[A], B], items: Sequence[A], /) -> list[B]:
    """Return the values of a function, in the order of the items, computed in this process."""
    return [function(item) for item in items]


def both(each: ForEach, first: Callable[[], A], second: Callable[[], B]) -> tuple[A, B]:
    """Return the values of two functions. Where processes share them the second is another
    process's, which sends its value.
    """
    functions: tuple[Callable[[], Any], ...] = (first, second)
    one, other = each(_called, functions)
    return one, other


def _called(function: Callable[[], A]) -> A:
    return function()


def shared_by(count: int) -> ForEach:
    """Return a way to apply a function in this process and in `count - 1` that are forked from it.

    Only values are sent between them, not items. What a process that ended early did not compute,
    as one that was killed or met an error, is computed here: so errors are raised here, too. Needs
    fork, and a process without threads.
    """
    return partial(_shared, count) if count > 1 else here


def _shared(count: int, function: Callable[[A], B], items: Sequence[A], /) -> list[B]:
    """Return the values of a function, in the order of the items, computed by `count` processes:
    every `count`-th item by the same one, because neighbours take alike long.
    """
    context = multiprocessing.get_context("fork")
    values: dict[int, list[B]] = {}
    with killed_at_the_end() as (processes, pipes):
        for first in range(1, min(count, len(items))):
            here_end, there = context.Pipe(duplex=False)
            work = (function, items[first::count], there)
            processes.append(context.Process(target=_work, args=work, daemon=True))
            processes[-1].start()
            there.close()  # only the process still holds it, so that its end closes the pipe
            pipes.append(here_end)
        values[0] = here(function, items[::count])
        for first, pipe in enumerate(pipes, 1):
            with suppress(EOFError, OSError):
                values[first] = pipe.recv()
    for first in range(count):
        if first not in values:
            values[first] = here(function, items[first::count])
    return [values[place % count][place // count] for place in range(len(items))]


def _work(function: Callable[[A], B], items: Sequence[A], pipe: Connection) -> None:
    """Send the values of a function, as one process. Errors end it silently: the caller meets them
    again.
    """
    # An interrupt from the keyboard is for the caller to handle.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(Exception):
        pipe.send(here(function, items))
