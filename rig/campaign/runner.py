"""The main job: conditions on workers, recorded by one writer, analysed from the record, resumed.

The calling thread writes what the workers compute and analyses each run as soon as it is recorded, so that memory does
not grow with the length of a record and nothing depends on the number of workers.
"""

import importlib
from collections.abc import Callable
from functools import partial
from itertools import islice, zip_longest
from pathlib import Path
from typing import TYPE_CHECKING

from daq.whole_files import mark_unfinished
from rig.campaign.campaign import Campaign
from rig.campaign.executor import Executor
from rig.campaign.one_run.recorder import Watch, record_parts
from rig.campaign.resolve import campaign_of
from rig.campaign.tasks import ToPredict, computed
from rig.campaign.workers import Processes
from rig.catalog.rig_file import load_rig
from rig.errors import InputError, Mistake
from rig.protocol.load import dump_protocol
from rig.protocol.spec import Protocol

if TYPE_CHECKING:
    from analysis.results.report import Report
    from rig.campaign.one_run.live import Look

AT_THE_END = ("analysis.comparison.whole_session", "analysis.report.html")
"""Modules that are needed when the workers have nothing left to do, and so are loaded before."""


def run(
    campaign: Campaign | Protocol,
    out: Path | str,
    workers: int = 2,
    speed: float | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: Watch = lambda _: None,
    look: "Callable[[Look], None] | None" = None,
    executor: Executor | None = None,
) -> "Report":
    """The main job: run a campaign, or a protocol with its own rig, into `out`/session.h5 and write its report there;
    returns the report.

    `speed` is rig seconds per wall second (None: as fast as possible); a paced campaign runs one run after the other.
    `progress` is told of every run, `look` of every block. `executor`: where the runs are computed, instead of in
    `workers` processes of this machine: predictions, then runs; it is at work while the session file is built.
    """
    if isinstance(campaign, Protocol):
        campaign = campaign_of(campaign, load_rig(campaign.rig), dump_protocol(campaign))
    out = Path(out)
    path = out / "session.h5"
    resume = resume and path.exists()
    finished = _finished(campaign, path) if resume else set()
    waiting = sorted((run for run in campaign.runs if run.name not in finished), key=lambda run: run.order)
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
            found = {one.condition: one for one in islice(items, len(to_predict))}
            plan = session_plan(campaign, found)
            out.mkdir(parents=True, exist_ok=True)
            recorder = Recorder.create(path, plan, overwrite)
        if (out / "report.json").exists():  # of what was recorded before
            mark_unfinished(out)
        with recorder:
            energies = record_parts(recorder, items, progress, look)
            report = read_session(recorder.record(), energies)
    write_report(report, out)
    return report


def _finished(campaign: Campaign, path: Path) -> set[str]:
    """Names of the runs that a session has got. Raises InputError where it is not a session of this very campaign."""
    from daq.session.record import open_session
    from rig.campaign.session_plan import identity

    asked = identity(campaign)
    with open_session(path) as record:
        found = {name: record.document(name) or {} for name in asked}
        for name, facts in asked.items():
            for key, value in facts.items():
                if found[name].get(key) != value:
                    raise InputError(_differs(path, f"{name} {key}", found[name].get(key), value))
        return {run.name for run in record.runs if run.complete}


def _differs(path: Path, what: str, old: object, new: object) -> Mistake:
    """The first line in which the session and what was asked for part."""
    pairs = zip_longest(str(old).splitlines(), str(new).splitlines(), fillvalue="nothing")
    before, after = next(((a, b) for a, b in pairs if a != b), ("", ""))
    return Mistake(
        str(path),
        what,
        f"a session recorded with {before.strip()!r}, asked to go on with {after.strip()!r}",
        "the protocol, seed and rig that it was started with, or --force to start anew",
    )
