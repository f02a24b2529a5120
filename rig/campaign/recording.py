"""From parts of runs to a session: written by one writer, each run analysed as soon as it is recorded."""

from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis import AnalysisError, RunEnergy, run_energy
from daq.block import Block
from daq.session import Record, Recorder


@dataclass(frozen=True)
class Part:
    """A block of a run, with the ledger rows that belong to it; the last of a run brings its scalars and flags."""

    run: str
    block: Block
    ledger: NDArray[np.float64]
    scalars: Mapping[str, float] | None = None
    flags: int = 0


@dataclass(frozen=True)
class Progress:
    """A run has been recorded, `done` of `total`, and analysed; energy: None where it cannot be analysed."""

    run: str
    condition: str
    energy: RunEnergy | None
    done: int
    total: int


Watch = Callable[[Progress], None]


class Analysis:
    """Energies of a record's runs, each found as soon as it is complete. Runs that cannot be used have none.

    done: runs that were complete before.
    """

    def __init__(self, record: Record, watch: Watch, done: int) -> None:
        self._record = record
        self._watch = watch
        self._runs = record.runs
        self._done = done
        self.energies: dict[str, RunEnergy] = {}

    def add(self, name: str) -> None:
        """A run is complete."""
        run = self._record.run(name)
        with suppress(AnalysisError):  # read_session lists it with the reason
            self.energies[name] = run_energy(self._record, run)
        self._done += 1
        self._watch(Progress(name, run.condition, self.energies.get(name), self._done, len(self._runs)))


def record_parts(recorder: Recorder, parts: Iterable[Part], watch: Watch) -> dict[str, RunEnergy]:
    """Write parts, each run's in order; energies by run name, as read back from the record."""
    cycles: dict[str, int] = {}
    analysis = Analysis(recorder.record(), watch, len(recorder.completed()))
    for part in parts:
        recorder.append(part.run, part.block)
        if part.ledger.size:
            first = cycles.get(part.run, 0)
            recorder.write_ledger(part.run, first, part.ledger)
            cycles[part.run] = first + len(part.ledger)
        if part.scalars is not None:
            recorder.finish(part.run, part.scalars, part.flags)
            analysis.add(part.run)
    return analysis.energies
