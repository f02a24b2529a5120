"""W_T on the recorded waveform, on the whole road."""

from pathlib import Path

import h5py
import numpy as np
import pytest
from small_protocol import SMALL

from analysis import run_energy
from daq import open_session
from rig.campaign.campaign import Campaign
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.protocol.load import load_protocol

IDEAL = (
    "acquire.analyzer=ideal",
    "acquire.sensors={force: ideal, acceleration: ideal}",
    "drive.imperfection=none",
    "repeats=1",
)


EARLY = ("drive.acceleration=[2 m/s^2, 3 m/s^2]",)
"""Levels at which all rows of the small protocol repeat themselves soon: at 4 m/s^2 some wander
through the record and take 2 % more than in the end, where W_T is taken."""


def report(out: Path, *sets: str, ablate: bool = True, varies: tuple[str, ...] = ()) -> dict:
    protocol = load_protocol(SMALL, sets, varies)
    found = campaign_of(protocol, load_rig(protocol.rig), SMALL)
    return run(Campaign(**{**vars(found), "ablate": ablate}), out, workers=2).document()


def test_an_exact_sine_gives_the_sines_energy(tmp_path: Path) -> None:
    """Within what averaging over 40 cycles costs: 0.5 % stated as standard uncertainty, so 2 %; and
    exactly on average of a lot of rows (tests/physics)."""
    told = report(tmp_path, *IDEAL, varies=EARLY)
    for condition in told["conditions"]:
        assert condition["W_T_recorded"] == pytest.approx(condition["W_T"], rel=2e-2)
    assert told["agreement"]["ratio_recorded"] == pytest.approx(
        told["agreement"]["ratio"], rel=2e-2
    )


def test_nominal_instruments_and_a_disturbed_waveform(tmp_path: Path) -> None:
    """0.3 % of third harmonic and the instruments' noise: still the sine's energy within 3 %."""
    told = report(tmp_path)
    for condition in told["conditions"]:
        assert condition["W_T_recorded"] == pytest.approx(condition["W_T"], rel=0.03)
        assert condition["thd_acceleration"] == pytest.approx(0.003, rel=0.1)
    sliding = next(c for c in told["conditions"] if c["bed"] == "layers")
    assert sliding["U_W_T_recorded"] > 0
    assert "Recorded waveform" in (tmp_path / "report.md").read_text()


def test_it_is_not_computed_where_nobody_asked(tmp_path: Path) -> None:
    told = report(tmp_path, "repeats=1", "scene.bed=layers", "drive.acceleration=2", ablate=False)
    assert all(c["W_T_recorded"] is None for c in told["conditions"])
    assert "Recorded waveform" not in (tmp_path / "report.md").read_text()


def test_with_the_exciter_in_the_loop_the_ablation_is_not_known(tmp_path: Path) -> None:
    """The exact waveform is one of prescribed motion alone: its column holds nan, the offset takes
    W_T_recorded.
    """
    sets = ("drive.mode=shaker", "repeats=1", "scene.bed=layers", "acquire.record=6 cycles")
    told = [report(tmp_path / str(ablate), *sets, ablate=ablate) for ablate in (False, True)]
    assert [c["offset_terms"] for c in told[1]["conditions"]] == [
        c["offset_terms"] for c in told[0]["conditions"]
    ]
    assert all(c["offset_terms"] is not None for c in told[1]["conditions"])


def test_a_ledger_with_gaps_is_none(tmp_path: Path) -> None:
    """In any other column nan leaves nothing of the account."""
    report(tmp_path, "repeats=1", "scene.bed=locked", ablate=False)
    with h5py.File(tmp_path / "session.h5", "r+") as file:
        file["run_0001/truth/ledger"][20, 0] = np.nan
    with open_session(tmp_path / "session.h5") as record:
        assert run_energy(record, "run_0001").ledger is None
