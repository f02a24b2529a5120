"""The loop-back: one voltage at both inputs tells the analyzer's own angle and gain, and nothing of
the sensors.
"""

import math
from pathlib import Path
from typing import Any

import pytest
from small_protocol import IDEAL, SMALL

from analysis.comparison.loop_back import LoopBack, loop_back_nulls
from daq import open_session
from rig.campaign.replayer import replay
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.protocol.load import load_protocol

ONE = ("vary={}", "scene.bed=loop_back", "repeats.n=3")
MEASURED = 1.5e-5  # rad: U of ANGLE_RESOLUTION (5e-6) and of the noise (2e-7 a run at half of 1 V), with room for k


def told(folder: Path, *sets: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """Report of a loop-back, and the actual instruments."""
    protocol = load_protocol(SMALL, sets=(*ONE, *sets))
    report = run(campaign_of(protocol, load_rig(protocol.rig), SMALL), folder, workers=1).document()
    with open_session(folder / "session.h5") as record:
        assert record.truth is not None
        return report, record.truth.document("instruments")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_drawn_skew_and_gain_are_found(tmp_path: Path, seed: int) -> None:
    report, actual = told(tmp_path, f"seed={seed}")
    (null,) = report["nulls"]
    skew = actual["acceleration"]["skew"] - actual["force"]["skew"]
    assert null["dphi"] == pytest.approx(2 * math.pi * 20 * skew, abs=MEASURED)
    assert null["gain"] == pytest.approx(
        actual["force"]["gain"] / actual["acceleration"]["gain"] - 1, abs=2e-4
    )
    assert null["verdict"] == "holds"
    assert null["U_gain"] == pytest.approx(1.96 * 0.003 * math.sqrt(2 / 3), rel=0.03)
    assert report["conditions"] == []  # nothing of it is an energy
    assert report["left_out"] == []


def test_corners_that_differ_are_found(tmp_path: Path) -> None:
    """Two 0.5 Hz corners, each off by up to 10 %, certified ones undone: atan(f_a/f) - atan(f_F/f)
    is left.
    """
    coupling = ("acquire.coupling={force: AC, acceleration: IEPE}", "acquire.settle=60")
    report, actual = told(tmp_path, *coupling)
    (null,) = report["nulls"]
    lead = [math.atan(actual[name]["corner"] / 20) for name in ("acceleration", "force")]
    skew = actual["acceleration"]["skew"] - actual["force"]["skew"]
    assert null["dphi"] == pytest.approx(lead[0] - lead[1] + 2 * math.pi * 20 * skew, abs=MEASURED)
    assert abs(null["dphi"]) > 5 * MEASURED


def test_ideal_inputs_are_equal(tmp_path: Path) -> None:
    report, _ = told(tmp_path, *IDEAL)
    (null,) = report["nulls"]
    # Rounding to 24 bits repeats every 512 samples: 0.29 codes of 1.2 uV in 0.5 V, times
    # sqrt(2/512); 10 of these
    assert abs(null["dphi"]) < 5e-7
    assert abs(null["gain"]) < 5e-7
    assert null["verdict"] == "holds"


def test_a_late_channel_does_not_hold(tmp_path: Path) -> None:
    """A sample, 98 us: 12 mrad at 20 Hz, four hundred times what the certificates of a real
    analyzer allow. The acceleration comes late, so that its lead is negative."""
    report, _ = told(tmp_path, "deliberate_error={skew: 1}", *IDEAL[:2])
    (null,) = report["nulls"]
    assert null["dphi"] == pytest.approx(-2 * math.pi * 20 / 10240, abs=MEASURED)
    assert null["verdict"] == "does not hold"
    assert report["verdict"] == "fails"
    assert any("loop-back" in reason for reason in report["failures"])


def test_it_goes_through_a_replay(tmp_path: Path) -> None:
    report, _ = told(tmp_path / "a")
    assert replay(tmp_path / "a" / "session.h5", tmp_path / "b").document() == report
    assert (tmp_path / "a" / "report.json").read_bytes() == (
        tmp_path / "b" / "report.json"
    ).read_bytes()


def test_coverage_of_the_certificates() -> None:
    """Skews uniform in +-s per channel: their difference lies within U (k = 1.96 over the root of two variances) in
    97.5 % of all pairs; triangular, P(|x| > 1.6 s) = (2 - 1.6)^2/4 = 4 %."""
    protocol = load_protocol(SMALL, sets=ONE)
    channels = {
        info.name: info
        for info in campaign_of(protocol, load_rig(protocol.rig), SMALL).instruments.table(
            10240.0, 39.0
        )
    }
    allowed = loop_back_nulls([LoopBack("r", 20.0, 0.0, 0.0, 1e-7)], channels)[0].dphi
    assert allowed is not None
    skew = 2 * math.pi * 20 * channels["force"].skew_tolerance
    assert (
        pytest.approx(1.96 * math.hypot(skew * math.sqrt(2 / 3), 5e-6 * math.sqrt(2)), rel=0.01)
        == allowed.U
    )
