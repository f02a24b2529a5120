"""`rig replay`: a recorded session once more, over the road of `rig run`."""

from collections import Counter
from pathlib import Path

from analysis.session.setting import Setting
from daq.session.record import Record
from rig.campaign.replayer import replay
from rig.cli.commands.run import check_folder
from rig.cli.commands.sessions import session_file
from rig.cli.terminal.live import Line, live_view, timing
from rig.cli.terminal.output import print_json, print_result
from rig.cli.terminal.tables import print_report, terminal
from rig.cli.terminal.watch import PATIENCE, open_watched
from rig.errors import InputError, Mistake


def replay_session(session: Path, out: Path | None, speed: float | None, force: bool, as_json: bool) -> int:
    """`rig replay`: 0 where the verdict passes, 1 where it does not."""
    path = session_file(session)
    if out is not None:
        if (out / "session.h5").exists() and path.exists() and (out / "session.h5").samefile(path):
            raise InputError(Mistake("--out", "", f"{out}, where the session itself lies", "another folder"))
        check_folder(out, resume=False, force=force)
    with open_watched(path) as record:
        lines = lines_of_record(record)
    with live_view(lines, terminal(stderr=True, quiet=as_json)) as view:
        report = replay(path, out, speed, force, view.step, PATIENCE, view.look if view.looks else None)
    if timing(view):
        terminal(stderr=True, quiet=as_json).print(timing(view))
    if as_json:
        print_json(report.document())
    elif out is None:
        print_report(terminal(), report)
    else:
        print_result(report, out)
    return 0 if report.passes else 1


def lines_of_record(record: Record) -> dict[str, Line]:
    """The conditions of a session."""
    runs = Counter(run.condition for run in record.runs)
    return {
        key: Line(setting.bed, setting.fill, setting.diameter, setting.acceleration_set, runs[key])
        for key, setting in ((key, Setting.of(condition)) for key, condition in record.conditions.items())
    }
