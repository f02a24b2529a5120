"""The interface of executors, which compute the tasks of a campaign."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from typing import Any, Protocol


class Task(Protocol):
    """A unit of work; messages use its `name`."""

    @property
    def name(self) -> str:
        """A short name."""
        ...


class Item(Protocol):
    """A result of a task."""

    @property
    def ends(self) -> bool:
        """Whether it is the last of its task."""
        ...


Compute = Callable[[Any], Iterator[Any]]
"""A function from a task to its items, the same at any time and place; it can be pickled."""


class Executor(Protocol):
    """Computes tasks somewhere: in processes of this machine (`rig.campaign.workers`), or on other
    machines.

    tests/conformance/test_executors.py tests every implementation against this description.
    """

    def started(
        self, compute: Compute, stages: Sequence[Sequence[Task]]
    ) -> AbstractContextManager[Iterator[Any]]:
        """Start the tasks, in their order; give an iterator of their items, and end all work after
        the block.

        No task of a stage starts before all items of the previous stage have arrived. Every item
        arrives once, each task's in order; tasks of a stage may be interleaved. A task whose worker
        is lost is computed again and continues after the last item received: same task, same bytes.
        The iterator never waits for lost work: it raises WorkerLost if no worker is left. InputError,
        MemoryError and Overrun of `compute` are raised unchanged; any other exception of it is a
        defect, and raised as WorkerFailed with its traceback.
        """
        ...
