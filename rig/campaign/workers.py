"""Worker processes that compute runs and never see a file: parts of runs go through a bounded queue.

Processes and not threads: the work is many short array operations, which one interpreter lock would serialise
(docs/decisions/0002-worker-processes.md).
"""

import multiprocessing
import os
import queue
import sys
import threading
import time
import traceback
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

from daq.clock import Overrun, Pacer
from rig.campaign.recording import Part
from rig.campaign.setup import Campaign
from rig.errors import InputError
from rig.plan import Run

QUEUED_PARTS = 24
"""Parts of runs per worker that may wait for the writer."""

POLL = 0.5
"""Seconds between looks whether the other side still lives."""


class WorkerLost(Exception):
    """The worker processes were ended from outside."""


class WorkerFailed(RuntimeError):
    """A defect: the message holds the worker's traceback."""


@contextmanager
def workers(campaign: Campaign, waiting: Sequence[Run], count: int, speed: float | None) -> Iterator[Iterator[Part]]:
    """Start up to `count` workers on the waiting runs; gives their parts, each run's in order, and ends them after.

    Start them before a session file is opened: a forked worker shares what is open then. A worker's error is raised
    from the iteration.
    """
    context: Any = multiprocessing.get_context("fork" if sys.platform == "linux" else "spawn")
    ready = context.Queue(maxsize=QUEUED_PARTS * count)
    following = context.Value("q", 0)
    processes = [
        context.Process(target=_work, args=(campaign, waiting, following, ready, speed), daemon=True)
        for _ in range(min(count, len(waiting)))
    ]
    if len(processes) > 1:
        next(campaign.parts(waiting[0]))  # loads the compiled kernels once, for all forked workers
    for process in processes:
        process.start()
    try:
        yield _received(processes, ready)
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            process.join()


def _received(processes: Sequence[Any], ready: Any) -> Iterator[Part]:
    idle = 0
    while idle < len(processes):
        try:
            item = ready.get(timeout=POLL)
        except queue.Empty:
            if not any(process.is_alive() for process in processes) and ready.empty():
                raise WorkerLost("the workers were ended from outside; rig run --resume goes on") from None
            continue
        if isinstance(item, BaseException):
            raise item
        if item is None:
            idle += 1
        else:
            yield item


def _work(campaign: Campaign, waiting: Sequence[Run], following: Any, ready: Any, speed: float | None) -> None:
    """One worker: the next run in order, until none is left."""
    threading.Thread(target=_end_with_parent, daemon=True).start()
    try:
        while True:
            with following.get_lock():
                number = following.value
                following.value += 1
            if number >= len(waiting):
                break
            run = waiting[number]
            pacer = Pacer(campaign.lengths[run.condition.id].rate, speed)
            for part in campaign.parts(run):
                try:
                    pacer.wait(part.block.start + part.block.count)
                except Overrun:
                    _deliver(ready, part.late())
                    raise
                _deliver(ready, part.ended(pacer.punctuality))
        _deliver(ready, None)
    except KeyboardInterrupt:
        os._exit(1)
    except (InputError, Overrun) as error:
        _deliver(ready, error)
    except Exception:  # noqa: BLE001  handed to the calling process, which raises it
        _deliver(ready, WorkerFailed(traceback.format_exc()))


def _end_with_parent() -> None:
    """End this process soon after the one that started it has died: a queue that nobody reads holds it for ever."""
    parent = multiprocessing.parent_process()
    while parent is not None and parent.is_alive():
        time.sleep(POLL)
    os._exit(1)


def _deliver(ready: Any, item: Part | BaseException | None) -> None:
    """Wait for room."""
    ready.put(item)
