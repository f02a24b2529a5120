"""Parallel reading of the runs of a session, for sessions of thousands of runs."""

import multiprocessing
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from typing import TYPE_CHECKING

from analysis.pipeline import energies_of
from analysis.results.run import RunEnergy
from daq.child_processes import killed_at_the_end

if TYPE_CHECKING:
    from daq.session.record import Record

__all__ = ["energies_by_processes", "useful"]

MANY = 400
"""Number of runs from which on processes pay for their start."""

BATCH = 32
"""Number of runs whose energies are sent in one message."""


def useful(record: "Record", count: int) -> int:
    """Return how many processes, up to `count`, shorten the reading of a session.

    1 for a session of few runs, for one that is being written, and without fork (Windows, macOS).
    """
    if record.live or sys.platform != "linux":
        return 1
    return max(1, min(count, sum(run.complete for run in record.runs) // (MANY // 2)))


def energies_by_processes(
    record: "Record", count: int, tolerate_gaps: bool = False
) -> dict[str, RunEnergy]:
    """Return the energies of a session's runs by name, read by `count` processes.

    They are meant for `read_session`. Missing are runs that cannot be used, and runs whose process
    ended early, as by a crash of the HDF5 library: `read_session` reads both again, and reports the
    fault. Empty where one process is enough (`useful`).
    """
    names = [run.name for run in record.runs if run.complete]
    count = useful(record, count)
    if count < 2:
        return {}
    # The first run loads the compiled loops once, for all processes that are forked.
    found = energies_of(record, names[:1], tolerate_gaps)
    context = multiprocessing.get_context("fork")
    record.close()  # each process opens it for itself
    with killed_at_the_end() as (processes, pipes):
        for first in range(count):
            here, there = context.Pipe(duplex=False)
            work = (record, names[1 + first :: count], tolerate_gaps, there)
            processes.append(context.Process(target=_work, args=work, daemon=True))
            processes[-1].start()
            there.close()  # only the process still holds it, so that its end closes the pipe
            pipes.append(here)
        record.reopen()
        for energies in _received(pipes):
            found |= energies
    return found


def _work(record: "Record", names: Sequence[str], tolerate_gaps: bool, pipe: Connection) -> None:
    """Read runs and send their energies, as one process. Errors end it silently: the caller meets
    them again.
    """
    from daq.session.plan import SessionError

    # An interrupt from the keyboard is for the caller to handle.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(SessionError, OSError, MemoryError):
        record.reopen()
        for first in range(0, len(names), BATCH):
            pipe.send(energies_of(record, names[first : first + BATCH], tolerate_gaps))


def _received(pipes: Sequence[Connection]) -> Iterator[dict[str, RunEnergy]]:
    """Yield the energies that the processes send, in the order of arrival, until all have ended."""
    left = list(pipes)
    while left:
        ready = set(wait(left))
        for pipe in [pipe for pipe in left if pipe in ready]:
            try:
                yield pipe.recv()
            except (EOFError, OSError):
                left.remove(pipe)
