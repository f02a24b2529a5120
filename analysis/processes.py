"""The runs of a session read by several processes: for sessions of thousands of runs."""

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

__all__ = ["energies_by_processes"]

MANY = 400
"""Runs from which on processes are worth their start."""

BATCH = 32
"""Runs whose energies are sent in one message."""


def energies_by_processes(
    record: "Record", count: int, tolerate_gaps: bool = False
) -> dict[str, RunEnergy]:
    """Return the energies of a session's runs by name, read by `count` processes.

    They are for `read_session`. Runs that cannot be used have none, and neither have those whose
    process has ended before it came to them, as by a crash of the HDF5 library: `read_session`
    reads both, and says what is wrong. Empty for a session of few runs, for one that is being
    written, and without fork (Windows, macOS).
    """
    names = [run.name for run in record.runs if run.complete]
    count = min(count, len(names) // (MANY // 2))
    if count < 2 or record.live or sys.platform != "linux":
        return {}
    found = energies_of(
        record, names[:1], tolerate_gaps
    )  # loads the compiled loops once, for all processes
    context = multiprocessing.get_context("fork")
    record.close()  # each process opens it for itself
    with killed_at_the_end() as (processes, pipes):
        for first in range(count):
            here, there = context.Pipe(duplex=False)
            work = (record, names[1 + first :: count], tolerate_gaps, there)
            processes.append(context.Process(target=_work, args=work, daemon=True))
            processes[-1].start()
            there.close()  # held by the process alone: its end closes the pipe
            pipes.append(here)
        record.reopen()
        for energies in _received(pipes):
            found |= energies
    return found


def _work(record: "Record", names: Sequence[str], tolerate_gaps: bool, pipe: Connection) -> None:
    """Be one process. It says nothing of what goes wrong: the caller meets it again."""
    from daq.session.plan import SessionError

    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # an interrupt from the keyboard is the caller's to handle
    with suppress(SessionError, OSError, MemoryError):
        record.reopen()
        for first in range(0, len(names), BATCH):
            pipe.send(energies_of(record, names[first : first + BATCH], tolerate_gaps))


def _received(pipes: Sequence[Connection]) -> Iterator[dict[str, RunEnergy]]:
    """What comes from the processes, until all have ended; none waits for another."""
    left = list(pipes)
    while left:
        ready = set(wait(left))
        for pipe in [pipe for pipe in left if pipe in ready]:
            try:
                yield pipe.recv()
            except (EOFError, OSError):
                left.remove(pipe)
