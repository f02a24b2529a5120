"""Bed `single_mass` in shaker-coupled drive on the whole road: the ledger is read, and a heavy box
gives the exact solution.
"""

from pathlib import Path

import numpy as np
import pytest

from rig.beds.janssen_stack import nominal
from rig.campaign.campaign import Campaign
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.drive.amplifier_command import Command
from rig.drive.dwell import phasors
from rig.protocol.load import load_protocol
from rig.stand.ledger import COLUMNS
from rig.stand.shaker import CoupledStand

SINGLE_MASS = """\
schema: rig/protocol/1
name: coupled_single_mass
scene:
  cavity: {length: 60 mm, width: 60 mm, height: 60 mm, wall: 30 mm}
  grains: {material: alumina, diameter: 2 mm, fill: 10 %}
  bed: single_mass
  single_mass: {restitution: 0, gap: 3 mm}
  losses: []
drive: {mode: shaker, frequency: 20 Hz, acceleration: 15 m/s^2}
acquire:
  settle: 20 cycles
  record: 20 cycles
  analyzer: ideal
  sensors: {force: ideal, acceleration: ideal}
vary:
  scene.axis: [horizontal, vertical, zero_gravity]
repeats: {n: 1, refill: false}
seed: 3
"""


def campaign(*sets: str) -> Campaign:
    protocol = load_protocol(SINGLE_MASS, sets)
    return campaign_of(protocol, load_rig(protocol.rig), SINGLE_MASS)


def test_a_single_mass_in_a_heavy_box_takes_what_it_takes_on_a_sine(tmp_path: Path) -> None:
    """Single mass over box is 0.4 %: as much the levels of its landings give way, and W goes with
    their square or cube.
    """
    report = run(campaign(), tmp_path, workers=1).document()
    assert report["ledger"]["closure_max"] < 1e-6
    assert len(report["conditions"]) == 3
    for condition in report["conditions"]:
        assert condition["runs"][0]["flags"] == []
        assert abs(condition["E_n_truth"]) <= 1.0
        assert condition["W_exp"] == pytest.approx(condition["W_T"], rel=3 * 0.0042)
        assert condition["W_T_recorded"] is None


def test_a_single_mass_that_never_leaves_the_floor_of_a_light_box_loses_nothing() -> None:
    """0.8 g, a fifth of the box's mass: what rests on the floor is held there, whatever the stinger's mode."""
    found = campaign(
        "scene.cavity={length: 40 mm, width: 40 mm, height: 60 mm, wall: 2 mm}",
        "scene.grains.material=stainless",
    )
    rig, condition = found.rig, next(c for c in found.conditions if c.scene.axis == "vertical")
    scene = condition.scene
    stand = CoupledStand(scene, rig, condition.drive, nominal(scene, rig), 4096 * 20.0)
    stand.advance(Command((0.8 + 0j,), 20.0, 10))
    stand.drain_ledger()
    signals = stand.advance(Command((0.8 + 0j,), 20.0, 10))
    level, ledger = abs(phasors(signals[1], 0, 4096 * 20.0, 20.0, 1)[0]), stand.drain_ledger()
    assert 0.7 * rig.gravity < level < 0.9 * rig.gravity
    assert np.abs(signals[1]).max() < 1.02 * level
    # against the energy that goes back and forth in the single mass
    moved = stand.bed_mass * level**2 / (2 * np.pi * 20.0) ** 2
    assert np.abs(ledger[:, COLUMNS.index("W_c")]).max() < 1e-5 * moved


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_a_box_without_a_lid_is_one_whose_lid_is_out_of_reach(restitution: float) -> None:
    """A single mass on the floor is held there within a fraction of its gap: without a lid that was
    0.1 m, and no flight so low ever landed."""
    taken = []
    for gap in (0.055, "none"):
        made = campaign(
            "scene.axis=vertical",
            f"scene.single_mass={{restitution: {restitution}, gap: {gap}}}",
            "vary={}",
        )
        (condition,) = made.conditions
        filling = nominal(condition.scene, made.rig)
        stand = CoupledStand(condition.scene, made.rig, condition.drive, filling, 4000 * 20.0)
        stand.advance(Command((12.0 + 0j,), 20.0, 20))
        taken.append(stand.drain_ledger()[:, COLUMNS.index("W_c")])
    assert taken[0][-1] > 1e-4
    np.testing.assert_allclose(taken[1], taken[0], rtol=1e-6, atol=1e-12)
