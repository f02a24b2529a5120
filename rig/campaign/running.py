"""The main job: conditions on workers, recorded by one writer, analysed from the record, resumed.

The calling thread writes what the workers compute and analyses each run as soon as it is recorded, so that memory does
not grow with the length of a record and nothing depends on the number of workers.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from analysis import RunEnergy, read_session, run_energy, write_report
from daq.session import Recorder
from rig.campaign.session import session_plan
from rig.campaign.setup import Campaign
from rig.campaign.workers import computed
from rig.plan import Run


@dataclass(frozen=True)
class Progress:
    """A run has been recorded and analysed, `done` of `total`."""

    run: Run
    done: int
    total: int
    energy: RunEnergy


def execute(
    campaign: Campaign,
    recorder: Recorder,
    workers: int,
    speed: float | None = None,
    progress: Callable[[Progress], None] = lambda _: None,
) -> dict[str, RunEnergy]:
    """Run everything that the recorder has not got yet; energies by run name, as read back from the record.

    `speed` is rig seconds per wall second (None: as fast as possible); a paced campaign runs one run after the other.
    """
    finished = recorder.completed()
    waiting = sorted((run for run in campaign.runs if run.name not in finished), key=lambda run: run.order)
    energies: dict[str, RunEnergy] = {}
    cycles: dict[str, int] = {}
    record = recorder.record()
    for part in computed(campaign, waiting, workers if speed is None else 1, speed):
        name = part.run.name
        recorder.append(name, part.block)
        acquire = part.run.condition.acquire
        first = cycles.get(name, 0)
        wanted = part.ledger[: max(acquire.settle + acquire.record - first, 0)]
        recorder.write_ledger(name, first, wanted)
        cycles[name] = first + len(wanted)
        if part.demand is not None:
            recorder.finish(name, part.demand.scalars())
            energies[name] = run_energy(record, name)
            done = len(finished) + len(energies)
            progress(Progress(part.run, done, len(campaign.runs), energies[name]))
    return energies


def run(
    campaign: Campaign,
    out: Path,
    workers: int = 2,
    speed: float | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: Callable[[Progress], None] = lambda _: None,
) -> dict[str, Any]:
    """The main job: run a campaign into `out`/session.h5 and write its report there; returns the report."""
    path = out / "session.h5"
    if resume and path.exists():
        recorder = Recorder.resume(path)
    else:
        plan = session_plan(campaign, workers)
        out.mkdir(parents=True, exist_ok=True)
        recorder = Recorder.create(path, plan, overwrite)
    with recorder:
        energies = execute(campaign, recorder, workers, speed, progress)
        report = read_session(recorder.record(), energies)
    write_report(report, out)
    return report
