"""Shaker-coupled drive on the whole road: level control, flags, two estimates of W, W_T on what was
recorded, resume.
"""

import json
from pathlib import Path
from typing import Any

import pytest

from analysis import read_session
from daq.session.record import open_session
from rig.beds.janssen_stack import nominal
from rig.campaign.campaign import Campaign
from rig.campaign.one_run.coupled_dwell import Dwelling
from rig.campaign.preflight.outlook import outlook
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.protocol.load import load_protocol

FEW = """\
schema: rig/protocol/1
name: few
rig: paper
scene: {grains: {material: stainless, diameter: 12 mm, fill: 85 %}, losses: [noise, air]}
drive: {mode: shaker}
acquire: {settle: 10 cycles, record: 20 cycles, exciter_channels: true}
vary:
  scene.bed: [empty, locked, dashpot, layers]
  drive.acceleration: [2 m/s^2, 4 m/s^2]
repeats: {n: 1, refill: false}
seed: 3
"""
IDEAL = (
    "acquire.analyzer=ideal",
    "acquire.sensors={force: ideal, acceleration: ideal, current: ideal, voltage: ideal}",
)


def campaign(*sets: str, vary: tuple[str, ...] = ()) -> Campaign:
    protocol = load_protocol(FEW, sets, vary)
    return campaign_of(protocol, load_rig(protocol.rig), FEW)


@pytest.fixture(scope="module")
def few(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The few conditions with ideal instruments, run once."""
    out = tmp_path_factory.mktemp("few")
    run(campaign(*IDEAL), out, workers=2)
    return out


def report_of(folder: Path) -> dict[str, Any]:
    return json.loads((folder / "report.json").read_text())


def test_the_level_is_reached_and_the_session_says_how(few: Path) -> None:
    """1 % is the loop's own tolerance; where the bed scatters the level, its mean over 7 cycles has
    2 % of its own.
    """
    report = report_of(few)
    assert "No run is overloaded or faulted." in report["reasons"]
    assert report["waveform"] == "measured"
    for condition in report["conditions"]:
        assert condition["drive"] == "shaker"
        allowed = 0.03 if condition["bed"] == "layers" else 0.011
        assert condition["acceleration"] == pytest.approx(
            condition["acceleration_set"], rel=allowed
        )
        assert condition["runs"][0]["flags"] == []
    with open_session(few / "session.h5") as record:
        for info in record.runs:
            scalars = record.scalars(info.name)
            assert 5 <= scalars["level_cycles"] <= 60
            assert scalars["clipped"] == 0.0
            assert not any(
                value for name, value in scalars.items() if name.startswith("stopped_by")
            )


def test_both_energies_are_the_ledgers(few: Path) -> None:
    """Gauge and coil, without errors of instruments: within what the arithmetic is granted (1e-4,
    5e-6 rad); the coil reads the mean cycle, which leaves out what does not repeat (below 1 % here,
    and told by W_phasor)."""
    report = report_of(few)
    for condition in report["conditions"]:
        assert abs(condition["E_n_truth"]) <= 1.0
        coherent = condition["runs"][0]["W_phasor"]
        assert condition["W_coil"] == pytest.approx(
            coherent, rel=2e-4, abs=1e-3 * condition["U_W_coil"]
        )
    assert report["ledger"]["closure_max"] < 1e-6


def test_only_a_bed_that_slides_distorts_the_waveform_and_has_a_prediction(few: Path) -> None:
    for condition in report_of(few)["conditions"]:
        if condition["bed"] == "layers":
            assert condition["thd_acceleration"] > 0.03
            assert condition["W_T_recorded"] < condition["W_T"]
            terms = condition["offset_terms"]
            lost = condition["W_T"] * (terms["noise"] + terms["air"])
            # the nominal bed: what is left is its history and 20 cycles of some 200 rows, 3
            # standard uncertainties
            left = condition["W_exp"] - lost - condition["W_T_recorded"]
            assert abs(left) <= 3 * condition["U_W_T_recorded"] / 1.96
        else:
            assert condition["thd_acceleration"] < 0.02
            assert condition["W_T_recorded"] == 0.0
        assert condition["thd_box"] == condition["thd_acceleration"]


def test_a_dashpot_takes_its_closed_form(few: Path) -> None:
    """pi c a^2/w^3 beside the losses of the empty box, harmonics of the losses below 1 %."""
    rows = {(c["bed"], c["acceleration_set"]): c for c in report_of(few)["conditions"]}
    for level in (2.0, 4.0):
        dashpot, empty = rows["dashpot", level], rows["empty", level]
        tare = empty["W_exp"] * (dashpot["acceleration"] / empty["acceleration"]) ** 2
        omega = 2 * 3.141592653589793 * 20.0
        exact = 3.141592653589793 * 50.0 * dashpot["acceleration"] ** 2 / omega**3
        assert dashpot["W_exp"] - tare == pytest.approx(exact, rel=0.02)


def test_the_report_comes_from_the_record_alone(few: Path) -> None:
    with open_session(few / "session.h5") as record:
        assert json.dumps(read_session(record).document()) == json.dumps(report_of(few))


def test_an_interrupted_session_goes_on_to_the_same_bytes(tmp_path: Path, few: Path) -> None:
    def stop(progress: Any) -> None:
        if progress.done == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(campaign(*IDEAL), tmp_path, workers=2, progress=stop)
    run(campaign(*IDEAL), tmp_path, workers=1, resume=True)
    assert report_of(tmp_path) == report_of(few)


LIMITS = {
    # 300 N and 25 A times 12 N/A are one and the same
    "force": (("drive.acceleration=12", "scene.bed=locked"), {"force", "current"}),
    "stroke": (("drive.acceleration=8", "drive.frequency=8", "scene.bed=empty"), {"stroke"}),
}


@pytest.mark.parametrize("limit", LIMITS)
def test_a_level_beyond_the_exciter_names_the_limit(tmp_path: Path, limit: str) -> None:
    sets, names = LIMITS[limit]
    bed, level = next(s for s in sets if "bed" in s), next(s for s in sets if "acc" in s)
    found = campaign(
        *sets,
        vary=(f"scene.bed=[{bed.split('=')[1]}]", f"drive.acceleration=[{level.split('=')[1]}]"),
    )
    report = run(found, tmp_path, workers=1).document()
    assert report["verdict"] == "fails"
    flags = report["conditions"][0]["runs"][0]["flags"]
    assert {flag.removeprefix("level_not_reached_") for flag in flags} & names
    assert report["conditions"][0]["acceleration"] < report["conditions"][0]["acceleration_set"]
    ahead = outlook(found, found.conditions[0])
    assert ahead.stopped in names
    assert any("level is not reached" in flag for flag in ahead.beyond)


def test_looking_ahead_is_at_the_first_runs_own_bed(tmp_path: Path) -> None:
    """Peaks of force and acceleration over 16 cycles are those of 20 cycles of its record to a
    third (impacts scatter), and what it takes to a tenth. The nominal bed, all of whose layers are
    alike, takes 16 % less here."""
    found = campaign(
        *IDEAL,
        "repeats={n: 1, refill: true}",
        vary=("scene.bed=[layers]", "drive.acceleration=[5]"),
    )
    ahead = outlook(found, found.conditions[0])
    report = run(found, tmp_path, workers=1).document()
    with open_session(tmp_path / "session.h5") as record:
        info = record.runs[0]
        signals = {
            name: record.signal(info.name, name, 0, info.samples).samples
            for name in ("force", "acceleration")
        }
        peaks = {name: float(abs(signal).max()) for name, signal in signals.items()}
        ranges = {
            name: record.channels[name].range_V / record.channels[name].sensitivity
            for name in peaks
        }
    assert ahead.range_acceleration == pytest.approx(
        peaks["acceleration"] / ranges["acceleration"], rel=0.33
    )
    assert ahead.range_force == pytest.approx(peaks["force"] / ranges["force"], rel=0.33)
    assert ahead.W_exp == pytest.approx(report["conditions"][0]["W_exp"], rel=0.1)


def test_open_loop_holds_the_command_and_predicts_no_sine(tmp_path: Path) -> None:
    """1 V on the empty box at 20 Hz: the level is the response of exciter and box; W_T on a sine is
    not stated.
    """
    found = campaign(
        "drive={mode: shaker, control: open, command: 2.5 %}",
        "acquire.settle=30",
        vary=("scene.bed=[empty, layers]", "drive.acceleration=[1]"),
    )
    report = run(found, tmp_path, workers=1).document()
    for condition in report["conditions"]:
        assert condition["W_T"] is None
        assert condition["W_T_recorded"] is not None
        assert condition["runs"][0]["flags"] == []
        assert condition["force"] == pytest.approx(
            condition["M_eff"] * condition["acceleration"], rel=0.05
        )


def test_a_dwell_from_above_comes_down_to_the_level() -> None:
    """And has been higher: hysteresis of a bed shows between the two approaches."""
    rig = load_rig("paper")
    highest = {}
    for approach in ("below", "above"):
        condition = campaign(f"drive.approach={approach}").conditions[-2]
        dwelling = Dwelling(condition, rig, nominal(condition.scene, rig), 4096 * 20.0)
        seen = [0.0]
        while dwelling.dwell.steady_from is None:
            dwelling.stand.read(4096)
            seen.append(dwelling.dwell.loop.level)
        highest[approach] = max(seen)
        assert dwelling.dwell.loop.status == "reached"
        assert dwelling.dwell.loop.level == pytest.approx(2.0, rel=0.02)
    assert highest["above"] > 2.4
    assert highest["below"] < 2.1


def test_the_same_beds_are_poured_in_both_drives() -> None:
    keys = {
        mode: [c.seed_key for c in campaign(f"drive.mode={mode}").conditions]
        for mode in ("prescribed", "shaker")
    }
    assert keys["prescribed"] == keys["shaker"]
