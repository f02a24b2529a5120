"""`rig replay`: feed a recorded session through recorder, analysis and report again."""

from collections import Counter
from pathlib import Path

from analysis.session.setting import Setting
from daq.session.record import Record
from rig.campaign.replayer import replay
from rig.cli.commands.run import check_folder
from rig.cli.commands.sessions import session_file
from rig.cli.terminal.live import ConditionLine, live_view, timing
from rig.cli.terminal.output import print_json, print_result
from rig.cli.terminal.tables import print_report, terminal
from rig.cli.terminal.watch import PATIENCE, open_watched
from rig.errors import InputError, Mistake


def replay_session(
    session: Path, out: Path | None, speed: float | None, force: bool, as_json: bool
) -> int:
    """Replay a session; return the exit code 0 where the verdict passes, 1 where it does not."""
    path = session_file(session)
    if out is not None:
        if (out / "session.h5").exists() and path.exists() and (out / "session.h5").samefile(path):
            raise InputError(
                Mistake("--out", "", f"{out}, where the session itself lies", "another folder")
            )
        check_folder(out, resume=False, force=force)
    with open_watched(path) as record:
        lines = lines_of_record(record)
    with live_view(lines, terminal(stderr=True, quiet=as_json)) as view:
        report = replay(
            path, out, speed, force, view.step, PATIENCE, view.look if view.looks else None
        )
    if timing(view):
        terminal(stderr=True, quiet=as_json).print(timing(view))
    if as_json:
        print_json(report.document())
    elif out is None:
        print_report(terminal(), report)
    else:
        print_result(report, out)
    return 0 if report.passes else 1


def lines_of_record(record: Record) -> dict[str, ConditionLine]:
    """Return the live view's lines for the conditions of a session, by id."""
    runs = Counter(run.condition for run in record.runs)
    lines = {}
    for key, condition in record.conditions.items():
        setting = Setting.of(condition)
        lines[key] = ConditionLine(
            setting.bed, setting.fill, setting.diameter, setting.acceleration_set, runs[key]
        )
    return lines
