"""Tasks computed by processes of this machine, which never see a file.

Processes, not threads: the work is many short array operations, which one interpreter lock would
serialise (docs/decisions/0002-worker-processes.md). They share nothing: a process that is killed
while it holds a lock, or in the middle of a message, would block the others for ever.
"""

import logging
import multiprocessing
import os
import queue
import signal
import sys
import threading
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import accumulate, islice
from multiprocessing.connection import Connection, wait
from typing import Any

from daq.chain.clock import Overrun
from daq.child_processes import killed_at_the_end
from rig.campaign.executor import Compute, Task
from rig.errors import InputError, WorkerFailed, WorkerLost

QUEUED = 256
"""Items that may wait in a worker for the writer: 32 MB with two channels."""

BEFOREHAND = 80
"""Most tasks that a worker gets when a stage starts, to keep it busy while the writer creates its
file.
"""

log = logging.getLogger(__name__)


class Processes:
    """Up to `count` worker processes, each with a pipe of its own."""

    def __init__(self, count: int) -> None:
        self._count = count

    @contextmanager
    def started(
        self, compute: Compute, stages: Sequence[Sequence[Task]]
    ) -> Iterator[Iterator[Any]]:
        """Start the workers, as described in `Executor`.

        To be called before a session file is opened: a forked worker shares all open files.
        """
        fork = sys.platform == "linux"
        context: Any = multiprocessing.get_context("fork" if fork else "spawn")
        tasks = [task for stage in stages for task in stage]
        count = min(self._count, len(tasks))
        # What is compiled is loaded here, once for all forked workers.
        for stage in stages if fork and count > 1 else ():
            if stage:
                next(compute(stage[0]))
        with killed_at_the_end() as (processes, pipes):
            for _ in range(count):
                here, there = context.Pipe()
                pipes.append(here)
                # A forked worker inherits the near ends of all pipes made so far. It closes them;
                # otherwise those workers would never notice the end of this process.
                inherited = tuple(pipes) if fork else ()
                process = context.Process(
                    target=_work, args=(compute, tasks, there, inherited), daemon=True
                )
                process.start()
                processes.append(process)
                there.close()  # held by the worker alone: its death closes the pipe
            hands = _Hands(tasks, [len(stage) for stage in stages], pipes)
            hands.begin()
            yield hands.received()


class _Hands:
    """Distributes tasks by their number, stage by stage, and collects the results."""

    def __init__(
        self, tasks: Sequence[Task], sizes: Sequence[int], pipes: Sequence[Connection]
    ) -> None:
        ends = list(accumulate(sizes))
        self._tasks = tasks
        self._stages = deque(range(end - size, end) for end, size in zip(ends, sizes, strict=True))
        self._given: dict[Connection, deque[int]] = {pipe: deque() for pipe in pipes}
        self._left: deque[int] = deque()
        self._known = [0] * len(tasks)

    def begin(self) -> None:
        """Start the next stage that has tasks, once the previous one is complete; give every worker
        several tasks.
        """
        while self._stages and not (self._left or any(self._given.values())):
            self._left.extend(self._stages.popleft())
            beforehand = (
                min(BEFOREHAND, len(self._left) // (2 * len(self._given))) if self._given else 0
            )
            for depth in range(1, max(beforehand, 1) + 1):
                self._give(depth)

    def received(self) -> Iterator[Any]:
        """Yield the results until no work is left.

        A pipe ends with its worker, even in the middle of a message; its tasks go to the other
        workers.
        """
        lost: set[int] = set()
        while self._left or any(self._given.values()):
            if not self._given:
                raise WorkerLost(_ended([self._tasks[number].name for number in sorted(lost)]))
            self._hand_out()
            ready = set(wait(list(self._given)))
            for pipe in [pipe for pipe in self._given if pipe in ready]:
                try:
                    item = pipe.recv()
                except (EOFError, OSError):
                    lost.update(self._lose(pipe))
                    continue
                if isinstance(item, BaseException):
                    raise item
                # A worker computes its tasks in order: the item belongs to the first one that has
                # not ended.
                number = self._given[pipe][0]
                self._known[number] += 1
                if item.ends:
                    self._given[pipe].popleft()
                    lost.discard(number)
                    self._hand_out()
                    self.begin()
                yield item

    def _lose(self, pipe: Connection) -> Sequence[int]:
        """Return the tasks of a lost worker to the queue.

        Which of them it was computing is unknown, because its unsent items are lost as well.
        """
        numbers = self._given.pop(pipe)
        self._left.extendleft(reversed(numbers))
        if numbers and self._given:
            names = ", ".join(self._tasks[number].name for number in numbers)
            log.warning("a worker was ended from outside; another one computes %s", names)
        return numbers

    def _hand_out(self) -> None:
        """Give every worker a task, and the next one in advance while more tasks are left than
        there are workers.

        Then no worker waits for the writer, and at the end no task waits behind another while a
        worker is idle.
        """
        for depth, kept in ((1, 0), (2, len(self._given))):
            self._give(depth, kept)

    def _give(self, depth: int, kept: int = 0) -> None:
        """Give a task to every worker that has fewer than `depth`, while more than
        `kept` are left.
        """
        for pipe, numbers in self._given.items():
            if len(numbers) < depth and len(self._left) > kept:
                numbers.append(self._left.popleft())
                with suppress(OSError):  # a worker that is gone: its pipe tells so when it is read
                    pipe.send((numbers[-1], self._known[numbers[-1]]))


def _ended(names: Sequence[str]) -> str:
    """Return the message for lost workers."""
    named = ", ".join(names[:8]) + (f" and {len(names) - 8} more" if len(names) > 8 else "")
    return (
        f"the workers were ended from outside, as for want of memory, at {named}; "
        "what was recorded is kept, rig run --resume goes on"
    )


def _work(
    compute: Compute, tasks: Sequence[Task], pipe: Connection, inherited: Sequence[Connection]
) -> None:
    """Run as one worker: compute the requested tasks until the pipe closes or the process is
    killed.
    """
    # An interrupt from the keyboard is the other side's to handle.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for end in inherited:
        end.close()
    asked: queue.SimpleQueue[tuple[int, int]] = queue.SimpleQueue()
    ready: queue.Queue[object] = queue.Queue(QUEUED)
    for source, sink in ((pipe.recv, asked.put), (ready.get, pipe.send)):
        threading.Thread(target=_relay, args=(source, sink), daemon=True).start()
    while True:
        number, known = asked.get()
        try:
            for item in islice(compute(tasks[number]), known, None):
                ready.put(item)
        except (InputError, MemoryError, Overrun) as error:
            ready.put(error)
        except Exception:  # noqa: BLE001  handed to the calling process, which raises it
            ready.put(WorkerFailed(traceback.format_exc()))


def _relay(source: Callable[[], Any], sink: Callable[[Any], object]) -> None:
    """Pass on items; end this process if that fails, as it does when the other side of the pipe is
    gone.
    """
    try:
        while True:
            sink(source())
    finally:
        os._exit(1)
