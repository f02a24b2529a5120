"""`rig replay`: the same road gives the same codes and the same report, byte for byte, at any
speed.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from small_protocol import SMALL, Rig

from daq import open_session
from daq.chain.clock import NEVER_LATE
from daq.session.copy import plan_of
from daq.session.writer import Recorder
from rig.campaign.campaign import Campaign
from rig.campaign.replayer import replay
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.protocol.load import load_protocol

REPORTS = ("report.json", "report.csv", "report.md", "report.html")


def campaign(*sets: str) -> Campaign:
    protocol = load_protocol(
        SMALL, sets=("drive.acceleration=4", "vary={scene.bed: [layers, locked]}", *sets)
    )
    return campaign_of(protocol, load_rig(protocol.rig), SMALL)


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("recorded")
    run(campaign(), out, workers=1)
    return out


def same_samples(one: Path, other: Path) -> None:
    with open_session(one / "session.h5") as a, open_session(other / "session.h5") as b:
        assert a.runs == b.runs
        for info in a.runs:
            for channel in a.channels:
                np.testing.assert_array_equal(
                    a.codes(info.name, channel), b.codes(info.name, channel)
                )
            np.testing.assert_array_equal(a.blocks(info.name), b.blocks(info.name))
            assert a.scalars(info.name) == b.scalars(info.name)
            assert a.truth is not None
            assert b.truth is not None
            np.testing.assert_array_equal(
                a.truth.ledger(info.name)[1], b.truth.ledger(info.name)[1]
            )


@pytest.mark.parametrize("speed", [None, 200.0])
def test_codes_and_report_are_the_same_bytes(
    session: Path, tmp_path: Path, speed: float | None
) -> None:
    replay(session / "session.h5", tmp_path, speed)
    same_samples(session, tmp_path)
    for name in REPORTS:
        assert (tmp_path / name).read_bytes() == (session / name).read_bytes(), name
    figures = {path.name: path.read_bytes() for path in (session / "figures").iterdir()}
    assert {path.name: path.read_bytes() for path in (tmp_path / "figures").iterdir()} == figures


def test_a_replay_of_a_replay_is_the_same_again(session: Path, tmp_path: Path) -> None:
    replay(session / "session.h5", tmp_path / "one")
    replay(tmp_path / "one" / "session.h5", tmp_path / "two")
    same_samples(session, tmp_path / "two")
    assert (tmp_path / "two" / "report.json").read_bytes() == (session / "report.json").read_bytes()


def test_without_a_folder_the_report_is_returned_and_nothing_written(session: Path) -> None:
    before = sorted(path.name for path in session.iterdir())
    report = replay(session / "session.h5").document()
    assert report == json.loads((session / "report.json").read_text())
    assert sorted(path.name for path in session.iterdir()) == before


def test_an_incomplete_session_is_replayed_as_far_as_it_goes(session: Path, tmp_path: Path) -> None:
    with (
        open_session(session / "session.h5") as record,
        Recorder.create(tmp_path / "cut.h5", plan_of(record)) as part,
    ):
        first = min(record.runs, key=lambda info: info.order)
        from daq.chain.replay import Replayed

        acquisition = Replayed(record, first.name)
        part.append(first.name, acquisition.read(acquisition.sizes[0]))
    report = replay(tmp_path / "cut.h5", tmp_path / "again").document()
    assert len(report["left_out"]) == len(campaign().runs)
    with open_session(tmp_path / "again" / "session.h5") as again:
        found = again.run(first.name)
        assert (found.samples, found.complete) == (acquisition.sizes[0], False)


def test_the_command_prints_the_same_as_run(
    rig_command: Rig, session: Path, tmp_path: Path
) -> None:
    done = rig_command("replay", session, "--out", tmp_path / "o")
    assert done.returncode in (0, 1), done.stderr
    assert "verdict:" in done.stdout
    assert (tmp_path / "o" / "report.html").read_bytes() == (session / "report.html").read_bytes()
    again = rig_command("replay", session, "--json")
    assert json.loads(again.stdout) == json.loads((session / "report.json").read_text())
    assert again.returncode == done.returncode


def test_a_session_is_not_replayed_onto_itself(rig_command: Rig, session: Path) -> None:
    before = (session / "session.h5").read_bytes()
    done = rig_command("replay", session, "--out", session, "--force")
    assert done.returncode == 2
    assert "another folder" in done.stderr
    assert (session / "session.h5").read_bytes() == before


def test_every_block_waits_for_its_time(session: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    waited: list[tuple[float, float | None, int]] = []

    class Waiting:
        def __init__(self, rate: float, speed: float | None) -> None:
            self.pace = (rate, speed)
            self.punctuality = NEVER_LATE

        def wait(self, sample: int) -> None:
            waited.append((*self.pace, sample))

    monkeypatch.setattr("rig.campaign.replayer.Pacer", Waiting)
    replay(session / "session.h5", speed=3.0)
    with open_session(session / "session.h5") as record:
        runs = sorted(record.runs, key=lambda run: run.order)
        ends = [
            (r.rate, 3.0, int(b["start"] + b["count"])) for r in runs for b in record.blocks(r.name)
        ]
    assert waited == ends
