"""Records of other laboratories, in every format, become sessions; those that cannot be trusted are
refused with the reason.
"""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from imported_record import imported
from small_protocol import Rig

from analysis import AnalysisError, run_energy
from daq import open_session
from rig.catalog.rig_file import load_rig
from rig.errors import InputError
from rig.importing.mapping import read_mapping
from rig.protocol.grid import conditions
from rig.protocol.load import load_protocol

EXAMPLE = Path(__file__).parents[2] / "examples" / "your_own_data"


@pytest.fixture(scope="module")
def example(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The records of docs/your-own-data.md, made by a program that knows nothing of the project."""
    folder = tmp_path_factory.mktemp("own")
    command = [sys.executable, str(EXAMPLE / "make_record.py"), str(folder)]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    subprocess.run(
        command, check=True, timeout=60, capture_output=True, env=environment, cwd=folder
    )
    return folder


def columns(folder: Path, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rows = np.loadtxt(folder / name, delimiter=";", skiprows=1)
    return rows[:, 0], rows[:, 1], rows[:, 2]


def as_npz(path: Path, _t: np.ndarray, F: np.ndarray, a: np.ndarray) -> None:
    entries = [{"name": n, "unit_str": "", "fs": 5120.0} for n in ("F", "a")]
    np.savez(path, channels=np.array(json.dumps(entries)), data_0=F, data_1=a)


def as_uff(path: Path, t: np.ndarray, F: np.ndarray, a: np.ndarray) -> None:
    pyuff = pytest.importorskip("pyuff")
    file = pyuff.UFF(str(path))
    for node, (name, values) in enumerate((("F", F), ("a", a)), start=1):
        file.write_sets(
            {
                "type": 58,
                "func_type": 1,
                "rsp_node": node,
                "rsp_dir": 1,
                "ref_node": 1,
                "ref_dir": 1,
                "data": values,
                "x": t,
                "id1": name,
                "rsp_ent_name": name,
                "ref_ent_name": "NONE",
                "abscissa_spacing": 1,
                "ordinate_spec_data_type": 0,
                "abscissa_spec_data_type": 17,
                "orddenom_spec_data_type": 0,
                "binary": 1,
            },
            mode="add",
        )


def as_tdms(path: Path, _t: np.ndarray, F: np.ndarray, a: np.ndarray) -> None:
    nptdms = pytest.importorskip("nptdms")
    with nptdms.TdmsWriter(path) as writer:
        for name, values in (("F", F), ("a", a)):
            writer.write_segment(
                [nptdms.ChannelObject("stand", name, values, {"wf_increment": 1 / 5120.0})]
            )


def as_mat(path: Path, _t: np.ndarray, F: np.ndarray, a: np.ndarray) -> None:
    scipy.io.savemat(path, {"records": np.stack([F, a], axis=1), "fs": 5120.0})


def as_h5(path: Path, _t: np.ndarray, F: np.ndarray, a: np.ndarray) -> None:
    with h5py.File(path, "w") as file:
        file["stand/force"] = F
        file.create_dataset("stand/acceleration", data=a, compression="gzip")


MAKERS: dict[str, tuple[str, Callable[..., None], str, str, str]] = {
    "sep005": ("box.npz", as_npz, "F", "a", ""),
    "uff58": ("box.uff", as_uff, "F", "a", "rate: 5120 Hz\n"),
    "tdms": ("box.tdms", as_tdms, "stand/F", "stand/a", ""),
    "mat": ("box.mat", as_mat, "records#1", "records#2", ""),
    "hdf5": ("box.h5", as_h5, "stand/force", "stand/acceleration", "rate: 5120 Hz\n"),
}


MAP = """\
schema: rig/map/1
name: box
force: {{channel: {F}, calibration_U: 1 %}}
acceleration: {{channel: {a}, unit: g, calibration_U: 1 %}}
settle: 0.5 s
condition: {{id: box}}
{more}"""


@pytest.mark.parametrize("kind", MAKERS)
def test_every_format_gives_the_energy_that_the_csv_gives(
    example: Path, tmp_path: Path, kind: str
) -> None:
    name, make, F, a, more = MAKERS[kind]
    make(tmp_path / name, *columns(example, "box_1.csv"))
    found = imported(tmp_path, tmp_path / name, MAP.format(F=F, a=a, more=more))
    csv = 'csv: {delimiter: ";"}\ntime: {channel: "t [s]"}\n'
    same = imported(tmp_path, example / "box_1.csv", MAP.format(F='"F [N]"', a='"a [g]"', more=csv))
    # the time column's nine digits give the rate to 1e-10, and the codes hold 9e-10 of the largest
    # value
    assert pytest.approx(same.W, rel=1e-6) == found.W
    assert found.cycles == same.cycles


def test_signs_units_volts_and_time_scales_are_undone(example: Path, tmp_path: Path) -> None:
    t, F, a = columns(example, "box_1.csv")
    plain = 'csv: {delimiter: ";"}\ntime: {channel: "t [s]"}\n'
    expected = imported(
        tmp_path, example / "box_1.csv", MAP.format(F='"F [N]"', a='"a [g]"', more=plain)
    )
    np.savetxt(tmp_path / "odd.txt", np.stack([1e3 * t, -2.25e-3 * F, 9.80665e3 * a], axis=1), delimiter="\t",
               header="made elsewhere\nms, V, mm/s2", fmt="%.12e")  # fmt: skip
    text = """\
schema: rig/map/1
name: odd
csv: {delimiter: "\\t"}
time: {channel: 1, unit: ms}
force: {channel: 2, unit: V, sensitivity: 2.25 mV/N, sign: -1}
acceleration: {channel: 3, unit: mm/s^2}
settle: 0.5 s
"""
    assert pytest.approx(expected.W, rel=1e-6) == imported(tmp_path, tmp_path / "odd.txt", text).W


def test_the_walk_through_finds_the_energy_that_was_put_in(
    rig_command: Rig, example: Path, tmp_path: Path
) -> None:
    """docs/your-own-data.md, with the energy from the closed form at the top of make_record.py."""
    done = rig_command("import", example, "--map", EXAMPLE / "map.yaml", "--out", tmp_path / "o")
    assert done.returncode == 0, done.stderr + done.stdout
    report = json.loads((tmp_path / "o" / "report.json").read_text())
    box, empty = report["conditions"]
    w, X = 2 * np.pi * 19.87, 4.0 / (2 * np.pi * 19.87) ** 2
    exact = np.pi * X**2 * (24.0 * w + 900.0)
    assert abs(box["W_exp"] - exact) < box["U_W_exp"]
    # What noise alone leaves: force noise 0.05 N on X and acceleration noise 0.004 on |F|, over 3 x
    # 17920 samples
    noise = np.pi / w**2 * np.sqrt(2 / (3 * 17920)) * np.hypot(4.0 * 0.05, 124.0 * 0.004)
    assert abs(box["W_exp"] - exact) < 4 * noise
    assert abs(empty["W_exp"]) < empty["W_detect"] + empty["U_W_exp"]
    assert box["frequency"] == pytest.approx(19.87, rel=1e-6)
    assert box["M_eff"] == pytest.approx(31.0, rel=1e-3)
    assert (report["synthetic"], report["tests"]) == (False, "model")
    assert box["offset_terms"] is None
    assert rig_command("info", "--validate", tmp_path / "o").returncode == 0


def test_a_scene_in_the_mapping_predicts(example: Path, tmp_path: Path) -> None:
    more = 'csv: {delimiter: ";"}\ntime: {channel: "t [s]"}\nscene: {grains: {diameter: 4 mm, fill: 85 %}}\n'
    imported(tmp_path, example / "box_1.csv", MAP.format(F='"F [N]"', a='"a [g]"', more=more))
    from analysis import read_session
    from rig.prediction.model import predict

    with open_session(tmp_path / "s.h5") as record:
        row = read_session(record).document()["conditions"][0]
    sets = ("scene.grains.diameter=4 mm", "scene.grains.fill=0.85", f"drive.acceleration={row['acceleration']}",
            f"drive.frequency={row['frequency']}")  # fmt: skip
    condition = conditions(load_protocol("schema: rig/protocol/1\nname: x\n", sets=sets))[0]
    # between tabulated levels a power law: NUMERICAL_ERROR of the layers variant is 1e-3
    assert row["W_T"] == pytest.approx(predict(condition, load_rig("paper")).W_T, rel=5e-3)


@pytest.mark.parametrize("told", ["", ", acceleration: 6 m/s^2"])
def test_a_distorted_record_is_predicted_at_its_fundamental(
    example: Path, tmp_path: Path, told: str
) -> None:
    """A third harmonic of 1.2 times the fundamental (4 m/s^2): sqrt(2) times its rms, 6.2, is no
    level of it.
    """
    t, F, a = columns(example, "box_1.csv")
    rows = np.stack([t, F, a + 1.2 * 4.0 / 9.80665 * np.sin(2 * np.pi * 3 * 19.87 * t)], axis=1)
    np.savetxt(tmp_path / "r.csv", rows, delimiter=";", header="t [s];F [N];a [g]", comments="")
    more = 'frequency: 19.87 Hz\ncsv: {delimiter: ";"}\ntime: {channel: "t [s]"}\n'
    more += "scene: {grains: {diameter: 4 mm, fill: 85 %}}\n"
    text = MAP.format(F='"F [N]"', a='"a [g]"', more=more).replace(
        "{id: box}", "{id: box" + told + "}"
    )
    level = imported(tmp_path, tmp_path / "r.csv", text).level
    assert level == pytest.approx(4.0, rel=1e-3)
    with open_session(tmp_path / "s.h5") as record:
        entry = record.document("prediction")["conditions"]["box"]
        assert record.conditions["box"]["acceleration_set"] == (
            6.0 if told else pytest.approx(level, rel=1e-4)
        )
    assert entry["acceleration"][len(entry["acceleration"]) // 2] == pytest.approx(level, rel=1e-4)


@pytest.mark.parametrize("stated", [15.0, 18.5, 19.6, 20.2, 20.5, 21.0, 25.0, 30.0])
def test_a_stated_frequency_that_is_not_the_records_is_refused(
    example: Path, tmp_path: Path, stated: float
) -> None:
    """The drive is at 19.87 Hz; beyond 1 % of what is stated nothing is written."""
    more = f'frequency: {stated} Hz\ncsv: {{delimiter: ";"}}\ntime: {{channel: "t [s]"}}\n'
    with pytest.raises(
        AnalysisError, match=f"the drive is at 19.87 Hz, the mapping says {stated:g} Hz"
    ):
        imported(tmp_path, example / "box_1.csv", MAP.format(F='"F [N]"', a='"a [g]"', more=more))
    assert not (tmp_path / "s.h5").exists()


BAD_RECORDS: dict[str, tuple[Callable[[np.ndarray], np.ndarray], str]] = {
    "not steady": (
        lambda rows: rows * np.array([1, 1, 1]) * (1 + rows[:, :1] * [0, 1, 1]),
        "not steady",
    ),
    "a gap in time": (
        lambda rows: np.delete(rows, slice(9000, 9050), axis=0),
        "time column is not even",
    ),
    "not a number": (
        lambda rows: np.where(np.arange(len(rows))[:, None] == 7000, [0.0, np.nan, 0.0], rows),
        "is not a number",
    ),
    "nothing moves": (lambda rows: rows * [1, 1, 0], "nothing moves"),
    "too short": (lambda rows: rows[:3000], "whole cycles"),
}


@pytest.mark.parametrize("case", BAD_RECORDS)
def test_a_record_that_cannot_be_trusted_is_refused_with_its_reason(
    rig_command: Rig, example: Path, tmp_path: Path, case: str
) -> None:
    change, words = BAD_RECORDS[case]
    rows = change(np.loadtxt(example / "box_1.csv", delimiter=";", skiprows=1))
    np.savetxt(tmp_path / "r.csv", rows, delimiter=";", header="t [s];F [N];a [g]", comments="")
    more = 'csv: {delimiter: ";"}\ntime: {channel: "t [s]"}\n'
    (tmp_path / "map.yaml").write_text(MAP.format(F='"F [N]"', a='"a [g]"', more=more))
    done = rig_command(
        "import", tmp_path / "r.csv", "--map", tmp_path / "map.yaml", "--out", tmp_path / "o"
    )
    assert done.returncode == 2
    assert words in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "o").exists()


def test_a_clipped_record_is_flagged(example: Path, tmp_path: Path) -> None:
    rows = np.loadtxt(example / "box_1.csv", delimiter=";", skiprows=1)
    rows[:, 1] = np.clip(rows[:, 1], -100.0, 100.0)
    np.savetxt(tmp_path / "r.csv", rows, delimiter=";", header="t [s];F [N];a [g]", comments="")
    more = 'csv: {delimiter: ";"}\ntime: {channel: "t [s]"}\n'
    imported(tmp_path, tmp_path / "r.csv", MAP.format(F='"F [N]"', a='"a [g]"', more=more))
    with open_session(tmp_path / "s.h5") as record:
        flags = {"overload_hi", "overload_lo", "saturated_force"}
        assert set(run_energy(record, "run_0001").flags) == flags


BAD_MAPS = {
    "unknown key": (
        "schema: rig/map/1\nname: x\nforce: {chanel: F}\nacceleration: {channel: a}\n",
        ":3: force.chanel",
        "did you mean 'channel'",
    ),
    "volts without sensitivity": (
        "schema: rig/map/1\nname: x\nforce: {channel: F, unit: V}\nacceleration: {channel: a}\n",
        ":3: force.sensitivity",
        "a sensitivity for V",
    ),
    "unit": (
        "schema: rig/map/1\nname: x\nforce: {channel: F}\nacceleration: {channel: a, unit: m/s}\n",
        ":4: acceleration.unit",
        "m/s^2",
    ),
    "no force": (
        "schema: rig/map/1\nname: x\nacceleration: {channel: a}\n",
        "force",
        "an entry force",
    ),
    "sign": (
        "schema: rig/map/1\nname: x\nforce: {channel: F, sign: 0}\nacceleration: {channel: a}\n",
        ":3: force.sign",
        "1 or -1",
    ),
    "schema": (
        "schema: rig/map/9\nname: x\nforce: {channel: F}\nacceleration: {channel: a}\n",
        ":1: schema",
        "rig/map/1",
    ),
    "runs": (
        "schema: rig/map/1\nname: x\nforce: {channel: F}\nacceleration: {channel: a}\nruns: [{fil: b.csv}]\n",
        ":5: runs[1].fil",
        "did you mean 'file'",
    ),
}


@pytest.mark.parametrize("case", BAD_MAPS)
def test_a_wrong_mapping_names_line_field_and_what_is_allowed(tmp_path: Path, case: str) -> None:
    text, place, words = BAD_MAPS[case]
    (tmp_path / "map.yaml").write_text(text)
    with pytest.raises(InputError) as caught:
        read_mapping(tmp_path / "map.yaml")
    assert place in str(caught.value)
    assert words in str(caught.value)


@pytest.mark.parametrize("name", ["x.csv", "x.uff", "x.npz", "x.tdms", "x.mat", "x.h5", "x.what"])
@pytest.mark.parametrize("content", [b"", b"\x00\xff" * 5000, b"a;b\n1;2\n3\n", b"PK\x03\x04" + bytes(100),
                                     b"\x89HDF\r\n\x1a\n" + bytes(200)])  # fmt: skip
def test_junk_is_refused_in_one_sentence(tmp_path: Path, name: str, content: bytes) -> None:
    from daq.formats.wave import FormatError

    (tmp_path / name).write_bytes(content)
    with pytest.raises(FormatError, match=r"x\."):
        imported(tmp_path, tmp_path / name, MAP.format(F="F", a="a", more="rate: 5120 Hz\n"))


def test_a_missing_reader_is_named_with_its_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from daq.formats.wave import MissingReader

    monkeypatch.setitem(sys.modules, "nptdms", None)
    (tmp_path / "x.tdms").write_bytes(b"TDSm")
    with pytest.raises(MissingReader, match=r"npTDMS: pip install .*\[formats\]"):
        imported(tmp_path, tmp_path / "x.tdms", MAP.format(F="F", a="a", more=""))


def test_links_to_other_files_are_not_followed(tmp_path: Path) -> None:
    from daq.formats.wave import FormatError

    with h5py.File(tmp_path / "other.h5", "w") as file:
        file["F"] = np.arange(100.0)
    with h5py.File(tmp_path / "x.h5", "w") as file:
        file["F"] = h5py.ExternalLink("other.h5", "F")
        file["a"] = np.arange(100.0)
    with pytest.raises(FormatError, match="no dataset 'F'"):
        imported(tmp_path, tmp_path / "x.h5", MAP.format(F="F", a="a", more="rate: 5120 Hz\n"))
