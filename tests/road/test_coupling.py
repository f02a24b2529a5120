"""AC and IEPE coupling on the whole road: compensated by the certified corners, the rest stated as
an uncertainty.
"""

from pathlib import Path

import pytest
from small_protocol import IDEAL

from daq import open_session
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.protocol.load import load_protocol

TEXT = """\
schema: rig/protocol/1
name: coupled_inputs
scene: {grains: {material: stainless, diameter: 8 mm, fill: 85 %}}
acquire: {settle: 60 cycles, record: 40 cycles}
vary:
  scene.bed: [empty, layers, locked]
  drive.acceleration: [2 m/s^2, 3 m/s^2, 4 m/s^2]
repeats: 1
seed: 7
"""


def report(out: Path, *sets: str) -> dict:
    protocol = load_protocol(TEXT, sets)
    return run(campaign_of(protocol, load_rig(protocol.rig), TEXT), out).document()


def test_certified_corners_are_undone(tmp_path: Path) -> None:
    """Ideal but for a corner of 0.5 Hz in both channels, exactly certified: after 3 s, 9.4 of its
    time constants, what is left of the start is 25 mrad e^-9.4 = 2e-6 of the signal, and the
    ledger's energy comes out as without."""
    found = report(tmp_path, *IDEAL, "acquire.coupling=AC")
    for condition in found["conditions"]:
        if condition["bed"] == "layers":
            terms = condition["offset_terms"]
            assert abs(terms["phase"]) < 1e-4
            assert abs(terms["remainder"]) < 2e-4
    assert all(abs(null["dphi"]) < 2e-5 for null in found["nulls"])
    assert found["verdict"] == "passes"


@pytest.mark.parametrize("coupling", ["AC", "IEPE"])
def test_corners_ten_per_cent_apart_are_within_what_is_stated(
    tmp_path: Path, coupling: str
) -> None:
    """hardware.md: two 0.5 Hz corners 10 % apart give 5 mrad at 20 Hz. U of the angle: two
    rectangular halves of 2.5 mrad over sqrt(3), k = 2: 4 mrad; with DC coupling it is 1 mrad (the
    accelerometer's pole)."""
    found = report(tmp_path, f"acquire.coupling={coupling}")
    assert found["verdict"] == "passes"
    (null,) = found["nulls"]
    assert null["U_dphi"] == pytest.approx(4.2e-3, rel=0.1)
    assert abs(null["dphi"]) > 1e-4  # the corners that were drawn are not the certified ones
    assert abs(null["dphi"]) < null["U_dphi"]
    sources = {line["source"] for c in found["conditions"] for line in c["uncertainty"]}
    assert {"force coupling", "acceleration coupling", "skew"} <= sources
    for condition in found["conditions"]:
        if condition["offset_terms"] is not None:
            assert abs(condition["offset_terms"]["remainder"]) < condition["allowed_remainder"]
            assert abs(condition["offset_terms"]["phase"]) > 1e-4


def test_a_sensor_that_clips_in_impacts_is_flagged_though_the_record_shows_none(
    tmp_path: Path,
) -> None:
    """Few rows hit together: 2.2 kN for less than a sample is 5 V at the sensor, and 3 V after the
    filter.
    """
    few = (
        "vary={}",
        "scene.bed=layers",
        "scene.layers={rows: 2}",
        "drive.acceleration=6",
        "acquire.effects=[resonance]",
    )
    dc, iepe = (
        report(tmp_path / "dc", *few),
        report(tmp_path / "iepe", *few, "acquire.coupling=IEPE"),
    )
    (clipped,), (clean,) = (found["conditions"][0]["runs"] for found in (iepe, dc))
    assert "sensor_clip" in clipped["flags"]
    assert "sensor_clip" not in clean["flags"]
    assert iepe["verdict"] == "fails"
    with open_session(tmp_path / "iepe" / "session.h5") as record:
        force = record.signal("run_0001", "force")
        assert abs(force.samples).max() * record.channels["force"].sensitivity < 0.98 * 5.0
        assert record.blocks("run_0001")["clipped"].sum(axis=0).tolist()[1] == 0
