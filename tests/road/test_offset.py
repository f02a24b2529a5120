"""The terms of an offset in whole sessions: zero where all is ideal, what ledger and ablation say
where it is not.
"""

import json
import math
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import pytest
from small_protocol import IDEAL

from analysis import read_session
from analysis.comparison.offset_terms import LARGEST_REMAINDER
from analysis.results.condition_row import TERMS
from daq.session.record import open_session
from rig.campaign.campaign import Campaign
from rig.campaign.loss_calibration import calibrated
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.errors import InputError
from rig.protocol.load import load_protocol

PROTOCOL = """\
schema: rig/protocol/1
name: offsets
scene: {grains: {material: stainless, diameter: 8 mm, fill: 40 %}, losses: [noise, air, gas, mount], support: guide}
acquire: {settle: 30 cycles, record: 24 cycles}
vary:
  drive.acceleration: [2.5 m/s^2, 3 m/s^2]
repeats: 4
seed: 7
"""
STILL = (*IDEAL, "repeats.refill=false")

Rows = list[dict[str, Any]]


def campaign(*sets: str, seed: int | None = None) -> Campaign:
    protocol = load_protocol(PROTOCOL, sets, seed=seed)
    return campaign_of(protocol, load_rig(protocol.rig), PROTOCOL)


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Rows]:
    """Conditions of a report by the settings that differ; each session is made once."""
    made: dict[tuple[str, ...], Rows] = {}

    def conditions(*sets: str) -> Rows:
        if sets not in made:
            made[sets] = run(
                campaign(*sets), tmp_path_factory.mktemp("offset"), workers=2
            ).document()["conditions"]
        return made[sets]

    return conditions


def test_nothing_is_off_where_all_is_ideal(rows: Callable[..., Rows]) -> None:
    """No losses, exact waveform, nominal bed, ideal instruments: W_exp is W_T. Rows are past their
    transients after 30 cycles; 1e-4 is what interval means and the reading of impacts leave
    (tests/physics/test_stand.py, 6e-5)."""
    for row in rows(*STILL, "scene.losses=[]"):
        assert row["periodic_share"] == 1.0
        assert abs(row["offset"]) < 1e-4
        assert all(abs(term) < 1e-4 for term in row["offset_terms"].values())


def test_switching_the_losses_on_adds_their_terms_and_nothing_else(
    rows: Callable[..., Rows],
) -> None:
    """Ablation: the same beds with and without losses differ by the ledger's terms (readings as
    above).
    """
    for on, off in zip(rows(*STILL), rows(*STILL, "scene.losses=[]"), strict=True):
        terms = on["offset_terms"]
        lost = math.fsum(terms[name] for name in ("noise", "air", "gas", "mount"))
        assert on["offset"] - off["offset"] == pytest.approx(lost, abs=1e-4)
        assert terms["mount"] > 0.0
        assert terms["gas"] == 0.0  # below 1 % of the weight


def test_the_guide_takes_the_moving_weight(rows: Callable[..., Rows]) -> None:
    """4 mu M g X of W_T; M_eff is not the moving mass where grains slip: mass of the box, gauge
    side and bed.
    """
    rig, first = load_rig("paper"), campaign(*STILL).conditions[0]
    box = 7850.0 * (0.16 * 0.16 * 0.41 - 0.15 * 0.15 * 0.4)
    for row in rows(*STILL):
        mass = box + rig.gauge_mass + row["bed_mass"]
        X = row["acceleration_set"] / (2 * math.pi * first.drive.frequency) ** 2
        expected = 4.0 * rig.guide_friction * mass * rig.gravity * X / row["W_T"]
        assert row["offset_terms"]["mount"] == pytest.approx(
            expected, rel=1e-4
        )  # W_T at the measured level


def test_real_instruments_leave_no_remainder(rows: Callable[..., Rows]) -> None:
    for row in rows():
        terms = row["offset_terms"]
        assert tuple(terms) == TERMS
        assert math.fsum(terms.values()) == pytest.approx(row["offset"], abs=1e-12)
        assert abs(terms["remainder"]) < LARGEST_REMAINDER == row["allowed_remainder"]
        assert terms["scale"] != 0.0


def test_an_ablation_parts_the_waveform_from_the_refill(tmp_path: Path) -> None:
    """Nominal beds in an imperfect waveform: what they take beyond W_T is the waveform's. With no
    ablation it stays in the refill; either way the sum is the same, and so is every measured
    number."""
    still = campaign("repeats.refill=false", "scene.losses=[]")
    still = replace(still, rig=replace(still.rig, level_error=0.0))
    reports = [
        run(replace(still, ablate=ablate), tmp_path / str(ablate), workers=2).document()
        for ablate in (False, True)
    ]
    for plain, parted in zip(*(report["conditions"] for report in reports), strict=True):
        whole, parts = plain["offset_terms"], parted["offset_terms"]
        assert whole["waveform"] == 0.0
        assert parts["waveform"] != 0.0
        # the level is the set one, where W_T is tabulated; the clock is off by 5e-5, dlnW/dlnf is
        # of order 1
        assert abs(parts["refill"]) < 3e-4
        assert whole["refill"] == pytest.approx(parts["waveform"] + parts["refill"], abs=1e-12)
        assert plain["W_exp"] == parted["W_exp"]
        assert plain["offset"] == parted["offset"]


def test_an_exact_waveform_has_no_waveform_term(tmp_path: Path) -> None:
    exact = replace(campaign("drive.imperfection=none"), ablate=True)
    for row in run(exact, tmp_path, workers=2).document()["conditions"]:
        assert abs(row["offset_terms"]["waveform"]) < 1e-12


def test_terms_need_truth_and_nothing_else_does(tmp_path: Path) -> None:
    run(campaign(), tmp_path, workers=1)
    with_truth = json.loads((tmp_path / "report.json").read_text())["conditions"]
    shutil.copy(tmp_path / "session.h5", tmp_path / "stripped.h5")
    with h5py.File(tmp_path / "stripped.h5", "r+") as file:
        del file["session/truth"]
        for name in file:
            if name.startswith("run_"):
                del file[name]["truth"]
    with open_session(tmp_path / "stripped.h5") as record:
        without = json.loads(json.dumps(read_session(record).document()))["conditions"]
    fed = {"offset_terms", "E_n_truth", "dKE_bed"}
    for one, other in zip(with_truth, without, strict=True):
        assert one["offset_terms"] is not None
        assert other["offset_terms"] is None
        assert {k: v for k, v in one.items() if k not in fed} == {
            k: v for k, v in other.items() if k not in fed
        }


def test_calibration_refuses_sensors_whose_null_fails() -> None:
    """A pole at a third of its certified time constant turns 10 mrad at 20 Hz; the certificate
    allows a tenth of it.
    """
    sound = campaign(*STILL[2:])
    assert calibrated(sound, 1.0, 1).loss_noise > 0.0
    force, acceleration = sound.instruments.states
    states = (force, replace(acceleration, time_constant=(acceleration.time_constant or 0.0) / 3.0))
    with pytest.raises(InputError, match="null angle"):
        calibrated(replace(sound, instruments=replace(sound.instruments, states=states)), 1.0, 1)
