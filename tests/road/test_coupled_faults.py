"""The record's checks where the exciter sets the motion: impacts are no fault, and what can be told
of a fault is.
"""

from pathlib import Path
from typing import Any

import pytest

from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.protocol.load import load_protocol

SHIPPED = Path(__file__).parents[2] / "protocols" / "shaker_fill.yaml"
FAULTS = """\
schema: rig/protocol/1
name: faulty_coupled
scene: {grains: {material: stainless, diameter: 4 mm, fill: 85 %}, losses: [noise, air]}
drive: {mode: shaker}
acquire: {settle: 10 cycles, record: 40 cycles}
vary: {drive.acceleration: [2 m/s^2, 5 m/s^2]}
repeats: {n: 6, refill: true}
seed: 7
faults:
  - {kind: noise, channel: force, start: 30, duration: 10, size: 2 %, repeat: 2}
  - {kind: clock_slip, channel: force, start: 30, size: 1, repeat: 3}
  - {kind: noise, channel: acceleration, start: 30, duration: 10, size: 2 %, repeat: 4}
  - {kind: clock_slip, channel: acceleration, start: 30, size: 1, repeat: 5}
  - {kind: noise, channel: acceleration, start: 0, size: 0.1 %, repeat: 6}
"""


def runs(
    text: str, out: Path, *sets: str, vary: tuple[str, ...] = ()
) -> dict[tuple[Any, ...], dict[str, Any]]:
    protocol = load_protocol(text, sets, vary)
    found = run(campaign_of(protocol, load_rig(protocol.rig), text), out, workers=1).document()
    return {
        (c["fill"], c["acceleration_set"], r["repeat"]): r
        for c in found["conditions"]
        for r in c["runs"]
    }


@pytest.mark.parametrize(
    ("fills", "levels", "sets"),
    [
        # at the shipped seed: here sharp impacts and gliding phases were taken for noise and for
        # slips of the clock
        ("30 %, 50 %, 95 %", "4 m/s^2, 5 m/s^2", ("repeats.n=2",)),
        pytest.param(
            "70 %, 80 %, 90 %, 100 %", "4 m/s^2, 5 m/s^2", ("seed=11",), marks=pytest.mark.slow
        ),
        pytest.param(
            "30 %, 50 %, 80 %, 95 %",
            "3 m/s^2, 4 m/s^2, 5 m/s^2",
            ("seed=7",),
            marks=pytest.mark.slow,
        ),
    ],
)
def test_impacts_of_a_healthy_bed_are_no_fault(
    tmp_path: Path, fills: str, levels: str, sets: tuple[str, ...]
) -> None:
    vary = (f"scene.grains.fill=[{fills}]", f"drive.acceleration=[{levels}]")
    found = runs(SHIPPED.read_text(), tmp_path, *sets, vary=vary)
    assert found
    assert {key: entry["flags"] for key, entry in found.items() if entry["flags"]} == {}


def test_faults_are_detected_in_the_force_and_between_rare_impacts(tmp_path: Path) -> None:
    """docs/acquisition.md: noise and slips at the force at any level, at the acceleration where
    impacts leave it quiet; noise that was there all along cannot be distinguished from anything."""
    found = runs(FAULTS, tmp_path)
    for (_, level, repeat), entry in found.items():
        if repeat in (1, 6):
            assert entry["flags"] == []
        elif repeat in (2, 3):
            assert entry["flags"] == [("noisy_force", "clock_slip_force")[repeat - 2]]
        elif level == 2.0:
            assert entry["flags"] == [("noisy_acceleration", "clock_slip_acceleration")[repeat - 4]]
        else:
            assert set(entry["flags"]) <= {
                ("noisy_acceleration", "clock_slip_acceleration")[repeat - 4]
            }
