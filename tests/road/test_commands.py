"""The command line: exit codes, messages, JSON, and that bad input leaves no files."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from small_protocol import Rig
from typer.testing import CliRunner

from rig.cli.app import app

COMMON = ("--workers", "2")


@pytest.fixture(scope="module")
def session(rig_command: Rig, small: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("session") / "out"
    done = rig_command("run", small, "--out", out, *COMMON)
    assert done.returncode == 0, done.stderr
    assert "verdict: passes" in done.stdout
    assert "Traceback" not in done.stderr
    return out


def test_run_writes_what_it_says(session: Path) -> None:
    reports = {"report.json", "report.csv", "report.md", "report.html"}
    assert {path.name for path in session.iterdir()} >= {"session.h5", *reports}


def test_json_and_nothing_else(rig_command: Rig, small: Path, tmp_path: Path) -> None:
    done = rig_command(
        "run", small, "--out", tmp_path / "o", "--json", "--set", "repeats.n=1", *COMMON
    )
    assert json.loads(done.stdout)["protocol"] == "small"
    assert done.stderr == ""


def test_report_and_info_read_the_file(rig_command: Rig, session: Path, tmp_path: Path) -> None:
    done = rig_command("report", session, "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "report.json").read_bytes() == (session / "report.json").read_bytes()
    facts = json.loads(rig_command("info", session, "--json").stdout)
    assert facts["complete"]
    assert facts["synthetic"]
    assert len(facts["conditions"]) == 9


def test_model_prints_the_contract(rig_command: Rig) -> None:
    done = rig_command("model", "--vary", "drive.acceleration=[1, 5]", "--json")
    rows = json.loads(done.stdout)["conditions"]
    assert [row["acceleration"] for row in rows] == [1.0, 5.0]
    assert {
        "bed_mass",
        "box_mass",
        "layers",
        "W_f",
        "W_c",
        "W_T",
        "W_T_as_printed",
        "bound",
        "period",
    } <= set(rows[0])
    assert rows[1]["W_T"] == pytest.approx(rows[1]["W_f"] + rows[1]["W_c"], rel=1e-12)


def test_check_warns_and_strict_refuses(rig_command: Rig, small: Path, tmp_path: Path) -> None:
    beyond = ("--set", "drive.acceleration=20 m/s^2", "--set", "scene.bed=locked")
    look = rig_command("check", small, *beyond)
    assert look.returncode == 0, look.stderr
    assert "exciter force" in look.stdout
    assert rig_command("check", small, *beyond, "--strict").returncode == 2
    refused = rig_command("run", small, *beyond, "--strict", "--out", tmp_path / "o")
    assert refused.returncode == 2
    assert "exciter force" in refused.stderr
    assert not (tmp_path / "o").exists()
    warned = rig_command("run", small, *beyond, "--out", tmp_path / "w", *COMMON)
    assert "warning: over_force in 2 runs" in warned.stdout
    flagged = rig_command("run", small, *beyond, "--out", tmp_path / "p", "--json", *COMMON)
    flags = [
        flag
        for c in json.loads(flagged.stdout)["conditions"]
        for r in c["runs"]
        for flag in r["flags"]
    ]
    assert any("force" in flag for flag in flags)


@pytest.mark.parametrize(
    ("sets", "said"),
    [
        (("acquire.ranges.force=0.1 V",), "force range"),
        (
            ("drive.mode=shaker", "drive.acceleration=80 m/s^2", "scene.bed=empty"),
            "the level is not reached",
        ),
        (("fidelity=auto", "tolerance=1e-9"), "the tolerance is not met"),
    ],
    ids=["range", "level", "tolerance"],
)
def test_check_fails_where_the_plan_will_not_hold(
    rig_command: Rig, small: Path, sets: tuple[str, ...], said: str
) -> None:
    """Exit code 1, as a run that overloads or misses its level ends with; a limit of the exciter
    alone only warns.
    """
    words = [word for one in sets for word in ("--set", one)]
    done = rig_command("check", small, *words, "--json")
    assert done.returncode == 1, done.stderr
    assert said in done.stderr
    unmet = json.loads(done.stdout)["unmet"]
    assert unmet
    assert all(said in line for line in unmet)


def test_init_then_check_then_run(rig_command: Rig, tmp_path: Path) -> None:
    assert rig_command("init", "mine.yaml", cwd=tmp_path).returncode == 0
    assert rig_command("check", "mine.yaml", cwd=tmp_path).returncode == 0
    again = rig_command("init", "mine.yaml", cwd=tmp_path)
    assert again.returncode == 2
    assert "exists" in again.stderr


def test_calibrate_writes_a_rig_that_runs(rig_command: Rig, small: Path, tmp_path: Path) -> None:
    out = tmp_path / "rig.yaml"
    done = rig_command("calibrate", small, "--target", "0.5", "--out", out, "--json")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["loss_noise"] > 0
    assert found["loss_air"] > 0
    assert found["provenance"]["target"] == 0.5
    assert rig_command("check", small, "--rig", out).returncode == 0


def test_catalog_names_statuses(rig_command: Rig) -> None:
    done = rig_command("catalog", "exciter", "--json")
    rows = json.loads(done.stdout)
    assert {row["status"] for row in rows} <= {"sourced", "recalled", "computed", "assumed"}
    assert any(row["name"] == "JZ-30" for row in rows)
    assert any(
        row["field"] == "wall_friction"
        for row in json.loads(rig_command("catalog", "rig", "--json").stdout)
    )


BAD = {
    "unknown key": ("schema: rig/protocol/1\nname: x\nscne: {}\n", r"x\.yaml:3: .*scene"),
    "missing unit": (
        "schema: rig/protocol/1\nname: x\ndrive: {frequency: '20'}\n",
        r"x\.yaml:3: drive\.frequency.*Hz",
    ),
    "negative mass": (
        "schema: rig/protocol/1\nname: x\nscene: {grains: {density: -1 kg/m^3}}\n",
        r"density",
    ),
    "fill 1.2": ("schema: rig/protocol/1\nname: x\nscene: {grains: {fill: 1.2}}\n", r"fill.*1\.2"),
    "frequency 0": ("schema: rig/protocol/1\nname: x\ndrive: {frequency: 0 Hz}\n", r"frequency"),
    "400 samples": ("schema: rig/protocol/1\nname: x\nacquire: {samples_per_cycle: 400}\n", r"500"),
    "grains": ("schema: rig/protocol/1\nname: x\nscene: {bed: grains}\n", r"not built yet"),
    "shaker": (
        "schema: rig/protocol/1\nname: x\nfidelity: auto\ndrive: {mode: shaker}\n",
        r"shaker",
    ),
    "axis": ("schema: rig/protocol/1\nname: x\nscene: {axis: vertical}\n", r"horizontal"),
    "empty": ("", r"empty"),
    "two mistakes": (
        "schema: rig/protocol/1\nname: x\nscene: {grains: {fill: 3}}\nseed: -1\n",
        r"(?s)fill.*seed",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_clear_message(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, case: str
) -> None:
    """In this process; junk below goes to one of its own."""
    text, expected = BAD[case]
    (tmp_path / "x.yaml").write_text(text)
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, ["run", "x.yaml", "--out", "o"])
    assert done.exit_code == 2
    assert re.search(expected, done.stderr), done.stderr
    assert done.stdout == ""
    assert [p.name for p in tmp_path.iterdir()] == ["x.yaml"]


def test_ten_megabytes_of_junk(rig_command: Rig, tmp_path: Path) -> None:
    (tmp_path / "junk.yaml").write_bytes(bytes(range(256)) * 40000)
    done = rig_command("run", "junk.yaml", cwd=tmp_path)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert len(done.stderr) < 500


def test_an_existing_session_is_kept(rig_command: Rig, session: Path, small: Path) -> None:
    before = (session / "session.h5").read_bytes()
    done = rig_command("run", small, "--out", session)
    assert done.returncode == 2
    assert "--resume" in done.stderr
    assert (session / "session.h5").read_bytes() == before


def test_output_that_cannot_be_written(rig_command: Rig, small: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    done = rig_command("run", small, "--out", tmp_path / "file" / "o")
    assert done.returncode == 2
    assert "Traceback" not in done.stderr


def test_missing_and_foreign_sessions(rig_command: Rig, tmp_path: Path) -> None:
    (tmp_path / "foreign.h5").write_bytes(b"no HDF5 at all")
    for path in ("nothing.h5", "foreign.h5"):
        for command in ("report", "info"):
            done = rig_command(command, path, cwd=tmp_path)
            assert done.returncode == 2
            assert path in done.stderr
            assert "Traceback" not in done.stderr


def test_a_rig_that_cannot_keep_pace_stops_with_three(
    rig_command: Rig, small: Path, tmp_path: Path
) -> None:
    done = rig_command(
        "run",
        small,
        "--speed",
        "1e7",
        "--out",
        tmp_path / "o",
        "--set",
        "acquire.record=4000 cycles",
    )
    assert done.returncode == 3
    assert "late" in done.stderr or "after its time" in done.stderr


@pytest.mark.parametrize(
    "words", [("info",), ("info", "--json"), ("report",), ("report", "--json")]
)
def test_a_reader_that_has_seen_enough_changes_no_exit_code(
    words: tuple[str, ...], session: Path
) -> None:
    """As `| head -1` does: the read end of the pipe is closed before anything is printed."""
    read, write = os.pipe()
    os.close(read)
    command = [
        sys.executable,
        "-c",
        "from rig.cli.app import main; main()",
        words[0],
        str(session),
        *words[1:],
    ]
    done = subprocess.run(
        command, stdout=write, stderr=subprocess.PIPE, text=True, check=False, timeout=300
    )
    os.close(write)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
