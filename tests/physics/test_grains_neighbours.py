"""Neighbour lists and walls of the grains against what brute force finds."""

import numpy as np
import pytest
from grains_scenes import DENSITY, box
from grains_scenes import linear as law
from hypothesis import given
from hypothesis import strategies as st

from rig.kernels.grains.arrays import (
    END_HIGH,
    END_LOW,
    FLOOR,
    LID,
    SHELL,
    SIDE_HIGH,
    SIDE_LOW,
    Room,
)
from rig.kernels.grains.engine import SKIN, Engine, LostGrains, Packing

WEAK = law(pair_stiffness=1e-30, wall_stiffness=1e-30)
"""Contacts without force: grains may lie anywhere, also in each other."""

ROOMS = {
    "box": box(0.05, 0.02, 0.03),
    "open": box(0.05, 0.02, 0.03, lid=0),
    "cylinder": box(0.04, 0.04, 0.03, cylinder=1),
    "cavities": box(0.02, 0.02, 0.03, pitch=0.1, cavities=3),
    "flat": box(0.06, 0.06, 0.006),
}


Found = tuple[set[tuple[int, ...]], set[tuple[int, ...]]]
"""Pairs of grains, and grains with walls."""


def listed(engine: Engine) -> Found:
    """Return what the kernel lists."""
    engine.advance(np.zeros(2))
    lists, ident = engine._lists, engine._grains.ident
    pairs = [
        tuple(sorted((int(ident[i]), int(ident[lists.other[k]]))))
        for i in range(ident.size)
        for k in range(lists.first[i], lists.first[i + 1])
    ]
    entries = lists.sizes[1]
    walls = [
        (int(ident[i]), int(wall))
        for i, wall in zip(lists.wall_grain[:entries], lists.wall[:entries], strict=True)
    ]
    assert len(set(pairs)) == len(pairs)
    assert len(set(walls)) == len(walls)
    return set(pairs), set(walls)


def near(packing: Packing, room: Room) -> Found:
    """Return the same by looking at every pair and every wall."""
    reach = 2.0 * SKIN * packing.radius.min()
    place, radius = packing.place, packing.radius
    apart = np.linalg.norm(place[:, None] - place[None], axis=2)
    close = np.triu(apart < radius[:, None] + radius + reach, 1)
    inside = place - np.outer(packing.cavity * room.pitch, [0.0, 1.0, 0.0])
    x, y, z = inside.T
    gaps = {FLOOR: z, LID: room.height - z if room.lid else np.full_like(z, np.inf)}
    if room.cylinder:
        half = 0.5 * room.length
        gaps[SHELL] = half - np.hypot(x - half, y - half)
    else:
        gaps |= {END_LOW: x, END_HIGH: room.length - x, SIDE_LOW: y, SIDE_HIGH: room.width - y}
    walls = {
        (int(i), wall)
        for wall, gap in gaps.items()
        for i in np.flatnonzero(gap < radius + 0.5 * reach)
    }
    return {(int(i), int(j)) for i, j in zip(*np.nonzero(close), strict=True)}, walls


@pytest.mark.parametrize("name", ROOMS)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(1, 60),
    ratio=st.floats(1.0, 5.0),
    beyond=st.sampled_from([0.0, 0.2, 2.0]),
)
def test_lists_hold_every_pair_and_wall_within_reach_and_no_other(
    name: str, seed: int, count: int, ratio: float, beyond: float
) -> None:
    room, rng = ROOMS[name], np.random.default_rng(seed)
    sides = np.array([room.length, room.width, room.height])
    # Grains above an open box, or pressed into a wall, lie outside the cells.
    place = sides * rng.uniform(-0.1 * beyond, 1.0 + beyond, (count, 3))
    radius = 1.5e-3 * rng.uniform(1.0, ratio, count) / ratio
    cavity = rng.integers(0, room.cavities, count).astype(np.int32)
    place[:, 1] += room.pitch * cavity
    packing = Packing.at_rest(place, radius, DENSITY)
    packing.cavity[:] = cavity
    engine, expected = Engine(packing, WEAK, room, 1e-9), near(packing, room)
    space = (engine._lists.other.size, engine._lists.wall_grain.size)
    # Grains that lie in each other may have more neighbours than a packing can.
    if len(expected[0]) > space[0] or len(expected[1]) > space[1]:
        with pytest.raises(LostGrains, match="more neighbours"):
            listed(engine)
    else:
        assert listed(engine) == expected


def test_a_grain_that_is_nowhere_is_reported() -> None:
    packing = Packing.at_rest(np.full((1, 3), np.nan), np.array([1e-3]), DENSITY)
    with pytest.raises(LostGrains, match="not a number"):
        Engine(packing, WEAK, ROOMS["box"], 1e-6).advance(np.zeros(2))


def test_more_neighbours_than_there_is_room_for_are_reported() -> None:
    place = np.random.default_rng(0).uniform(0.01, 0.0101, (40, 3))
    packing = Packing.at_rest(place, np.full(40, 1e-3), DENSITY)
    with pytest.raises(LostGrains, match="more neighbours"):
        Engine(packing, WEAK, ROOMS["box"], 1e-6).advance(np.zeros(2))


def test_no_pair_comes_into_touch_unlisted_between_two_sortings() -> None:
    # Two balls fly at each other from far apart: the contact begins where it would without lists.
    for speed in (0.3, 3.0):
        packing = Packing.at_rest(
            np.array([[0.01, 0.01, 0.01], [0.04, 0.01, 0.01]]), np.full(2, 2.5e-3), DENSITY
        )
        packing.velocity[:, 0] = speed, -speed
        engine = Engine(packing, law(), ROOMS["box"], 1e-6)
        steps = int((0.025 / (2.0 * speed)) / 1e-6) + 3
        engine.advance(np.zeros(steps + 1))
        assert engine.energy(0.0)[3] > 0.0
        assert engine.energy(0.0).sum() == pytest.approx(
            0.5 * packing.mass.sum() * speed**2, rel=1e-3
        )
