"""Runs computed by processes of this machine, which never see a file.

Processes and not threads: the work is many short array operations, which one interpreter lock would serialise
(docs/decisions/0002-worker-processes.md). Nothing is shared between them: a process that is killed while it holds
a lock, or in the middle of a message, would hold up the others for ever.
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
from itertools import islice
from multiprocessing.connection import Connection, wait
from typing import Any

from daq.chain.clock import Overrun
from daq.child_processes import killed_at_the_end
from rig.campaign.campaign import Campaign
from rig.campaign.one_run.part import Part, paced
from rig.errors import InputError, WorkerFailed, WorkerLost
from rig.protocol.schedule import Run

QUEUED_PARTS = 256
"""Parts of runs that may wait in a worker for the writer: 8 MB of two channels."""

BEFOREHAND = 80
"""Most runs that a worker gets at the start, to have something to do while the writer predicts and makes its file."""

log = logging.getLogger(__name__)


class Processes:
    """Up to `count` worker processes, each with a pipe of its own."""

    def __init__(self, count: int) -> None:
        self._count = count

    @contextmanager
    def started(self, campaign: Campaign, waiting: Sequence[Run], speed: float | None) -> Iterator[Iterator[Part]]:
        """Start the workers, as `Executor` says.

        Start them before a session file is opened: a forked worker shares what is open then.
        """
        fork = sys.platform == "linux"
        context: Any = multiprocessing.get_context("fork" if fork else "spawn")
        count = min(self._count, len(waiting))
        if count > 1:
            next(campaign.parts(waiting[0]))  # loads the compiled kernels once, for all forked workers
        with killed_at_the_end() as (processes, pipes):
            for _ in range(count):
                here, there = context.Pipe()
                pipes.append(here)
                # a forked worker has the near ends of all pipes made so far: it closes them, or else those workers
                # would never see that this process is gone
                inherited = tuple(pipes) if fork else ()
                process = context.Process(target=_work, args=(campaign, waiting, speed, there, inherited), daemon=True)
                process.start()
                processes.append(process)
                there.close()  # held by the worker alone: its death closes the pipe
            given: dict[Connection, deque[int]] = {pipe: deque() for pipe in pipes}
            left = deque(range(len(waiting)))
            beforehand = min(BEFOREHAND, len(waiting) // (2 * count)) if count else 0
            for depth in range(1, max(beforehand, 1) + 1):
                _give(given, left, [0] * len(waiting), depth)
            yield _received(given, left, waiting)


def _received(given: dict[Connection, deque[int]], left: deque[int], waiting: Sequence[Run]) -> Iterator[Part]:
    """Hand out the runs by their number, those that are left, and give what comes back.

    A pipe ends with its worker, even in the middle of a message; what the worker had to do goes to the others.
    """
    known = [0] * len(waiting)
    lost: set[int] = set()
    while left or any(given.values()):
        if not given:
            raise WorkerLost(_ended([waiting[number].name for number in sorted(lost)]))
        _hand_out(given, left, known)
        ready = set(wait(list(given)))
        for pipe in [pipe for pipe in given if pipe in ready]:
            try:
                item = pipe.recv()
            except (EOFError, OSError):
                runs = given.pop(pipe)
                left.extendleft(reversed(runs))
                lost.update(runs)  # which of them it was at is not known: what it had not sent yet is gone with it
                if runs and given:
                    names = ", ".join(waiting[number].name for number in runs)
                    log.warning("a worker was ended from outside; another one computes %s", names)
                continue
            if isinstance(item, BaseException):
                raise item
            number = given[pipe][0]
            known[number] += 1
            if item.scalars is not None:
                given[pipe].popleft()
                lost.discard(number)
                _hand_out(given, left, known)
            yield item


def _hand_out(given: dict[Connection, deque[int]], left: deque[int], known: Sequence[int]) -> None:
    """Give every worker a run, and the next one beforehand while more are left than there are workers: none then waits
    for the writer, nor at the end one run for another while a worker is idle."""
    for depth, kept in ((1, 0), (2, len(given))):
        _give(given, left, known, depth, kept)


def _give(
    given: dict[Connection, deque[int]], left: deque[int], known: Sequence[int], depth: int, kept: int = 0
) -> None:
    """Give a run to every worker that has fewer than `depth`, while more than `kept` are left."""
    for pipe, runs in given.items():
        if len(runs) < depth and len(left) > kept:
            runs.append(left.popleft())
            with suppress(OSError):  # a worker that is gone: its pipe tells so when it is read
                pipe.send((runs[-1], known[runs[-1]]))


def _ended(runs: Sequence[str]) -> str:
    named = ", ".join(runs[:8]) + (f" and {len(runs) - 8} more" if len(runs) > 8 else "")
    return (
        f"the workers were ended from outside, as for want of memory, at {named}; "
        "what was recorded is kept, rig run --resume goes on"
    )


def _work(
    campaign: Campaign, waiting: Sequence[Run], speed: float | None, pipe: Connection, inherited: Sequence[Connection]
) -> None:
    """Be one worker: compute the runs that are asked for, until the pipe is closed or the process is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupt from the keyboard is the other side's to handle
    for end in inherited:
        end.close()
    asked: queue.SimpleQueue[tuple[int, int]] = queue.SimpleQueue()
    ready: queue.Queue[Part | BaseException] = queue.Queue(QUEUED_PARTS)
    for source, sink in ((pipe.recv, asked.put), (ready.get, pipe.send)):
        threading.Thread(target=_relay, args=(source, sink), daemon=True).start()
    while True:
        number, known = asked.get()
        try:
            run = waiting[number]
            parts = paced(campaign.parts(run), campaign.lengths[run.condition.id].rate, speed)
            for part in islice(parts, known, None):
                ready.put(part)
        except (InputError, MemoryError, Overrun) as error:
            ready.put(error)
        except Exception:  # noqa: BLE001  handed to the calling process, which raises it
            ready.put(WorkerFailed(traceback.format_exc()))


def _relay(source: Callable[[], Any], sink: Callable[[Any], object]) -> None:
    """Pass on what comes; end this process where that fails, as it does when the other side of the pipe is gone."""
    try:
        while True:
            sink(source())
    finally:
        os._exit(1)
