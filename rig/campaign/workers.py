"""Workers that compute runs and never see a file: parts of runs through a bounded queue, whatever their number."""

import queue
import threading
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

from daq.clock import Pacer
from rig.campaign.setup import Campaign, Part
from rig.plan import Run

QUEUED_PARTS = 4
"""Parts of runs per worker that may wait for the writer."""


def computed(campaign: Campaign, waiting: list[Run], workers: int, speed: float | None) -> Iterator[Part]:
    """Parts of runs as workers deliver them; each run's parts in order. An error of a worker is raised here."""
    todo: queue.SimpleQueue[Run] = queue.SimpleQueue()
    for run in waiting:
        todo.put(run)
    ready: queue.Queue[Part | BaseException | None] = queue.Queue(maxsize=QUEUED_PARTS * workers)
    stop = threading.Event()

    def deliver(item: Part | BaseException | None) -> None:
        while not stop.is_set():
            with suppress(queue.Full):
                ready.put(item, timeout=0.1)
                return

    def work() -> None:
        try:
            while not stop.is_set():
                run = todo.get_nowait()
                pacer = Pacer(campaign.lengths[run.condition.id].rate, speed)
                for part in campaign.parts(run):
                    pacer.wait(part.block.start + part.block.count)
                    deliver(part)
                    if stop.is_set():
                        return
        except queue.Empty:
            deliver(None)
        except BaseException as error:  # noqa: BLE001  handed to the calling thread, which raises it
            deliver(error)

    with ThreadPoolExecutor(workers, "rig") as pool:
        try:
            for _ in range(workers):
                pool.submit(work)
            idle = 0
            while idle < workers:
                item = ready.get()
                if isinstance(item, BaseException):
                    raise item
                if item is None:
                    idle += 1
                else:
                    yield item
        finally:
            stop.set()
