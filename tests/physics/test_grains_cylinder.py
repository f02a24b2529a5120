"""A cylindrical cavity: its shell, what rests in it, and how full it is."""

import math

import numpy as np
import pytest
from grains_scenes import (
    MASS,
    PAIR_TIME,
    RADIUS,
    STIFFNESS,
    WALL_TIME,
    G,
    balls,
    box,
    follow,
    heap,
    linear,
    still,
)

from rig.kernels.grains.engine import Engine

ACROSS = 0.05
TUBE = box(ACROSS, ACROSS, 0.08, 0, cylinder=1)
ORBIT = 0.5 * ACROSS - RADIUS
"""Distance of a ball's centre from the axis when it touches the shell, m."""


def test_a_ball_slides_around_the_smooth_shell_and_keeps_speed_height_and_moment() -> None:
    speed = 0.8
    # It is pressed into the shell by m v^2/r.
    sunk = MASS * speed**2 / ORBIT / STIFFNESS
    start = balls([[0.5 * ACROSS + ORBIT + sunk, 0.5 * ACROSS, 0.03]], [[0.0, speed, 0.1]])
    dt = WALL_TIME / 40.0
    engine = Engine(start, linear(1.0), TUBE, dt)
    seen = follow(engine, 4000)
    place = seen.place[:, 0] - [0.5 * ACROSS, 0.5 * ACROSS, 0.0]
    distance = np.hypot(place[:, 0], place[:, 1])
    # Half a step parts velocity and place at the start, which sets up a wave of v dt/2 v/r at the
    # contact's frequency w: amplitude v^2 dt/(2 r w).
    wave = speed**2 * dt / (2.0 * ORBIT) / math.sqrt(STIFFNESS / MASS)
    assert np.max(np.abs(distance - ORBIT - sunk)) < 1.5 * wave
    # Energy and moment about the axis are kept, around an eighth of the shell; energy up to
    # the work that the wave stores and gives back.
    turn = np.cross(place, seen.velocity[:, 0])[:, 2]
    assert turn == pytest.approx(np.full_like(turn, turn[0]), rel=1e-11)
    fast = np.linalg.norm(seen.velocity[:, 0], axis=1)
    assert np.max(np.abs(fast - fast[0])) < 2.0 * wave * math.sqrt(STIFFNESS / MASS)
    assert np.all(seen.velocity[:, 0, 2] == 0.1)
    # It has gone around by v t/r, from half a step before the start of the record.
    angle = np.arctan2(place[-1, 1], place[-1, 0])
    assert angle == pytest.approx(speed * 4000 * dt / (ORBIT + sunk), rel=1e-5)


def test_energy_is_kept_on_the_smooth_shell_over_many_rounds() -> None:
    start = balls([[0.5 * ACROSS + ORBIT, 0.5 * ACROSS, 0.03]], [[0.0, 0.8, 0.0]])
    engine = Engine(start, linear(1.0), TUBE, WALL_TIME / 40.0)
    before = engine.energy(0.0).sum()
    found = engine.advance(still(100_000))
    # Bounded: no drift in the round that the shell's normal makes.
    assert found.energy.sum() == pytest.approx(before, rel=1e-6)
    assert abs(found.loss.sum()) < 1e-6 * before


@pytest.mark.parametrize("turn", [0.0, 1.0, 2.5])
def test_a_ball_settles_at_the_lowest_point_of_the_shell(turn: float) -> None:
    pull = G * np.array([math.cos(turn), math.sin(turn), 0.0])
    room = TUBE._replace(gravity_x=pull[0], gravity_y=pull[1], gravity_z=0.0)
    start = balls([[0.03, 0.02, 0.04]], [[0.1, 0.0, 0.0]])
    law = linear(0.6, 0.4, wall_rolling=0.05)
    engine = Engine(start, law, room, WALL_TIME / 20.0)
    engine.advance(still(200_000))
    now = engine.packing()
    place = now.place[0, :2] - 0.5 * ACROSS
    # Rolling friction holds it as high as a slope of mu_r; the shell gives way by m g/k.
    assert math.acos(float(place @ pull[:2]) / G / np.hypot(*place)) < math.atan(0.05)
    assert np.hypot(*place) == pytest.approx(ORBIT + MASS * G / STIFFNESS, rel=1e-6)
    assert np.linalg.norm(now.velocity) < 1e-6


def settled_fraction(cylinder: bool) -> float:
    """Return the solid fraction of balls settled in a tube 6 balls wide, or in a square shaft of
    its area; check that none has gone through a wall.
    """
    across, count = 6.0 * 2.0 * RADIUS, 330
    side = across if cylinder else 0.5 * across * math.sqrt(math.pi)
    packing = heap(count, 0.7 * across, 0.7 * across)
    packing.place[:, :2] += 0.5 * (side - 0.7 * across)
    room = box(side, side, 0.25, 0, (0.0, 0.0, -G), cylinder=int(cylinder))
    engine = Engine(packing, linear(0.6, 0.3), room, PAIR_TIME / 14.0)
    engine.advance(still(50_000))
    now = engine.packing()
    assert np.linalg.norm(now.velocity, axis=1).max() < 1e-2
    # No ball is pressed farther into a wall than the weight of all of them could.
    deepest = count * MASS * G / STIFFNESS
    middle = now.place[:, :2] - 0.5 * side
    off = np.hypot(*middle.T) if cylinder else np.abs(middle).max(axis=1)
    assert 0.5 * side - RADIUS < off.max() < 0.5 * side - RADIUS + deepest
    assert now.place[:, 2].min() > RADIUS - deepest
    low, high = 0.008, 0.04
    inside = np.count_nonzero((now.place[:, 2] > low) & (now.place[:, 2] < high))
    ball = 4.0 / 3.0 * math.pi * RADIUS**3
    return inside * ball / (0.25 * math.pi * across**2 * (high - low))


def test_settled_balls_fill_a_tube_as_they_fill_a_square_shaft() -> None:
    tube, shaft = settled_fraction(True), settled_fraction(False)
    # Poured balls of this friction fill .58 to .62 of wide vessels; walls lower it by about a
    # tenth of a ball's diameter over the width per wall: (1 - .6/6)^2 of it in a tube 6 wide.
    assert 0.48 < tube < 0.60
    # Layers at the walls count whole or not at all at the ends of the stretch: 1 in 13.
    assert tube == pytest.approx(shaft, abs=0.04)
