"""`rig report A B` on the command line: exit codes, files, JSON, two beds, simulated against
imported.
"""

import json
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from small_protocol import Rig

from analysis.report.json_schema import COMPARED, comparison_schema
from daq.documents.shapes import deviations

FILES = {"comparison.json", "comparison.csv", "comparison.md", "comparison.html"}
PROTOCOL = """\
schema: rig/protocol/1
name: {name}
scene: {{grains: {{material: stainless, diameter: 8 mm, fill: 85 %}}, bed: {bed}}}
acquire: {{settle: 10 cycles, record: 40 cycles}}
vary: {{drive.acceleration: [{levels}]}}
repeats: 3
seed: {seed}
"""
LEVELS = "3 m/s^2, 4 m/s^2"


@pytest.fixture(scope="module")
def made(rig_command: Rig, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Sessions: the same bed twice (other instruments), a single mass, other levels."""
    folder, found = tmp_path_factory.mktemp("compare"), {}
    for name, bed, levels, seed in (
        ("one", "layers", LEVELS, 1),
        ("two", "layers", LEVELS, 2),
        ("single_mass", "single_mass", LEVELS, 1),
        ("apart", "layers", "6 m/s^2", 1),
    ):
        (folder / f"{name}.yaml").write_text(
            PROTOCOL.format(name=name, bed=bed, levels=levels, seed=seed)
        )
        done = rig_command("run", folder / f"{name}.yaml", "--out", folder / name, "--workers", "1")
        assert done.returncode in (0, 1), done.stderr
        found[name] = folder / name
    return found


def compared(folder: Path) -> Any:
    """The comparison in a folder, which has the published shape and every file."""
    assert {path.name for path in folder.iterdir()} >= FILES
    found = json.loads((folder / "comparison.json").read_text(encoding="utf-8"))
    assert list(deviations(found, COMPARED)) == []
    Draft202012Validator(dict(comparison_schema())).validate(found)
    return found


def test_files_words_and_json(rig_command: Rig, made: dict[str, Path], tmp_path: Path) -> None:
    done = rig_command("report", made["one"], made["two"], "--out", tmp_path / "c")
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert "Over 2 matched conditions" in done.stdout
    assert f"comparison: {tmp_path / 'c' / 'comparison.html'}" in done.stdout.replace("\n", "")
    found = compared(tmp_path / "c")
    assert (tmp_path / "c" / "figures" / "comparison.svg").exists()
    assert [pair["A"] for pair in found["pairs"]] == [pair["B"] for pair in found["pairs"]]
    assert found["same_instruments"] is False
    printed = rig_command("report", made["one"], made["two"], "--json", "--out", tmp_path / "j")
    assert json.loads(printed.stdout) == found


def test_without_a_folder_it_goes_beside_the_second(
    rig_command: Rig, made: dict[str, Path]
) -> None:
    before = (made["one"] / "report.json").read_bytes()
    assert rig_command("report", made["one"], made["two"] / "session.h5").returncode == 0
    compared(made["two"] / "against_one")
    assert (made["one"] / "report.json").read_bytes() == before


def test_two_beds_at_equal_settings(
    rig_command: Rig, made: dict[str, Path], tmp_path: Path
) -> None:
    """Same seed, so the same instruments: their errors cancel. A rigid single mass in a horizontal
    box is not loose layers.
    """
    done = rig_command("report", made["one"], made["single_mass"], "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    found = compared(tmp_path)
    assert found["same_instruments"] is True
    assert {(pair["bed_A"], pair["bed_B"]) for pair in found["pairs"]} == {
        ("layers", "single_mass")
    }
    assert found["overall"]["n"] == 2


def test_nothing_in_common_is_one(rig_command: Rig, made: dict[str, Path], tmp_path: Path) -> None:
    done = rig_command("report", made["one"], made["apart"], "--out", tmp_path)
    assert done.returncode == 1
    assert "nothing can be compared" in done.stdout
    assert "acceleration_set 3 against 6" in done.stdout.replace("\n", " ")
    assert compared(tmp_path)["overall"] is None


def test_bad_input_writes_nothing(rig_command: Rig, made: dict[str, Path], tmp_path: Path) -> None:
    (tmp_path / "junk.h5").write_bytes(b"no session")
    for other in (tmp_path / "nowhere", tmp_path / "junk.h5"):
        done = rig_command("report", made["one"], other, "--out", tmp_path / "c")
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
        assert not (tmp_path / "c").exists()
    assert (
        rig_command(
            "report", made["one"], made["two"], made["single_mass"], "--out", tmp_path / "c"
        ).returncode
        == 2
    )


@pytest.mark.parametrize("level", [", acceleration: 3 m/s^2", ""])
def test_a_simulated_session_against_an_imported_one(
    rig_command: Rig, made: dict[str, Path], tmp_path: Path, level: str
) -> None:
    """The records of session `one` at the lower level, exported as a laboratory's own: W must
    agree, and what the mapping does not say (the fill; the level that was set, where only the
    measured one is known) is no difference."""
    facts = json.loads(rig_command("info", made["one"], "--json").stdout)["conditions"][0]
    report = json.loads((made["one"] / "report.json").read_text(encoding="utf-8"))
    row = next(row for row in report["conditions"] if row["acceleration_set"] == 3.0)
    for run in row["runs"]:
        out = tmp_path / f"{run['run']}.csv"
        done = rig_command("export", made["one"], "--to", "csv", "--run", run["run"], "--out", out)
        assert done.returncode == 0, done.stderr
    head = (
        (tmp_path / f"{row['runs'][0]['run']}.csv")
        .read_text(encoding="utf-8")
        .splitlines()[0]
        .split(",")
    )
    runs = ", ".join(f"{{file: {run['run']}.csv}}" for run in row["runs"])
    (tmp_path / "map.yaml").write_text(
        "schema: rig/map/1\nname: lab\nrate: 10240 Hz\nsettle: 0.5 s\n"
        f"force: {{channel: {json.dumps(head[0])}}}\n"
        f"acceleration: {{channel: {json.dumps(head[1])}}}\n"
        f"condition: {{id: lab, material: stainless, diameter: 8 mm{level}}}\n"
        f"runs: [{runs}]\n"
    )
    assert facts["diameter"] == 8e-3
    done = rig_command(
        "import", tmp_path, "--map", tmp_path / "map.yaml", "--out", tmp_path / "lab"
    )
    assert done.returncode == 0, done.stdout + done.stderr
    done = rig_command("report", made["one"], tmp_path / "lab", "--out", tmp_path / "c")
    assert done.returncode == 0, done.stderr
    found = compared(tmp_path / "c")
    assert [session["synthetic"] for session in found["sessions"]] == [True, False]
    (pair,) = found["pairs"]
    assert (pair["A"], pair["B"], pair["bed_B"]) == (row["id"], "lab", "unknown")
    assert pair["not_compared"] == ["density", "fill"]
    assert "does not know it: density, fill." in done.stdout.replace("\n", " ")
    # the same samples; what differs: frequency found or known, window, poles of the certificate's
    # digits
    assert abs(pair["relative"]) < 0.01
    assert not pair["significant"]


def test_what_a_violent_bed_does_not_repeat_is_not_the_quiet_records_noise(
    rig_command: Rig, made: dict[str, Path], tmp_path: Path
) -> None:
    """All levels of session `one` imported together, noise not stated: each is used."""
    assert rig_command("export", made["one"], "--to", "csv", "--out", tmp_path).returncode == 0
    facts = [
        json.loads(path.read_text(encoding="utf-8")) for path in sorted(tmp_path.glob("*.json"))
    ]
    head = (
        (tmp_path / f"{facts[0]['run']}.csv").read_text(encoding="utf-8").splitlines()[0].split(",")
    )
    runs = "".join(
        f"  - {{file: {one['run']}.csv, condition: {{id: {one['condition']['id']}}}}}\n"
        for one in facts
    )
    (tmp_path / "map.yaml").write_text(
        "schema: rig/map/1\nname: lab\nrate: 10240 Hz\nsettle: 0.5 s\n"
        f"force: {{channel: {json.dumps(head[0])}}}\n"
        f"acceleration: {{channel: {json.dumps(head[1])}}}\nruns:\n{runs}"
    )
    done = rig_command(
        "import", tmp_path, "--map", tmp_path / "map.yaml", "--out", tmp_path / "lab"
    )
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads((tmp_path / "lab" / "report.json").read_text(encoding="utf-8"))
    assert report["left_out"] == []
    assert len(report["conditions"]) == len({one["condition"]["id"] for one in facts}) > 1
