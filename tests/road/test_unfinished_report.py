"""A report that was killed while it was written is distinguished from a complete one."""

import json
import os
import signal
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from small_protocol import SMALL

from analysis import read_report, write_report
from daq.whole_files import UNFINISHED
from rig.campaign.runner import run
from rig.cli.commands import sessions
from rig.protocol.load import load_protocol

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="kills a forked process")


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("unfinished") / "s"
    sets = (
        "vary={scene.bed: [empty, locked], drive.acceleration: [2, 3]}",
        "acquire.settle=4",
        "acquire.record=6",
    )
    run(load_protocol(SMALL, sets=(*sets, "repeats=1")), folder, workers=1)
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    names = (
        path
        for path in folder.rglob("*")
        if path.is_file() and path.suffix not in (".h5", ".part", ".lock")
    )
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in names}


def killed_at_move(session: Path, move: int) -> None:
    """Another report of the session is written by a process that SIGKILL ends before its `move`-th
    move.
    """
    child = os.fork()
    if not child:
        moves = iter(range(move + 1))

        def count(event: str, _: tuple[object, ...]) -> None:
            if event == "os.rename" and next(moves) == move:
                os.kill(os.getpid(), signal.SIGKILL)

        try:
            report = replace(read_report(session), protocol="another")
            sys.addaudithook(count)
            write_report(report, session)
        finally:
            os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL


@pytest.mark.parametrize("move", [0, 1, 2, 4, -1])
def test_a_mix_of_old_and_new_files_is_reported_and_mended(
    session: Path, move: int, capsys: pytest.CaptureFixture[str]
) -> None:
    old = contents(session)
    last = len(old)  # one move a file, the note's before all
    killed_at_move(session, move % (last + 1) if move >= 0 else last)
    mixed = contents(session)
    assert mixed["report.json"] == old["report.json"]
    sessions.session_info(session, True)
    told = json.loads(capsys.readouterr().out)["report_unfinished"]
    assert told == (move != 0) == (UNFINISHED in mixed)
    assert told or mixed == old
    sessions.session_info(session, False)
    assert ("do not belong together" in capsys.readouterr().out) == told
    sessions.report_sessions([session], None, False)
    assert ("unfinished" in capsys.readouterr().err) == told
    assert contents(session) == old


def test_a_recording_in_the_place_of_another_marks_the_old_report(session: Path) -> None:
    """Killed while it records: the session is new, the report is that of the old one."""
    child = os.fork()
    if not child:
        sets = (
            "vary={}",
            "scene.bed=locked",
            "acquire.settle=4",
            "acquire.record=6",
            "repeats=2",
            "seed=8",
        )

        def kill(_: object) -> None:
            os.kill(os.getpid(), signal.SIGKILL)

        run(load_protocol(SMALL, sets=sets), session, workers=1, overwrite=True, progress=kill)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL
    assert (session / UNFINISHED).exists()


def test_conditions_are_folded_on_the_terminal_and_whole_as_json(
    session: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    sessions.session_info(session, True)
    count = len(json.loads(capsys.readouterr().out)["conditions"])
    for most in range(1, count + 1):
        monkeypatch.setattr(sessions, "MOST_ROWS", most)
        sessions.session_info(session, False)
        shown = capsys.readouterr().out
        assert sum(f"c{k:02d} " in shown for k in range(1, count + 1)) == most
        assert (f"{count - most} more" in shown or f"{count - most} condition" in shown) == (
            most < count
        )
