"""Records exported for other tools, read by these tools' own libraries."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from imported_record import imported
from small_protocol import SMALL, Rig

from analysis import run_energy
from daq import open_session
from daq.formats.uff58 import write_uff58
from daq.formats.wave import Wave
from daq.formats.writing import sep005
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.cli.commands.exchange import exported_waves
from rig.protocol.load import load_protocol


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("export")
    sets = ("vary={}", "scene.bed=locked", "repeats.n=1", "acquire.settle=2", "acquire.record=8")
    protocol = load_protocol(SMALL, sets=sets)
    run(campaign_of(protocol, load_rig(protocol.rig), SMALL), out, workers=1)
    return out


@pytest.fixture(scope="module")
def waves(session: Path) -> tuple[Wave, ...]:
    with open_session(session / "session.h5") as record:
        made = exported_waves(record, record.run("run_0001"), raw=False)
        return tuple(replace(wave, signal=Held(wave.samples)) for wave in made)


@dataclass(frozen=True, eq=False)
class Held:
    """Samples in memory."""

    values: np.ndarray

    @property
    def size(self) -> int:
        return self.values.size

    def chunks(self, length: int = 64) -> Iterator[np.ndarray]:
        yield from (self.values[start : start + length] for start in range(0, self.size, length))

    def samples(self) -> np.ndarray:
        return self.values


def test_uff58_is_read_by_pyuff(
    rig_command: Rig, session: Path, waves: tuple[Wave, ...], tmp_path: Path
) -> None:
    pyuff = pytest.importorskip("pyuff")
    done = rig_command(
        "export", session, "--to", "uff58", "--run", "1", "--out", tmp_path / "r.uff"
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(tmp_path / "r.uff")
    force, acceleration, response = pyuff.UFF(str(tmp_path / "r.uff")).read_sets()
    for read, wave, number in ((force, waves[0], 13), (acceleration, waves[1], 12)):
        assert (read["func_type"], read["ordinate_spec_data_type"], read["binary"]) == (
            1,
            number,
            0,
        )
        # 13 significant digits of E20.12; 6 of the step in record 7
        np.testing.assert_allclose(read["data"], wave.samples, rtol=1e-12, atol=0)
        assert read["x"][1] == pytest.approx(1 / wave.rate, rel=1e-5)
        assert (read["id1"].strip(), read["ordinate_axis_units_lab"].strip()) == (
            wave.name,
            wave.unit,
        )
    assert (response["func_type"], response["orddenom_spec_data_type"]) == (4, 13)
    with open_session(session / "session.h5") as record:
        energy = run_energy(record, "run_0001").energy
    np.testing.assert_allclose(
        response["data"][0], energy.acceleration[0] / energy.force[0], rtol=1e-11
    )
    np.testing.assert_allclose(response["x"][:3], energy.frequency * np.array([1, 2, 3]))


def test_sep005_dicts_are_what_the_standard_says_and_feed_pyfrf(waves: tuple[Wave, ...]) -> None:
    validator = pytest.importorskip("sdypy_sep005.sep005")
    pyFRF = pytest.importorskip("pyFRF")
    entries = sep005(waves)
    validator.assert_sep005(entries)
    assert [entry["quantity"] for entry in entries] == ["f", "a"]
    last = 8 * 512  # whole cycles, so that the line of 20 Hz is one of the spectrum
    cut = [{**entry, "data": entry["data"][-last:]} for entry in entries]
    frf = pyFRF.FRF(
        sampling_freq=None, exc=cut[0], resp=cut[1], window="none", resp_type="a", exc_type="f"
    )
    line = int(np.argmin(np.abs(frf.get_f_axis() - 20.0)))
    apparent = 1 / abs(frf.get_FRF(frf_estimator="H1", frf_form="accelerance").ravel()[line])
    F, a = (np.fft.rfft(entry["data"])[line] for entry in cut)
    assert apparent == pytest.approx(
        abs(F / a), rel=1e-6
    )  # the same samples, by its estimator and by hand


def test_npz_csv_and_mat_hold_the_samples(
    rig_command: Rig, session: Path, waves: tuple[Wave, ...], tmp_path: Path
) -> None:
    for to, name in (("sep005-npz", "r.npz"), ("csv", "r.csv"), ("mat", "r.mat")):
        done = rig_command(
            "export", session, "--to", to, "--run", "run_0001", "--out", tmp_path / name
        )
        assert done.returncode == 0, done.stderr
    with np.load(tmp_path / "r.npz", allow_pickle=False) as arrays:
        told = json.loads(str(arrays["channels"]))
        np.testing.assert_array_equal(arrays["data_1"], waves[1].samples)
    assert (told[1]["name"], told[1]["unit_str"], told[1]["fs"]) == (
        "acceleration",
        "m/s^2",
        10240.0,
    )
    rows = np.loadtxt(tmp_path / "r.csv", delimiter=",", skiprows=1)
    np.testing.assert_array_equal(
        rows.T, np.stack([wave.samples for wave in waves])
    )  # 17 digits: bit for bit
    beside = json.loads((tmp_path / "r.csv.json").read_text())
    assert beside["rate"] == 10240.0
    assert beside["channels"]["force"]["unit"] == "N"
    values = scipy.io.loadmat(tmp_path / "r.mat")
    np.testing.assert_array_equal(values["force"][:, 0], waves[0].samples)
    assert values["fs"].item() == 10240.0


def test_all_runs_go_to_a_folder_and_wrong_words_are_refused(
    rig_command: Rig, session: Path, tmp_path: Path
) -> None:
    assert rig_command("export", session, "--to", "csv", "--out", tmp_path / "all").returncode == 0
    assert sorted(path.name for path in (tmp_path / "all").iterdir()) == [
        "run_0001.csv",
        "run_0001.csv.json",
    ]
    for words, found in (
        (("--to", "uff"), "did you mean 'uff58'"),
        (("--to", "csv", "--run", "7"), "run_0007"),
    ):
        done = rig_command("export", session, *words)
        assert done.returncode == 2
        assert found in done.stderr or "run_0001" in done.stderr


def test_an_export_round_trip_keeps_the_energy(
    session: Path, waves: tuple[Wave, ...], tmp_path: Path
) -> None:
    pytest.importorskip("pyuff")
    write_uff58(tmp_path / "r.uff", "round trip", waves)
    text = "schema: rig/map/1\nname: x\nforce: {channel: force}\nacceleration: {channel: acceleration}\nsettle: 0.1 s\n"
    back = imported(tmp_path, tmp_path / "r.uff", text)
    with open_session(session / "session.h5") as record:
        energy = run_energy(record, "run_0001").energy
    # The mapping above names no pole: compare what does not depend on it
    assert back.level == pytest.approx(energy.level, rel=2e-3)
    assert back.frequency == pytest.approx(20.0, rel=1e-5)
