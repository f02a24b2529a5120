"""Rows that doze: what is left out of the steps changes nothing."""

from dataclasses import replace

import numpy as np
import pytest

from rig.beds.coupled_step import TWO_WAY, TwoWay
from rig.beds.janssen_stack import nominal
from rig.catalog.entries import Rig
from rig.drive.amplifier_command import Command
from rig.kernels.rows.sleeping import LEAST_ROWS, SLACK, fall_asleep, population, wake
from rig.kernels.rows.tiles import from_tiles, to_tiles
from rig.protocol.spec import Drive, Scene
from rig.stand.ledger import COLUMNS
from rig.stand.shaker import CoupledStand

RATE = 4096 * 20.0


def sliding(rig: Rig, scene: Scene, copies: int) -> CoupledStand:
    """48 rows of scattered friction and speed in unlimited space, each cut into equal ones."""
    rng = np.random.default_rng(1)
    band, speed = rng.uniform(0.0, 3.0, 48), rng.normal(0.0, 0.05, 48)
    bed = TwoWay(0.0, 0.0, 0.3 / copies, 0.5, np.tile(band, copies), np.full(48 * copies, 1e3))
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(TWO_WAY, "layers", lambda *_: bed)
        stand = CoupledStand(
            scene, rig, Drive(mode="shaker", amplifier="current"), nominal(scene, rig), RATE
        )
    stand._u[:] = 500.0
    stand._w[:] = np.tile(speed, copies)
    stand._lo[:], stand._hi[:] = -bed.band, bed.band
    return stand


def test_rows_cut_in_four_move_the_box_as_whole_ones(rig: Rig, steel: Scene) -> None:
    """48 rows are always awake, 192 doze; same box, same heat. Where slips end is found in other
    sums: round-off grows through the steps, to 1e-9 of the velocity."""
    scene = replace(steel, losses=())
    few, many = (sliding(rig, scene, copies) for copies in (1, 4))
    assert few.bed.band.size < LEAST_ROWS <= many.bed.band.size
    for _ in range(6):
        command = Command((12.0 + 0j,), 20.0)
        assert few.advance(command) == pytest.approx(many.advance(command), rel=1e-6, abs=1e-6)
    assert many.state == pytest.approx(few.state, rel=1e-8, abs=1e-10)
    assert many._w.reshape(4, -1) == pytest.approx(np.tile(few._w, (4, 1)), abs=1e-9)
    heat = [stand.drain_ledger()[:, COLUMNS.index("W_f")] for stand in (few, many)]
    assert heat[1] == pytest.approx(heat[0], rel=1e-8)


def test_who_dozes_slides_on_and_meets_no_wall() -> None:
    """By brute force: a row dozes only if it slides the same way and stays between its walls
    whatever the box does within the slack; most rows of this kind do. Waking moves it by the closed
    form."""
    rng = np.random.default_rng(2)
    n, ahead, slack, speed = 500, 6e-4, 0.01, 0.03
    w, band, clearance = (
        rng.normal(0.0, 0.05, n),
        rng.uniform(0.1, 3.0, n),
        rng.uniform(1e-4, 2e-3, n),
    )
    u = rng.uniform(0.0, 1.0, n) * clearance
    grouped = population(to_tiles(w, u, -band, band, band, clearance), np.uint64(n))
    grouped.sleep[SLACK] = slack
    count = int(fall_asleep(0.0, speed, ahead, 0.0, np.uint64(n), grouped))
    awake = {int(place) for place in grouped.places[:count]}
    asleep = np.array(
        [k not in {i // (64 * 9) * 64 + i % (64 * 9) for i in awake} for k in range(n)]
    )
    z = speed - w
    toward = np.sign(z) * band
    for end in (-slack, slack):
        for t in np.linspace(0.0, ahead, 7):
            assert ((z + end - toward * t) * z > 0.0)[asleep].all()
            place = u - (speed + end) * t + (w + 0.5 * toward * t) * t
            assert ((place > 0.0) & (place < clearance))[asleep].all()
    certain = (np.abs(z) > slack + band * ahead) & (
        np.minimum(u, clearance - u) > (np.abs(z) + slack + band * ahead) * ahead
    )
    assert (asleep == certain).all()
    assert 50 < asleep.sum() < n
    grouped.sleep[0] = ahead
    heat = wake(speed * ahead, 1e-4, 0.0, np.uint64(n), np.uint64(count), grouped)
    after, place = w.copy(), u.copy()
    from_tiles(grouped.all_rows, after, place, -band, band.copy())
    way = speed * ahead - (w + 0.5 * toward * ahead) * ahead
    assert after == pytest.approx(np.where(asleep, w + toward * ahead, w), rel=1e-15)
    assert place == pytest.approx(np.where(asleep, u - way, u), abs=1e-18)
    assert heat == pytest.approx((toward * way)[asleep].sum(), rel=1e-13)
