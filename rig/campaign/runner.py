"""The main job: conditions on workers, recorded by one writer, analysed from the record, resumable.

The calling thread writes the results of the workers and analyses each run as soon as it is
recorded, so that memory does not grow with the length of a record and nothing depends on the number
of workers.
"""

import importlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import islice, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

from daq.whole_files import mark_unfinished
from rig.campaign.campaign import Campaign
from rig.campaign.executor import Executor
from rig.campaign.one_run.assemble import assemble
from rig.campaign.one_run.part import Part, paced
from rig.campaign.one_run.recorder import Watch, record_parts
from rig.campaign.resolve import campaign_of
from rig.campaign.workers import Processes
from rig.catalog.rig_file import load_rig
from rig.errors import InputError, Mistake, WorkerLost
from rig.prediction.forecast import Forecast, forecast
from rig.protocol.load import dump_protocol
from rig.protocol.schedule import Run
from rig.protocol.spec import Condition, Protocol

if TYPE_CHECKING:
    from analysis.results.report import Report
    from rig.campaign.one_run.live import LiveUpdate

AT_THE_END = ("analysis.comparison.whole_session", "analysis.report.html")
"""Modules that are needed when the workers have finished, loaded beforehand while they are busy."""

OLD_SESSION = (
    "a session of the first edition (before 0.2.0), whose protocol has other names",
    "--force to start anew, or another folder; rig report reads what is recorded in it",
)
"""What --resume finds in such a session, and what is allowed instead."""


@dataclass(frozen=True)
class ToPredict:
    """The task of predicting a condition."""

    condition: Condition

    @property
    def name(self) -> str:
        """The id of the condition."""
        return self.condition.id


def computed(
    campaign: Campaign, speed: float | None, task: ToPredict | Run
) -> Iterator[Forecast | Part]:
    """Compute a task: the forecast of a condition, or the parts of a run.

    speed : rig seconds per wall second (None: as fast as possible)

    Raises InputError, MemoryError, and Overrun after the part that came too late.
    """
    if isinstance(task, ToPredict):
        condition, refill = task.condition, campaign.protocol.repeats.refill
        yield forecast(condition, campaign.rig, refill, campaign.averaged.get(condition.id))
    else:
        yield from paced(assemble(campaign, task), campaign.lengths[task.condition.id].rate, speed)


def run(
    campaign: Campaign | Protocol,
    out: Path | str,
    workers: int = 2,
    speed: float | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: Watch = lambda _: None,
    live: "Callable[[LiveUpdate], None] | None" = None,
    executor: Executor | None = None,
) -> "Report":
    """Run a campaign, or a protocol with its own rig, into `out`/session.h5 and write its report
    there; returns the report.

    speed : rig seconds per wall second (None: as fast as possible); a paced campaign runs one run
        after the other
    progress : called after every run; live : called after every block
    executor : where runs are computed, instead of in `workers` processes of this machine:
        predictions first, then runs; the processes work while the session file is built
    """
    if isinstance(campaign, Protocol):
        campaign = campaign_of(campaign, load_rig(campaign.rig), dump_protocol(campaign))
    out = Path(out)
    path = out / "session.h5"
    resume = resume and path.exists()
    finished = _finished(campaign, path) if resume else set()
    waiting = sorted(
        (run for run in campaign.runs if run.name not in finished), key=lambda run: run.order
    )
    to_predict = [] if resume else [ToPredict(condition) for condition in campaign.conditions]
    executor = executor or Processes(workers if speed is None else 1)
    with executor.started(partial(computed, campaign, speed), (to_predict, waiting)) as items:
        from analysis.pipeline import read_session
        from analysis.report.files import write_report
        from daq.session.writer import Recorder
        from rig.campaign.session_plan import session_plan

        for name in AT_THE_END:
            importlib.import_module(name)

        if resume:
            recorder = Recorder.resume(path)
        else:
            found = _predicted(items, len(to_predict))
            plan = session_plan(campaign, found)
            out.mkdir(parents=True, exist_ok=True)
            recorder = Recorder.create(path, plan, overwrite)
        if (out / "report.json").exists():
            # A report of an earlier record.
            mark_unfinished(out)
        with recorder:
            energies = record_parts(recorder, items, progress, live)
            report = read_session(recorder.record(), energies)
    write_report(report, out)
    return report


def _predicted(items: Iterator[Any], count: int) -> dict[str, Forecast]:
    """Return the forecasts by condition. Raises WorkerLost if they do not all come."""
    try:
        return {one.condition: one for one in islice(items, count)}
    except WorkerLost as lost:
        told = str(lost).partition(";")[0]
        raise WorkerLost(f"{told}; nothing was recorded yet, run it again") from lost


def _finished(campaign: Campaign, path: Path) -> set[str]:
    """Return the names of the complete runs of a session.

    Raises InputError if it is not a session of this very campaign, or was recorded by the first
    edition: its run plan, written with other names, cannot be continued.
    """
    from analysis.session.former_names import of_first_edition
    from daq.session.record import open_session
    from rig.campaign.session_plan import identity

    asked = identity(campaign)
    with open_session(path) as record:
        found = {name: record.document(name) or {} for name in asked}
        if of_first_edition(str(found["protocol"].get("resolved", ""))):
            raise InputError(Mistake(str(path), "", *OLD_SESSION))
        for name, facts in asked.items():
            for key, value in facts.items():
                if found[name].get(key) != value:
                    raise InputError(_differs(path, f"{name} {key}", found[name].get(key), value))
        return {run.name for run in record.runs if run.complete}


def _differs(path: Path, what: str, old: object, new: object) -> Mistake:
    """Return the first line in which the session and the requested campaign differ."""
    pairs = zip_longest(str(old).splitlines(), str(new).splitlines(), fillvalue="nothing")
    before, after = next(((a, b) for a, b in pairs if a != b), ("", ""))
    return Mistake(
        str(path),
        what,
        f"a session recorded with {before.strip()!r}, asked to continue with {after.strip()!r}",
        "the protocol, seed and rig that it was started with, or --force to start anew",
    )
