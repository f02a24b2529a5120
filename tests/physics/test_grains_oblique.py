"""Oblique impacts, sliding and rolling of a ball in the grains' kernel against closed forms."""

import math

import numpy as np
import pytest
from grains_scenes import (
    MASS,
    RADIUS,
    STIFFNESS,
    WALL_TIME,
    G,
    balls,
    box,
    down,
    extrapolated,
    follow,
    hertzian,
    linear,
    still,
)

from rig.kernels.grains.arrays import Law
from rig.kernels.grains.engine import Engine, Packing

ROUNDING = 1e-11
"""Relative: some hundred steps, each of which rounds the velocity to 1e-16 a few times."""
STEP = WALL_TIME / 20.0


def thrown(law: Law, dt: float, velocity: list[float], spin: list[float]) -> Packing:
    """Return a ball after it has hit the floor, without weight; it comes with a velocity."""
    start = balls([[0.05, 0.05, RADIUS - 0.5 * velocity[2] * dt]], [velocity], [spin])
    engine = Engine(start, law, box(axis=2), dt)
    engine.advance(still(int(1.5 * WALL_TIME / dt)))
    return engine.packing()


@pytest.mark.parametrize("steps", [14, 100])
@pytest.mark.parametrize("law", [linear(0.6, 0.3), hertzian(0.4, 0.3)])
def test_an_impact_in_gross_slip_has_the_impulse_of_coulomb_and_its_spin(
    law: Law, steps: int
) -> None:
    after = thrown(law, WALL_TIME / steps, [1.2, -1.6, -0.3], [20.0, 10.0, 30.0])
    (u, v, w), (p, q, r) = after.velocity[0], after.spin[0]
    # The force of friction is mu times the normal one in each step, whatever the step, so that
    # the law holds to rounding with the restitution that the step gives. The slip is that of the
    # lowest point: velocity + spin x (-R n).
    slip = np.array([1.2 - 10.0 * RADIUS, -1.6 + 20.0 * RADIUS])
    change = -0.3 * (w + 0.3) * slip / np.hypot(*slip)
    assert np.array([u - 1.2, v + 1.6]) == pytest.approx(change, rel=ROUNDING)
    turned = 2.5 / RADIUS * np.array([change[1], -change[0]])
    assert np.array([p - 20.0, q - 10.0]) == pytest.approx(turned, rel=ROUNDING)
    assert r == 30.0


@pytest.mark.parametrize("ratio", [1.0 / 7.0, 2.0 / 7.0, 0.8])
def test_an_impact_that_sticks_turns_the_slip_by_its_tangential_oscillation(ratio: float) -> None:
    # Mass of the lowest point 2/7 m, so that its oscillation in the tangential spring has
    # sqrt(3.5 ratio) periods where the normal one has one: a whole half sine at 2/7.
    law = linear(1.0, 1e9, wall_shear=ratio * STIFFNESS, shear_damping=0.0)
    slip = 0.4 + 30.0 * RADIUS

    def end(steps: int) -> float:
        after = thrown(law, WALL_TIME / steps, [0.4, 0.0, -0.5], [0.0, -30.0, 0.0])
        # No impulse changes the angular momentum about the point of contact.
        kept = after.velocity[0, 0] + 0.4 * RADIUS * after.spin[0, 1]
        assert kept == pytest.approx(0.4 - 0.4 * RADIUS * 30.0, rel=ROUNDING)
        return float(after.velocity[0, 0] - RADIUS * after.spin[0, 1])

    coarse, fine, finest = (end(n) for n in (400, 800, 1600))
    exact = slip * math.cos(math.pi * math.sqrt(3.5 * ratio))
    # First touch falls in the middle of a step and the spring counts the whole of it: first order.
    assert extrapolated(fine, finest, 1) == pytest.approx(exact, abs=1e-5 * slip)
    assert abs(finest - exact) < 0.6 * abs(fine - exact) + 1e-6 * slip
    assert abs(fine - exact) < 0.6 * abs(coarse - exact) + 4e-6 * slip


@pytest.mark.parametrize("e", [0.6, 1.0])
def test_two_balls_in_gross_slip_share_the_impulse_of_coulomb(e: float) -> None:
    # The line of centres turns by an angle of order slip x duration/(2 R), which a stiff contact
    # makes small: what is left falls as 1/sqrt(k), and as it does so the law holds.
    missed = []
    for k in (1e7, 1e9):
        law = linear(e, 0.2, pair_stiffness=k, pair_shear=2.0 / 7.0 * k)
        dt = math.sqrt(STIFFNESS / k) * WALL_TIME / 400.0
        apart = 2.0 * RADIUS + 0.05 * dt
        start = balls(
            [[0.05, 0.05, 0.05], [0.05 + apart, 0.05, 0.05]], [[0.1, 0.5, 0.0], [0.0, 0.0, 0.0]]
        )
        engine = Engine(start, law, box(), dt)
        engine.advance(still(600))
        after = engine.packing()
        change = 0.2 * 0.5 * (1.0 + e) * 0.1
        found = 0.5 - after.velocity[0, 1]
        missed.append(abs(found / change - 1.0))
        turn = 2.5 * found / RADIUS
        assert after.spin[:, 2] == pytest.approx([-turn, -turn], rel=10.0 * missed[-1])
    assert missed[1] < 0.02
    assert missed[1] < missed[0]


def on_slope(law: Law, tilt: float, time: float = 0.04) -> tuple[float, float, float, float]:
    """Release a ball on a tilted floor, pressed in by its weight.

    Return accelerations along the floor over the second half of the time, of the centre and of
    the turning surface (m/s^2), then at the end the velocity (m/s) and the way of the lowest
    point (m).
    """
    sunk = MASS * G * math.cos(tilt) / law.wall_stiffness
    start = balls([[0.02, 0.02, RADIUS - sunk]], [[0.0, 0.0, 0.0]])
    engine = Engine(start, law, box(0.1, 0.04, 0.04, gravity=down(tilt)), STEP)
    half = int(0.5 * time / STEP)
    engine.advance(still(half))
    middle = engine.packing()
    engine.advance(still(half))
    end = engine.packing()
    velocity = end.velocity - middle.velocity
    surface = RADIUS * (end.spin - middle.spin)[0, 1]
    flight = half * STEP
    slip = 0.0
    if abs(tilt) < 0.1:
        again = Engine(start, law, box(0.1, 0.04, 0.04, gravity=down(tilt)), STEP)
        seen = follow(again, 2 * half)
        slip = float(np.sum(seen.velocity[:, 0, 0] - RADIUS * seen.spin[:, 0, 1]) * STEP)
    return velocity[0, 0] / flight, surface / flight, float(end.velocity[0, 0]), slip


@pytest.mark.parametrize("mu", [0.1, 0.25])
@pytest.mark.parametrize("part", [0.5, 0.98, 1.02, 1.5])
def test_a_ball_rolls_down_a_slope_below_seven_halves_mu_and_slips_above(
    mu: float, part: float
) -> None:
    tilt = math.atan(3.5 * mu * part)
    along, surface, _, _ = on_slope(linear(0.6, mu), tilt)
    pull = G * math.sin(tilt)
    # What the first contact shook has died away as exp(-zeta w t): 20 ms are 45 times its time.
    if part < 1.0:
        assert along == pytest.approx(5.0 / 7.0 * pull, rel=1e-8)
        assert surface == pytest.approx(along, rel=1e-8)
    else:
        friction = mu * G * math.cos(tilt)
        assert along == pytest.approx(pull - friction, rel=1e-8)
        assert surface == pytest.approx(2.5 * friction, rel=1e-8)


def test_a_ball_pushed_lightly_sticks_to_the_floor_but_for_the_stretch_of_its_spring() -> None:
    tilt = math.atan(0.05)
    *_, slip = on_slope(linear(0.6, 0.45), tilt)
    stretch = 2.0 / 7.0 * MASS * G * math.sin(tilt) / (2.0 / 7.0 * STIFFNESS)
    # 2.5 nm; a sum of 3000 slips of 1e-6 m/s in steps of 1e-5 s rounds at 1e-17 m.
    assert slip == pytest.approx(stretch, rel=1e-6)


@pytest.mark.parametrize("part", [0.9, 1.1, 2.0])
def test_rolling_friction_holds_a_ball_up_to_its_threshold_and_brakes_it_above(part: float) -> None:
    rolling = 0.05
    tilt = math.atan(rolling * part)
    law = linear(0.6, 0.45, wall_rolling=rolling)
    along, _, velocity, _ = on_slope(law, tilt)
    if part < 1.0:
        # Below, the springs hold: what is left after 40 ms has died away.
        assert abs(velocity) < 1e-9
    else:
        held = 5.0 / 7.0 * G * (math.sin(tilt) - rolling * math.cos(tilt))
        assert along == pytest.approx(held, rel=1e-8)


def test_a_spinning_ball_that_is_dropped_ends_rolling_at_two_sevenths_of_its_surface_speed() -> (
    None
):
    spin = np.array([30.0, 80.0, 50.0])
    start = balls([[0.2, 0.2, RADIUS + 1e-3]], [[0.0, 0.0, 0.0]], [spin])
    engine = Engine(start, linear(0.6, 0.3), box(0.4, 0.4, 0.1, gravity=down()), STEP)
    for _ in range(8):
        engine.advance(still(2000))
        now = engine.packing()
        # About the point of contact no force has a moment, bounce, slip or roll.
        kept = now.velocity[0, :2] + 0.4 * RADIUS * np.array([now.spin[0, 1], -now.spin[0, 0]])
        before = 0.4 * RADIUS * np.array([spin[1], -spin[0]])
        assert kept == pytest.approx(before, rel=ROUNDING)
        assert now.spin[0, 2] == spin[2]
    rolls = 2.0 / 7.0 * RADIUS * np.array([spin[1], -spin[0]])
    assert now.velocity[0, :2] == pytest.approx(rolls, rel=1e-8)


def test_a_billiard_ball_slides_until_it_rolls_at_five_sevenths() -> None:
    speed, mu = 0.5, 0.2
    sunk = MASS * G / STIFFNESS
    start = balls([[0.01, 0.02, RADIUS - sunk]], [[speed, 0.0, 0.0]])
    engine = Engine(start, linear(0.6, mu), box(0.2, 0.04, 0.04, gravity=down()), STEP)
    rolling_after = 2.0 * speed / (7.0 * mu * G)
    steps = int(1.5 * rolling_after / STEP)
    engine.advance(still(steps))
    now = engine.packing()
    assert now.velocity[0, 0] == pytest.approx(5.0 / 7.0 * speed, rel=1e-8)
    assert RADIUS * now.spin[0, 1] == pytest.approx(now.velocity[0, 0], rel=1e-8)
    # Slid 12 v0^2/(49 mu g), then rolled. The spring gives its stretch mu m g/k back at the turn,
    # and the velocity there is caught within a step.
    slid = 12.0 * speed**2 / (49.0 * mu * G)
    way = slid + 5.0 / 7.0 * speed * (steps * STEP - rolling_after)
    stretch = mu * MASS * G / (2.0 / 7.0 * STIFFNESS)
    assert now.place[0, 0] - 0.01 == pytest.approx(way, abs=stretch + mu * G * STEP * rolling_after)
