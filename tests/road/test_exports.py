"""What rig export writes reproduces the report: by a few lines of numpy, and through our own
import.
"""

import json
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from analysis import read_session
from daq import open_session
from daq.chain.block import Flag
from daq.formats.wave import FormatError
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.cli.commands.exchange import export_session
from rig.errors import InputError
from rig.importing.mapping import read_mapping
from rig.importing.to_session import import_records
from rig.protocol import shipped
from rig.protocol.load import load_protocol

PROTOCOLS = Path(__file__).parents[2] / "protocols"
SHORT = ("repeats=1", "acquire.settle=4", "acquire.record=6")
GRIDS = {
    "fill_rate": (
        *SHORT,
        "vary={scene.grains.fill: [0 %, 90 %], drive.acceleration: [2 m/s^2, 5 m/s^2]}",
    ),
    "gallery/clock": ("repeats=1",),
    "nulls": SHORT,
}
"""Of all shipped protocols these, on a short grid, are compared in every run of the tests; clock
has ideal inputs, whose force may be exactly zero in a harmonic."""

ANALYSED_WRONGLY = {"gallery/cycles", "gallery/offset"}
"""Whose error is made in the analysis: the record is right, and so is what is found in it by
hand.
"""

Pair = tuple[np.ndarray, np.ndarray]


def from_csv(path: Path) -> Pair:
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    return rows[:, 0], rows[:, 1]


def from_npz(path: Path) -> Pair:
    with np.load(path, allow_pickle=False) as arrays:
        return arrays["data_0"], arrays["data_1"]


def from_mat(path: Path) -> Pair:
    values = scipy.io.loadmat(path)
    return values["force"][:, 0], values["acceleration"][:, 0]


def from_uff(path: Path) -> Pair:
    import pyuff

    sets = pyuff.UFF(str(path)).read_sets()
    return sets[0]["data"], sets[1]["data"]


READERS: dict[str, tuple[str, Callable[[Path], Pair]]] = {
    "csv": (".csv", from_csv),
    "sep005-npz": (".npz", from_npz),
    "mat": (".mat", from_mat),
    "uff58": (".uff", from_uff),
}


def by_hand(pair: Pair, beside: dict) -> tuple[float, float, float]:
    """W (J per cycle), eta and M_eff (kg) of a record: the loop integral cycle by cycle, nothing of
    the project's.
    """
    window, frequency = beside["window"], beside["condition"]["frequency"]
    points = round(window["samples_per_cycle"])
    t = (
        window["start"]
        + np.arange(window["cycles"] * points) * window["samples_per_cycle"] / points
    ) / beside["rate"]
    own = np.arange(pair[0].size) / beside["rate"]
    F, a = (np.interp(t, own, values).reshape(window["cycles"], points) for values in pair)
    step = 1 / (frequency * points)
    F, a = F - F.mean(axis=1, keepdims=True), a - a.mean(axis=1, keepdims=True)
    v = np.cumsum(a, axis=1) * step - 0.5 * a * step
    W = float((F * (v - v.mean(axis=1, keepdims=True))).sum(axis=1).mean() * step)
    turn = np.exp(-2j * np.pi * np.arange(points) / points)
    F1, a1 = ((values.mean(axis=0) * turn).sum() * 2 / points for values in (F, a))
    M = float((F1 * np.conj(a1)).real / abs(a1) ** 2)
    return W, W * (2 * np.pi * frequency) ** 2 / (np.pi * M * abs(a1) ** 2), M


def recorded(name: str, sets: tuple[str, ...], folder: Path) -> dict:
    protocol = load_protocol(PROTOCOLS / f"{name}.yaml", sets=sets)
    run(
        campaign_of(protocol, load_rig(protocol.rig), (PROTOCOLS / f"{name}.yaml").read_text()),
        folder,
        workers=1,
    )
    return json.loads((folder / "report.json").read_text())


def compare(name: str, sets: tuple[str, ...], folder: Path) -> int:
    """Export a session every way and compare each run; the number of comparisons."""
    report, compared = recorded(name, sets, folder), 0
    for to, (suffix, read) in READERS.items():
        export_session(folder, to, None, folder / to, False, True)
        for condition in report["conditions"]:
            if condition.get("W_exp") is None:
                continue
            for row in condition["runs"]:
                path = (folder / to / row["run"]).with_suffix(suffix)
                beside = json.loads(path.with_name(path.name + ".json").read_text())
                W, eta, M = by_hand(read(path), beside)
                # U of one run's W: certificates and phase alone reach 1.6 % of it; .1 U of the
                # condition is asked for
                tenth = 0.1 * condition["U_W_exp"]
                assert row["W_exp"] == pytest.approx(W, abs=tenth), (name, to, row["run"])
                assert condition["M_eff"] == pytest.approx(M, rel=1e-4), (name, to, row["run"])
                assert condition["eta"] == pytest.approx(
                    eta, rel=0.1 * condition["U_W_exp"] / W, abs=1e-6
                )
                compared += 1
    return compared


@pytest.mark.parametrize("name", GRIDS)
def test_w_eta_and_mass_from_every_export_are_those_of_the_report(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert compare(name, GRIDS[name], tmp_path) >= 4 * 2
    capsys.readouterr()


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in shipped.names() if name not in ANALYSED_WRONGLY])
def test_every_shipped_protocol_comes_out_of_its_exports(name: str, tmp_path: Path) -> None:
    assert compare(name, ("repeats=1",), tmp_path) > 0


def imported(file: Path, mapping: str, out: Path) -> dict:
    map_file = out.with_suffix(".yaml")
    map_file.write_text("schema: rig/map/1\nname: again\n" + mapping)
    import_records([file], read_mapping(map_file), out)
    with open_session(out) as record:
        return read_session(record).document()


NAMES = {"csv": ("force [N]", "acceleration [m/s^2]"), "uff58": ("force", "acceleration"),
         "sep005-npz": ("force", "acceleration"), "mat": ("force", "acceleration")}  # fmt: skip


@pytest.fixture(scope="module")
def locked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A session of the locked bed alone, where a pole left in costs a fifth of W."""
    folder = tmp_path_factory.mktemp("locked")
    recorded("nulls", (*SHORT, "vary={}", "scene.bed=locked", "drive.acceleration=2"), folder)
    return folder


@pytest.mark.parametrize("raw", [False, True])
@pytest.mark.parametrize("to", sorted(READERS))
def test_our_import_takes_what_stands_beside_an_export(
    to: str, raw: bool, locked: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Corrected or raw: the mapping names channels only; rate, W, its U and the certificates are
    the session's.
    """
    export_session(locked, to, "1", tmp_path / f"r{READERS[to][0]}", raw, True)
    capsys.readouterr()
    force, acceleration = NAMES[to]
    mapping = f"force: {{channel: '{force}'}}\nacceleration: {{channel: '{acceleration}'}}\n"
    back = imported(tmp_path / f"r{READERS[to][0]}", mapping, tmp_path / "again.h5")["conditions"][
        0
    ]
    before = json.loads((locked / "report.json").read_text())["conditions"][0]
    # eight cycles of 24-bit codes, written again as 31-bit ones; the frequency is found anew, to
    # 1e-9
    tenth = 0.1 * before["U_W_exp"]
    assert back["W_exp"] == pytest.approx(before["W_exp"], abs=tenth)
    assert back["M_eff"] == pytest.approx(before["M_eff"], rel=1e-4)
    assert back["U_W_exp"] == pytest.approx(before["U_W_exp"], rel=0.15)


def test_no_correction_is_made_twice(
    locked: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    export_session(locked, "csv", "1", tmp_path / "r.csv", False, True)
    capsys.readouterr()
    for more in ("time_constant: 0.5 s", "delay: 20 us"):
        mapping = (
            f"force: {{channel: '1'}}\nacceleration: {{channel: '2', {more}}}\nrate: 10240 Hz\n"
        )
        with pytest.raises(InputError, match="undone already"):
            imported(tmp_path / "r.csv", mapping, tmp_path / "again.h5")


def test_flags_beside_the_record_come_back_and_damage_is_a_sentence(
    locked: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    export_session(locked, "csv", "1", tmp_path / "r.csv", False, True)
    capsys.readouterr()
    mapping = "force: {channel: '1'}\nacceleration: {channel: '2'}\nrate: 10240 Hz\n"
    beside = json.loads((tmp_path / "r.csv.json").read_text())
    assert beside["flags"] == [] or all(
        block["start"] < beside["window"]["start"] for block in beside["flags"]
    )
    beside["flags"] = [{"start": 5 * 512, "count": 3, "flags": {"force": int(Flag.OVERLOAD_HI)}}]
    (tmp_path / "r.csv.json").write_text(json.dumps(beside))
    back = imported(tmp_path / "r.csv", mapping, tmp_path / "again.h5")
    assert "overload_hi" in back["conditions"][0]["runs"][0]["flags"]
    for key, value in (("corrected", "yes"), ("channels", []), ("window", {"start": -1})):
        (tmp_path / "r.csv.json").write_text(json.dumps({**beside, key: value}))
        with pytest.raises(FormatError, match=r"r\.csv\.json"):
            imported(tmp_path / "r.csv", mapping, tmp_path / "other.h5")


def test_no_export_costs_the_user_a_file(
    locked: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The session, a link to it, a report, and what would stand beside the file."""
    folder = tmp_path / "s"
    shutil.copytree(locked, folder)
    (folder / "link.csv").symlink_to("session.h5")
    os.link(folder / "session.h5", folder / "hard.csv")
    (folder / "new.csv.json").write_text("{}")
    before = {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    for name in ("session.h5", "link.csv", "hard.csv"):
        for force in (False, True):
            with pytest.raises(InputError, match="the session itself"):
                export_session(folder, "csv", "1", folder / name, False, True, force)
    for name in ("report.csv", "report.json", "new.csv"):
        with pytest.raises(InputError, match="no file of rig export"):
            export_session(folder, "csv", "1", folder / name, False, True)
    assert {path.name: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before
    export_session(folder, "csv", "1", folder / "new.csv", False, True, force=True)
    export_session(folder, "csv", "1", folder / "new.csv", True, True)  # our own may be replaced
    capsys.readouterr()
    assert not json.loads((folder / "new.csv.json").read_text())["corrected"]


def test_what_stands_beside_one_file_never_speaks_for_another(
    locked: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Raw CSV and corrected UFF58 in one folder; then other samples under the old name, as a kill
    would leave them.
    """
    export_session(locked, "csv", None, tmp_path, True, True)
    export_session(locked, "uff58", None, tmp_path, False, True)
    export_session(locked, "csv", "1", tmp_path / "other.csv", False, True)
    capsys.readouterr()
    mapping = "force: {channel: '1'}\nacceleration: {channel: '2'}\nrate: 10240 Hz\n"
    before = json.loads((locked / "report.json").read_text())["conditions"][0]
    back = imported(tmp_path / "run_0001.csv", mapping, tmp_path / "a.h5")["conditions"][0]
    assert back["W_exp"] == pytest.approx(before["W_exp"], abs=0.1 * before["U_W_exp"])
    (tmp_path / "run_0001.csv").write_bytes((tmp_path / "other.csv").read_bytes())
    with pytest.raises(FormatError, match=r"not the file that run_0001\.csv\.json"):
        imported(tmp_path / "run_0001.csv", mapping, tmp_path / "b.h5")
