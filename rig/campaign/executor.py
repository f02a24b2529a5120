"""Where the tasks of a campaign are computed: the one interface, whatever computes them."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from typing import Any, Protocol


class Task(Protocol):
    """Something to compute; `name` stands in messages."""

    @property
    def name(self) -> str:
        """A word for it."""
        ...


class Item(Protocol):
    """Something that a task gives."""

    @property
    def ends(self) -> bool:
        """Whether it is the last of its task."""
        ...


Compute = Callable[[Any], Iterator[Any]]
"""From a task to its items, the same whenever and wherever it is called: a function that can be pickled."""


class Executor(Protocol):
    """Computes tasks somewhere: in processes of this machine (`rig.campaign.workers`), or on other machines.

    tests/conformance/test_executors.py holds every implementation to what follows.
    """

    def started(self, compute: Compute, stages: Sequence[Sequence[Task]]) -> AbstractContextManager[Iterator[Any]]:
        """Start on the tasks, in their order; give their items, and end all work after the block.

        No task of a stage is begun before all items of the stage before have come. Every item comes once, each task's
        in order; the tasks of a stage may come interleaved. A task whose worker is lost is computed again and goes on
        after the item that came last: it is the same task, to the byte. Raised from the iteration: what `compute`
        raises, as it was raised; WorkerLost where nothing is left that computes; WorkerFailed for a defect. Nothing
        that is lost is waited for.
        """
        ...
