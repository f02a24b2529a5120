"""From parts of runs to a session: written by one writer, each run analysed as soon as it is
recorded.

File access and analysis are imported on demand: a process that computes parts needs neither, and a
campaign starts its workers before it loads them.
"""

from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING

from daq.chain.clock import NEVER_LATE, Punctuality
from rig.campaign.one_run.part import Part

if TYPE_CHECKING:
    from analysis.pipeline import SignalOf
    from analysis.results.run import RunEnergy
    from daq.session.record import Record
    from daq.session.writer import Recorder
    from rig.campaign.one_run.live import LiveUpdate


@dataclass(frozen=True)
class Progress:
    """A run that has been recorded and analysed, the `done`-th of `total`; energy : None if it
    cannot be analysed.
    """

    run: str
    condition: str
    energy: "RunEnergy | None"
    done: int
    total: int
    punctuality: Punctuality = NEVER_LATE


Watch = Callable[[Progress], None]


class Analysis:
    """Energies of a record's runs, each computed as soon as the run is complete. Unusable runs have
    none.

    done : number of runs that were complete before
    """

    def __init__(self, record: "Record", watch: Watch, done: int) -> None:
        self._record = record
        self._watch = watch
        self._runs = record.runs
        self._done = done
        self.energies: dict[str, RunEnergy] = {}

    def add(self, part: Part) -> None:
        """Analyse and report a complete run, given its last part."""
        self.read(part.run)
        self.tell(part)

    def read(self, name: str, signal: "SignalOf | None" = None) -> None:
        """Compute a run's energies; signal : source of its samples, if not the record."""
        from analysis.pipeline import run_energy
        from analysis.session.record import AnalysisError

        with suppress(AnalysisError):  # read_session lists it with the reason
            self.energies[name] = run_energy(self._record, self._record.run(name), signal=signal)

    def tell(self, part: Part) -> None:
        """Report a run that has been read, given its last part."""
        self._done += 1
        name, total = part.run, len(self._runs)
        condition, energy = self._record.run(name).condition, self.energies.get(name)
        self._watch(Progress(name, condition, energy, self._done, total, part.punctuality))


def record_parts(
    recorder: "Recorder",
    parts: Iterable[Part],
    watch: Watch,
    live: "Callable[[LiveUpdate], None] | None" = None,
) -> "dict[str, RunEnergy]":
    """Write parts, each run's in order, and return the energies by run name, as read back from the
    record.

    watch : called after every run; live : called after every block
    """
    from rig.campaign.one_run.live import Watcher

    cycles: dict[str, int] = {}
    watcher = None if live is None else Watcher(recorder.record(), live)
    reader = Analysis(recorder.record(), watch, len(recorder.completed()))
    for part in parts:
        recorder.append(part.run, part.block)
        if watcher is not None:
            watcher.hear(part.run, part.block)
        if part.ledger.size:
            first = cycles.get(part.run, 0)
            recorder.write_ledger(part.run, first, part.ledger)
            cycles[part.run] = first + len(part.ledger)
        if part.scalars is not None:
            recorder.finish(part.run, part.scalars, part.flags)
            reader.add(part)
    return reader.energies
