"""LAMMPS and our kernel take the same steps from the same state, to 1e-9 over 500 steps.

Both are velocity Verlet with forces at the new places and the velocities half a step before, and
both add up the same numbers in another order: they part by rounding, which touching balls enlarge
by a factor of some thousand in 500 steps. What is compared is in units of the radius, of the
velocities in the box, and of rolling at them.
"""

from dataclasses import replace

import numpy as np
import pytest
from grains_scenes import (
    PAIR_TIME,
    RADIUS,
    G,
    balls,
    box,
    cycles,
    down,
    heap,
    hertzian,
    in_cavities,
    linear,
    shaken,
    steps_of,
    still,
)

from rig.kernels.grains.arrays import Law, Room
from rig.kernels.grains.engine import Engine, Packing
from rig.lammps_engine.engine import LammpsEngine

PART = 1.0 / 14.0
DT = PART * PAIR_TIME
STEPS = 500
SPEED = 0.3
"""Standard deviation of the balls' velocities at the start, m/s: all meet others within 500 steps,
and many the walls and the lid."""
SIDES = (0.05, 0.02, 0.032)
"""The lid is 4 mm above the uppermost balls."""
MOTION = cycles(10.0, 1, steps_of(PART))[: STEPS + 1]


def crowd() -> Packing:
    return heap(130, *SIDES[:2], speed=SPEED)


def sizes() -> Packing:
    """Balls of half to full radius at the same places."""
    radius = np.random.default_rng(5).uniform(0.5 * RADIUS, RADIUS, 130)
    return balls(crowd().place, crowd().velocity, radius=radius)


def apart(one: Packing, other: Packing) -> float:
    """Return the largest difference of two states, in units of radius and speed."""
    return max(
        float(np.abs(one.place - other.place).max()) / RADIUS,
        float(np.abs(one.velocity - other.velocity).max()) / SPEED,
        float(np.abs(one.spin - other.spin).max()) * RADIUS / SPEED,
    )


def agree(
    packing: Packing, law: Law, room: Room, within: float, ranks: int = 1, lost: float = 1e-5
) -> None:
    own = Engine(packing, law, room, DT)
    ours = own.advance(MOTION)
    with LammpsEngine(packing, law, room, DT, ranks) as other:
        theirs = other.advance(MOTION)
        assert apart(own.packing(), other.packing()) < within
    # Friction and impacts, walls too, have happened: agreement of balls in flight shows nothing.
    assert float(ours.loss.sum()) > lost
    assert ours.impulse[-1] != 0.0
    momentum = own.mass * SPEED
    assert np.abs(ours.impulse - theirs.impulse).max() < within * momentum
    assert abs(ours.work - theirs.work) < within * momentum * SPEED
    assert np.abs(ours.energy[:3] - theirs.energy[:3]).max() < within * momentum * SPEED


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_linear_contacts_walls_with_friction_and_lid_on_all_axes(axis: int) -> None:
    agree(crowd(), linear(0.6, 0.25, wall_friction=0.45), box(*SIDES, axis, down()), 1e-9)


def test_a_settled_bed_whose_contacts_are_loaded() -> None:
    """Both begin with the forces of the packing, tangential springs relaxed: the account starts with
    the elastic energy, and the walls carry the weight from the first step on."""
    law = linear(0.6, 0.25, wall_friction=0.45)
    room = box(*SIDES, 0, down())
    bed = Engine(crowd(), law, room, DT)
    bed.advance(still(8000))
    packing = replace(bed.packing(), velocity=np.zeros((130, 3)), spin=np.zeros((130, 3)))
    own = Engine(packing, law, room._replace(axis=2), DT)
    with LammpsEngine(packing, law, room._replace(axis=2), DT) as other:
        stored = own.energy(0.0)[3]
        assert stored > 1e-7
        assert other.energy(0.0)[3] == pytest.approx(stored, rel=1e-9)
        ours, theirs = own.advance(still(STEPS)), other.advance(still(STEPS))
        assert apart(own.packing(), other.packing()) < 1e-9
    weight = own.mass * G
    # The side walls' friction, relaxed at the start, had carried some per cent.
    assert ours.impulse[1] == pytest.approx(weight * DT, rel=0.2)
    assert np.abs(ours.impulse - theirs.impulse).max() < 1e-9 * weight * DT * STEPS
    agree(packing, law, room, 1e-9, lost=1e-6)


def test_an_open_box_and_no_weight() -> None:
    agree(crowd(), linear(0.6, 0.3), box(*SIDES, 2, down(), lid=0), 1e-9)
    agree(crowd(), linear(0.6, 0.3), box(*SIDES, 0), 1e-9)


def test_cavities_beside_each_other() -> None:
    packing = in_cavities(heap(40, 0.025, 0.02, speed=SPEED), 3, 0.1)
    room = box(0.025, 0.02, 0.032, 0, down(), pitch=0.1, cavities=3)
    agree(packing, linear(0.6, 0.3), room, 1e-9)


def test_hertz_mindlin_with_friction() -> None:
    """Without a dashpot: LAMMPS's dashpots of Hertz contacts come with another arm of friction."""
    agree(crowd(), hertzian(0.0, 0.3), box(*SIDES, 0, down()), 1e-9)


def test_hertz_with_dashpot_without_friction() -> None:
    agree(crowd(), hertzian(0.4, 0.0), box(*SIDES, 0, down()), 1e-9)


def test_sizes() -> None:
    """As for Hertz contacts: a dashpot or friction, not both."""
    agree(sizes(), linear(1.0, 0.3), box(*SIDES, 0, down()), 1e-9)
    agree(sizes(), linear(0.6, 0.0), box(*SIDES, 0, down()), 1e-9)
    agree(sizes(), hertzian(0.0, 0.3), box(*SIDES, 0, down()), 1e-9)


def test_a_cylinder() -> None:
    """Its wall turns under a rolling ball: LAMMPS turns the spring there and keeps its length, ours
    projects it. A step turns it by v dt/r = 1e-4, whose square over two is what a stretch differs
    by in a step: 500 steps of it are 2.5e-6 of a way of 1e-7 m in the spring, 1e-10 of the radius;
    impacts enlarge it as they do rounding."""
    scene = shaken("cylinder")
    agree(balls(scene.packing.place, 3.0 * scene.packing.velocity), scene.law, scene.room, 1e-7)


def test_friction_on_the_other_arm_differs_by_half_the_overlap() -> None:
    """With sizes and a dashpot LAMMPS lets friction act at radius less overlap/2. The spin that two
    balls get in an oblique impact differs by that fraction at most: overlap/(2 R) < v sqrt(m/k)/R
    with the reduced mass, here .16 %."""
    law = linear(0.6, 0.2)
    packing = balls(
        [[0.05, 0.05, 0.05], [0.0551, 0.05, 0.05]],
        [[0.1, 0.3, 0.0], [-0.1, 0.0, 0.0]],
        radius=np.array([RADIUS, 0.9 * RADIUS]),
    )
    own = Engine(packing, law, box(), DT)
    own.advance(still(STEPS))
    with LammpsEngine(packing, law, box(), DT) as other:
        other.advance(still(STEPS))
        one, two = own.packing(), other.packing()
    reduced = 1.0 / float(np.sum(1.0 / packing.mass))
    most = 0.2 * np.sqrt(reduced / law.pair_stiffness) / (0.9 * RADIUS)
    spin = np.abs(one.spin[:, 2])
    assert spin.min() > 1.0
    assert np.all(np.abs(one.spin[:, 2] - two.spin[:, 2]) < 0.5 * most * spin)
    np.testing.assert_allclose(one.velocity, two.velocity, atol=1e-9)


def test_ranks_divide_the_grains_and_change_rounding_only() -> None:
    agree(crowd(), linear(0.6, 0.25), box(*SIDES, 0, down()), 1e-9, ranks=2)
