"""What a cloud of colliding grains keeps, and what does not change the result.

Many impacts make rounding grow. Where two computations differ by rounding alone, their tolerance
is measured: the same scene with its first grain displaced by 1e-10 m shows by how much the time
that passes magnifies a displacement, and rounding, 1e-16 of a box of .1 m at each of n steps, is
allowed that much, three times over.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from grains_scenes import (
    FREQUENCY,
    MASS,
    PAIR_TIME,
    RADIUS,
    SCENES,
    balls,
    box,
    cycles,
    down,
    follow,
    heap,
    in_cavities,
    linear,
    shaken,
    steps_of,
    still,
)

from rig.kernels.grains import engine as engine_module
from rig.kernels.grains.arrays import Law, Room
from rig.kernels.grains.engine import Engine, Packing
from rig.kernels.grains.state import EngineState

STEP = PAIR_TIME / 14.0
NUDGE = 1e-10


def cloud(count: int = 200, seed: int = 3) -> Packing:
    """Return balls in the middle of a box of .3 m, close enough to collide often."""
    packing = heap(count, 0.04, 0.04, seed, speed=1.0)
    packing.place[:] += 0.13
    spin = np.random.default_rng(seed).normal(0.0, 200.0, packing.spin.shape)
    packing.spin[:] = spin
    return packing


LAW = linear(0.7, 0.3)


def momenta(packing: Packing) -> tuple[np.ndarray, np.ndarray]:
    """Return momentum and angular momentum about the origin."""
    mass = packing.mass[:, None]
    push = np.sum(mass * packing.velocity, axis=0)
    inertia = 0.4 * mass * packing.radius[:, None] ** 2
    turn = np.cross(packing.place, mass * packing.velocity) + inertia * packing.spin
    return push, np.sum(turn, axis=0)


def test_grains_far_from_walls_keep_their_momentum() -> None:
    start = cloud()
    engine = Engine(start, LAW, box(0.3, 0.3, 0.3), STEP)
    lost = engine.advance(still(1000)).loss
    after = engine.packing()
    # Many impacts, no wall.
    assert lost[:2].sum() > 0.1 * 0.5 * np.sum(start.mass[:, None] * start.velocity**2)
    assert np.all(lost[2:] == 0.0)
    scale = float(np.sum(start.mass[:, None] * np.abs(start.velocity)))
    assert momenta(after)[0] == pytest.approx(momenta(start)[0], abs=1e-12 * scale)


def test_smooth_grains_keep_their_angular_momentum_too() -> None:
    start = cloud()
    engine = Engine(start, linear(0.7, 0.0), box(0.3, 0.3, 0.3), STEP)
    assert engine.advance(still(1000)).loss[0] > 0.0
    scale = float(np.sum(start.mass[:, None] * np.abs(np.cross(start.place, start.velocity))))
    # Forces along the line of centres; a step of velocity Verlet keeps x cross v as it is.
    assert momenta(engine.packing())[1] == pytest.approx(momenta(start)[1], abs=1e-12 * scale)
    assert np.array_equal(engine.packing().spin, start.spin)


def test_friction_loses_angular_momentum_as_much_as_balls_overlap() -> None:
    # The law gives each ball the whole radius as the lever of friction; their centres are closer
    # by the overlap. So the angular momentum changes by overlap x tangential impulse, and by
    # nothing else.
    apart = 2.0 * RADIUS + 1e-6
    start = balls([[0.05, 0.05, 0.05], [0.05 + apart, 0.05, 0.05]], [[0.5, 0.3, 0.0], [0.0] * 3])
    flight = follow(Engine(start, linear(0.7, 0.3), box(), STEP / 10.0), 250)
    states = [
        replace(start, place=p, velocity=v, spin=s)
        for p, v, s in zip(flight.place, flight.velocity, flight.spin, strict=True)
    ]
    turn = np.array([momenta(state)[1][2] for state in states])
    between = flight.place[:, 1] - flight.place[:, 0]
    distance = np.linalg.norm(between, axis=1)
    overlap = np.maximum(2.0 * RADIUS - distance, 0.0)
    impulse = MASS * np.diff(flight.velocity[:, 1], axis=0)
    normal = between / distance[:, None]
    across = np.cross(normal[:-1], impulse)[:, 2]
    expected = -np.cumsum(overlap[:-1] * across)
    assert abs(expected[-1]) > 1e-12
    # The velocity of the first ball's account is half a step from its place, which cancels: the
    # sum of position x momentum over a step changes by the moment of the forces alone.
    assert turn[1:] - turn[0] == pytest.approx(expected, abs=1e-6 * abs(expected[-1]))
    assert overlap.max() < 0.01 * RADIUS


def advanced(packing: Packing, law: Law, room: Room, velocity: np.ndarray) -> Packing:
    """Return the grains after a motion of the box."""
    engine = Engine(packing, law, room, STEP)
    engine.advance(velocity)
    return engine.packing()


def nudged(packing: Packing) -> Packing:
    place = packing.place.copy()
    place[0] += NUDGE
    return replace(packing, place=place)


def allowance(run: Callable[[Packing], Packing], packing: Packing, steps: int) -> float:
    """Return how far apart rounding may carry two runs of a number of steps, m."""
    apart = np.max(np.abs(run(nudged(packing)).place - run(packing).place))
    return 3.0 * steps * 1e-17 * max(float(apart) / NUDGE, 1.0)


def on_grid(packing: Packing) -> Packing:
    """Return the same places rounded to 2^-40 m: their mirror images are then exact."""
    place = np.round(packing.place * 2.0**40) / 2.0**40
    return replace(packing, place=place)


SIDES = 2.0**-4
STEPS = 1000


@pytest.mark.parametrize("across", [0, 1])
def test_mirrored_grains_move_as_mirror_images(across: int) -> None:
    start = on_grid(heap(150, SIDES, SIDES, speed=0.3))
    room = box(SIDES, SIDES, SIDES, axis=0, gravity=down())
    velocity = 20.0 * cycles(1.0, 1, 4400)[: STEPS + 1]

    def mirrored(packing: Packing) -> Packing:
        place, motion, spin = packing.place.copy(), packing.velocity.copy(), -packing.spin
        place[:, across] = SIDES - place[:, across]
        motion[:, across] *= -1.0
        spin[:, across] *= -1.0
        return replace(packing, place=place, velocity=motion, spin=spin)

    def run(packing: Packing) -> Packing:
        return advanced(packing, LAW, room, velocity)

    plain = run(start)
    image = mirrored(advanced(mirrored(start), LAW, room, -velocity if across == 0 else velocity))
    most = allowance(run, start, STEPS)
    assert most < 1e-6 * RADIUS
    assert np.max(np.abs(plain.place - start.place)) > RADIUS
    assert image.place == pytest.approx(plain.place, abs=most)
    # Velocities and spins part as places do, by a contact's angular frequency faster.
    assert image.velocity == pytest.approx(plain.velocity, abs=most * np.pi / PAIR_TIME)
    assert image.spin * RADIUS == pytest.approx(plain.spin * RADIUS, abs=most * 8.0 / PAIR_TIME)


def test_a_box_turned_by_a_quarter_moves_its_grains_alike() -> None:
    velocity = 20.0 * cycles(1.0, 1, 4400)[: STEPS + 1]

    def turned(packing: Packing) -> Packing:
        swap = [1, 0, 2]
        place, motion = packing.place[:, swap].copy(), packing.velocity[:, swap].copy()
        # x and y change places: a mirror image, in which spins turn the other way.
        return replace(packing, place=place, velocity=motion, spin=-packing.spin[:, swap])

    def run(packing: Packing, axis: int = 0) -> Packing:
        sides = (0.75 * SIDES, SIDES) if axis else (SIDES, 0.75 * SIDES)
        return advanced(packing, LAW, box(*sides, SIDES, axis, down()), velocity)

    narrow = on_grid(heap(120, SIDES, 0.75 * SIDES, speed=0.3))
    plain, other = run(narrow), turned(run(turned(narrow), axis=1))
    assert other.place == pytest.approx(plain.place, abs=allowance(run, narrow, STEPS))


@pytest.mark.parametrize("name", SCENES)
def test_two_threads_give_the_bits_of_one(name: str) -> None:
    scene = shaken(name)
    steps = steps_of(1 / 14)
    velocity = cycles(scene.acceleration, 1, steps)
    dt = 1.0 / (FREQUENCY * steps)
    engines = [Engine(scene.packing, scene.law, scene.room, dt, n) for n in (1, 2)]
    for part in (velocity[: steps // 2 + 1], velocity[steps // 2 :]):
        one, two = (engine.advance(part) for engine in engines)
        for name_of in ("impulse", "force", "work", "loss", "energy"):
            assert np.array_equal(getattr(one, name_of), getattr(two, name_of)), name_of
        assert np.all(one.loss > 0.0)
    alone, beside = engines
    assert alone.rebuilds == beside.rebuilds > 10
    for field in ("place", "radius", "mass", "velocity", "spin", "cavity"):
        assert np.array_equal(getattr(alone.packing(), field), getattr(beside.packing(), field))
    for group in ("_grains", "_sums", "_totals"):
        for first, second in zip(getattr(alone, group), getattr(beside, group), strict=True):
            assert np.array_equal(first, second), group
    pairs, entries = alone._lists.sizes[:2]
    assert np.array_equal(alone._lists.sizes, beside._lists.sizes)
    for field in ("first", "made_at"):
        assert np.array_equal(getattr(alone._lists, field), getattr(beside._lists, field)), field
    for field in ("other", "touching"):
        one, two = getattr(alone._lists, field), getattr(beside._lists, field)
        assert np.array_equal(one[:pairs], two[:pairs]), field
    touch = alone._lists.touching[:pairs] == 1
    assert np.array_equal(alone._lists.memory[:pairs][touch], beside._lists.memory[:pairs][touch])
    touch = alone._lists.wall_touching[:entries] == 1
    assert np.array_equal(
        alone._lists.wall_memory[:entries][touch], beside._lists.wall_memory[:entries][touch]
    )


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("name", SCENES)
def test_a_resumed_engine_goes_on_with_the_same_bits(name: str, threads: int) -> None:
    scene = shaken(name)
    steps = steps_of(1 / 14)
    velocity = cycles(scene.acceleration, 1, steps)
    dt = 1.0 / (FREQUENCY * steps)
    engine = Engine(scene.packing, scene.law, scene.room, dt)
    engine.advance(velocity[: steps // 3 + 1])
    state = engine.state()
    kept = {field: np.array(value) for field, value in state._asdict().items()}
    assert len(state.pair) + len(state.wall) > 0
    other = Engine.resumed(EngineState(**kept), scene.law, scene.room, dt, threads)
    assert np.array_equal(other.energy(velocity[steps // 3]), engine.energy(velocity[steps // 3]))
    parts = (velocity[steps // 3 : steps // 2 + 1], velocity[steps // 2 :])
    for part in parts:
        one, two = engine.advance(part), other.advance(part)
        for field in ("impulse", "force", "work", "loss", "energy"):
            assert np.array_equal(getattr(one, field), getattr(two, field)), field
    assert engine.time == other.time == pytest.approx(1.0 / FREQUENCY, rel=1e-12)
    for field, value in engine.state()._asdict().items():
        assert np.array_equal(value, getattr(other.state(), field)), field
    # What was given is not written to: a checkpoint serves more than once.
    for field, value in kept.items():
        assert np.array_equal(value, getattr(state, field)), field


def test_equal_cavities_beside_each_other_move_as_one_alone() -> None:
    one = heap(60, 0.03, 0.03, speed=0.3)
    room = box(0.03, 0.03, 0.05, 0, down())
    velocity = 20.0 * cycles(1.0, 1, 4400)[: STEPS + 1]

    def run(packing: Packing) -> Packing:
        return advanced(packing, LAW, room, velocity)

    alone = Engine(one, LAW, room, STEP)
    impulse = alone.advance(velocity).impulse
    several = Engine(in_cavities(one, 4, 0.125), LAW, room._replace(pitch=0.125, cavities=4), STEP)
    impulses = several.advance(velocity).impulse
    most = allowance(run, one, STEPS)
    found = several.packing().place.reshape(4, 60, 3)
    found[:, :, 1] -= 0.125 * np.arange(4)[:, None]
    for places in found:
        assert places == pytest.approx(alone.packing().place, abs=most)
    momentum = float(np.sum(one.mass)) * most * np.pi / PAIR_TIME
    assert impulses == pytest.approx(4.0 * impulse, abs=4.0 * momentum)


@pytest.mark.parametrize("law", [LAW, linear(0.7, 0.3, pair_rolling=0.1, wall_rolling=0.1)])
def test_contacts_remember_over_any_number_of_sortings(
    law: Law, monkeypatch: pytest.MonkeyPatch
) -> None:
    start = heap(150, SIDES, 0.4 * SIDES, speed=0.3)
    room = box(SIDES, 0.4 * SIDES, SIDES, 0, down())
    settled = advanced(start, law, room, still(3000))
    velocity = 20.0 * cycles(1.0, 1, 4400)[: STEPS + 1]

    def run(packing: Packing, skin: float = 0.1) -> tuple[Packing, int]:
        monkeypatch.setattr(engine_module, "SKIN", skin)
        engine = Engine(packing, law, room, STEP)
        engine.advance(velocity)
        return engine.packing(), engine.rebuilds

    seldom, few = run(settled, 0.3)
    often, many = run(settled, 0.002)
    assert many > 10 * few
    most = allowance(lambda packing: run(packing)[0], settled, STEPS)
    assert most < 1e-3 * RADIUS
    assert often.place == pytest.approx(seldom.place, abs=most)
