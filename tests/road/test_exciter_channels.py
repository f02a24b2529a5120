"""Coil current and drive voltage on the whole road: recorded, read, and a second estimate of the
energy.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from small_protocol import SMALL

from analysis import read_session
from daq.session.record import open_session
from rig.beds.janssen_stack import nominal
from rig.campaign.campaign import Campaign
from rig.campaign.one_run.assemble import assemble
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.drive.exciter_limits import demand, solvable_band
from rig.drive.waveform import Waveform
from rig.errors import InputError
from rig.protocol.grid import conditions
from rig.protocol.load import load_protocol
from rig.protocol.spec import Scene
from rig.stand.exciter_channels import WithExciter
from rig.stand.prescribed import Stand

FOUR = ("acquire.exciter_channels=true",)
IDEAL = (
    "acquire.analyzer=ideal",
    "acquire.sensors={force: ideal, acceleration: ideal, current: ideal, voltage: ideal}",
    "drive.imperfection=none",
)


def campaign(*sets: str) -> Campaign:
    protocol = load_protocol(SMALL, sets)
    return campaign_of(protocol, load_rig(protocol.rig), SMALL)


def test_the_coil_gives_the_same_energy_without_instrument_errors(tmp_path: Path) -> None:
    """Within the arithmetic that every comparison is granted: 1e-4 of W and 5e-6 rad of the
    reactive energy.
    """
    report = run(campaign(*FOUR, *IDEAL, "repeats=1"), tmp_path, workers=2).document()
    with open_session(tmp_path / "session.h5") as record:
        assert list(record.channels) == ["force", "acceleration", "current", "voltage"]
        assert record.channels["current"].unit == "A"
    for condition in report["conditions"]:
        reactive = (
            np.pi * condition["M_eff"] * (condition["acceleration"] / (2 * np.pi * 20.0)) ** 2
        )
        allowed = 1e-4 * condition["W_exp"] + 5e-6 * reactive
        assert condition["W_coil"] == pytest.approx(condition["W_exp"], abs=allowed)
        assert condition["runs"][0]["W_coil"] == condition["W_coil"]


def test_nominal_instruments_state_how_far_the_estimates_may_part(tmp_path: Path) -> None:
    """Outside in at most one condition of nine, 5 % of each being allowed and most errors shared."""
    report = run(campaign(*FOUR), tmp_path, workers=2).document()
    found = [condition["E_n_coil"] for condition in report["conditions"]]
    assert sum(abs(E_n) > 1 for E_n in found) <= 1
    assert all(c["U_W_coil"] > 0 for c in report["conditions"])
    assert [row["channel"] for row in report["instruments"]] == [
        "force",
        "acceleration",
        "current",
        "voltage",
    ]
    assert "Energy from the coil's current" in (tmp_path / "report.md").read_text()
    with open_session(tmp_path / "session.h5") as record:
        assert json.dumps(read_session(record).document()) == json.dumps(report)


def test_without_the_channel_nothing_is_said(tmp_path: Path) -> None:
    report = run(
        campaign("repeats=1", "scene.bed=empty", "drive.acceleration=3"), tmp_path, workers=1
    ).document()
    assert all(c["W_coil"] is None and c["runs"][0]["W_coil"] is None for c in report["conditions"])
    assert "coil's current" not in (tmp_path / "report.md").read_text()


def test_the_first_two_channels_do_not_know_of_the_others() -> None:
    two, four = (campaign(*sets) for sets in ((), FOUR))
    blocks = [next(iter(assemble(found, found.runs[3]))).block for found in (two, four)]
    assert (blocks[0].codes == blocks[1].codes[:2]).all()


def test_current_and_voltage_are_what_the_demand_says() -> None:
    """Fundamental of the recorded channels against the utilisation of the limits that `demand` states."""
    rig, motion = load_rig("paper"), Waveform(20.0, 4.0)
    scene = conditions(load_protocol(SMALL))[4].scene
    stand = Stand(scene, rig, motion, nominal(scene, rig), 4096 * 20.0)
    source = WithExciter(stand, rig.exciter)
    signal = np.concatenate([source.read(n) for n in (1, 9999, 12 * 4096 - 10000)], axis=1)
    last = np.fft.rfft(signal[:, -2 * 4096 :]) / 4096
    use = demand(
        rig.exciter, signal[0, -2 * 4096 :], stand.rate, motion, solvable_band(rig.exciter)
    )
    # the chunk starts one edge before the cycle does, and interval means lose (w h)^2/24 = 1e-7
    assert abs(last[2, 2]) == pytest.approx(use.current * rig.exciter.current_peak, rel=1e-3)
    assert abs(last[3, 2]) == pytest.approx(use.voltage * rig.exciter.voltage_peak, rel=1e-3)


def test_reads_of_any_size_give_the_same_stream() -> None:
    rig, motion, scene = load_rig("paper"), Waveform(20.0, 4.0), Scene(bed="empty")
    sources = [
        WithExciter(Stand(scene, rig, motion, nominal(scene, rig), 4096.7 * 20.0), rig.exciter)
        for _ in range(2)
    ]
    pieces = np.concatenate([sources[0].read(n) for n in (1, 8000, 12000)], axis=1)
    assert (pieces == sources[1].read(20001)).all()


def test_ac_coupling_in_disguise_needs_two_channels() -> None:
    with pytest.raises(InputError, match=r"deliberate_error.corners"):
        load_protocol(SMALL + "deliberate_error: {corners: 0.1}\n", FOUR)
