"""Head-on impacts of the grains' kernel against closed forms, with the order in the step.

First touch falls at a fixed part of a step, half of it unless a test says otherwise: then errors
are smooth in the step and can be extrapolated. What remains is the end of the contact, where the
force vanishes within a step: second order. With 1600 steps to a contact that is below 1e-5.
"""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from grains_scenes import (
    HERTZ,
    MASS,
    PAIR_TIME,
    RADIUS,
    STIFFNESS,
    WALL_TIME,
    balls,
    box,
    extrapolated,
    follow,
    hertzian,
    linear,
    still,
)

from rig.kernels.grains.arrays import Law
from rig.kernels.grains.engine import Engine
from rig.theory.contact import (
    contact_time,
    damping_ratio,
    hertz_contact_time,
    hertz_damping,
    hertz_overlap,
)

STEPS = (800, 1600)
PHASES = (np.arange(32) + 0.5) / 32.0
SPEED = 0.5


@dataclass(frozen=True)
class Impact:
    """Restitution, duration (s), largest force (N) and largest overlap (m)."""

    e: float
    lasts: float
    force: float
    overlap: float


def top(y: np.ndarray) -> float:
    """Return the largest value of a parabola through the largest entry and its neighbours."""
    k = int(np.argmax(y))
    a, b, c = y[k - 1 : k + 2]
    return float(b + (a - c) ** 2 / (8.0 * (2.0 * b - a - c)))


def judged(
    law: Law, force: np.ndarray, before: float, after: float, m: float, dt: float, f: float
) -> Impact:
    """Return what a record of the force gives; `f` is the part of a step before first touch."""
    last = int(np.flatnonzero(force > 0.0)[-1])
    # A Hertz force leaves as overlap^1.5; the overlap itself is straight at the end.
    a, b = force[last - 1 : last + 1] ** (2.0 / 3.0 if law.hertz else 1.0)
    end = last + b / (a - b)
    # The places of velocity Verlet are those that its forces make of the velocities.
    place = np.cumsum(before - np.cumsum(force) * dt / m) * dt
    overlap = np.concatenate(([0.0], place)) + (1.0 - f) * before * dt - before * dt
    return Impact(after / before, (end - f) * dt, top(force), top(overlap))


def on_wall(
    law: Law,
    dt: float,
    f: float = 0.5,
    axis: int = 2,
    longest: float = 1.3 * WALL_TIME,
    speed: float = SPEED,
) -> Impact:
    """Let a ball hit the low wall of an axis and follow it over the longest time of contact, s."""
    place, velocity = [0.05, 0.05, 0.05], [0.0, 0.0, 0.0]
    place[axis], velocity[axis] = RADIUS + f * speed * dt, -speed
    engine = Engine(balls([place], [velocity]), law, box(axis=axis), dt)
    steps = int(longest / dt) + 3
    force = np.diff(engine.advance(still(steps)).impulse) / dt
    after = engine.packing().velocity[0, axis]
    return judged(law, force, speed, after, MASS, dt, f)


def of_two(law: Law, dt: float, longest: float) -> tuple[Impact, float]:
    """Let two balls of 2.5 and 4 mm meet at `SPEED` along (1, 2, 2)/3; also the mass of the two."""
    line = np.array([1.0, 2.0, 2.0]) / 3.0
    radius = np.array([2.5e-3, 4e-3])
    apart = radius.sum() + 0.5 * SPEED * dt
    middle = np.full(3, 0.05)
    places = np.array([middle - 0.5 * apart * line, middle + 0.5 * apart * line])
    packing = balls(places, np.array([SPEED * line, 0.0 * line]), radius=radius)
    mass = float(np.prod(packing.mass) / packing.mass.sum())
    flight = follow(Engine(packing, law, box(), dt), int(longest / dt) + 3)
    closing = (flight.velocity[:, 0] - flight.velocity[:, 1]) @ line
    force = -np.diff(closing) * mass / dt
    return judged(law, force, SPEED, -closing[-1], mass, dt, 0.5), mass


@pytest.mark.parametrize("e", [0.3, 0.6, 0.95, 1.0])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_ball_on_a_wall_returns_and_lasts_as_the_closed_form_says(e: float, axis: int) -> None:
    zeta = damping_ratio(e)
    lasts = contact_time(zeta, STIFFNESS, MASS)
    order = 1 if e < 1.0 else 2
    coarse, fine = (on_wall(linear(e), lasts / n, axis=axis) for n in STEPS)
    assert extrapolated(coarse.e, fine.e, order) == pytest.approx(e, abs=1e-5)
    assert extrapolated(coarse.lasts, fine.lasts, order) == pytest.approx(lasts, rel=1e-5)


@pytest.mark.parametrize("e", [0.6, 1.0])
def test_two_balls_return_and_last_as_the_closed_form_says(e: float) -> None:
    zeta, mass = damping_ratio(e), MASS / (1.0 + (2.5 / 4.0) ** 3)
    lasts = contact_time(zeta, STIFFNESS, mass)
    order = 1 if e < 1.0 else 2
    found = [of_two(linear(e), lasts / n, 1.1 * lasts) for n in STEPS]
    assert found[0][1] == pytest.approx(mass, rel=1e-14)
    coarse, fine = (one for one, _ in found)
    assert extrapolated(coarse.e, fine.e, order) == pytest.approx(e, abs=1e-5)
    assert extrapolated(coarse.lasts, fine.lasts, order) == pytest.approx(lasts, rel=1e-5)
    if e == 1.0:
        force = SPEED * math.sqrt(STIFFNESS * mass)
        assert extrapolated(coarse.force, fine.force, 2) == pytest.approx(force, rel=1e-5)
        overlap = force / STIFFNESS
        assert extrapolated(coarse.overlap, fine.overlap, 2) == pytest.approx(overlap, rel=1e-5)


def rms_errors(e: float, n: float) -> tuple[float, float]:
    """Return the rms errors of e and of the relative duration over first touches within a step."""
    lasts = contact_time(damping_ratio(e), STIFFNESS, MASS)
    found = [on_wall(linear(e), lasts / n, f) for f in PHASES]
    errors = [(one.e - e, one.lasts / lasts - 1.0) for one in found]
    return tuple(np.sqrt(np.mean(np.square(errors), axis=0)))


def test_damped_impacts_are_of_first_order_in_the_step() -> None:
    (e0, t0), (e1, t1) = rms_errors(0.6, 50.0), rms_errors(0.6, 200.0)
    # Two halvings of the step; the next term of the error, a 50th of the first, bends the order.
    assert math.log(e0 / e1, 4.0) == pytest.approx(1.0, abs=0.04)
    assert math.log(t0 / t1, 4.0) == pytest.approx(1.0, abs=0.04)


def test_undamped_impacts_are_of_second_order_in_the_step_or_better() -> None:
    (e0, t0), (e1, t1) = rms_errors(1.0, 50.0), rms_errors(1.0, 200.0)
    # The force begins and ends at 0, so that the velocity misses by a third order only.
    assert math.log(e0 / e1, 4.0) == pytest.approx(3.0, abs=0.1)
    assert math.log(t0 / t1, 4.0) == pytest.approx(2.0, abs=0.1)


def test_restitution_at_a_coarse_step_depends_on_where_in_a_step_the_bounce_begins() -> None:
    for n, most in ((14.0, 0.03), (200.0, 0.0022)):
        e = np.array([on_wall(linear(0.6), WALL_TIME / n, f).e for f in PHASES])
        # The step in which the damping force begins is counted whole or not at all: c v dt/2
        # either way, of momentum m v, 2 zeta w dt/2 = zeta pi/n: .036 at 14.
        assert 0.6 * most < np.max(np.abs(e - 0.6)) < most
        # On average over many bounces most of it cancels.
        assert abs(e.mean() - 0.6) < 0.2 * most
    e = np.array([on_wall(linear(0.6), PAIR_TIME / 14.0, f).e for f in PHASES])
    assert e.min() < 0.607 < e.max()


@pytest.mark.parametrize("speed", [0.05, 1.0])
def test_an_elastic_hertz_impact_has_its_duration_force_and_overlap(
    speed: float,
) -> None:
    stiffness = HERTZ * math.sqrt(RADIUS)
    lasts = hertz_contact_time(stiffness, MASS, speed)
    overlap = hertz_overlap(stiffness, MASS, speed)
    coarse, fine = (
        on_wall(hertzian(), lasts / n, longest=1.05 * lasts, speed=speed) for n in STEPS
    )
    assert extrapolated(coarse.e, fine.e, 2) == pytest.approx(1.0, abs=1e-5)
    assert extrapolated(coarse.lasts, fine.lasts, 2) == pytest.approx(lasts, rel=1e-5)
    assert extrapolated(coarse.overlap, fine.overlap, 2) == pytest.approx(overlap, rel=1e-5)
    force = stiffness * overlap**1.5
    assert extrapolated(coarse.force, fine.force, 2) == pytest.approx(force, rel=1e-5)


def test_two_hertz_balls_meet_with_their_reduced_radius_and_mass() -> None:
    mass = MASS / (1.0 + (2.5 / 4.0) ** 3)
    stiffness = HERTZ * math.sqrt(2.5e-3 * 4e-3 / 6.5e-3)
    lasts = hertz_contact_time(stiffness, mass, SPEED)
    coarse, fine = (of_two(hertzian(), lasts / n, 1.05 * lasts)[0] for n in STEPS)
    overlap = hertz_overlap(stiffness, mass, SPEED)
    assert extrapolated(coarse.overlap, fine.overlap, 2) == pytest.approx(overlap, rel=1e-5)
    force = stiffness * overlap**1.5
    assert extrapolated(coarse.force, fine.force, 2) == pytest.approx(force, rel=1e-5)


@pytest.mark.parametrize("speed", [0.05, 1.0])
@pytest.mark.parametrize("e", [0.3, 0.6, 0.9])
def test_a_damped_hertz_impact_has_its_restitution_at_any_speed(e: float, speed: float) -> None:
    law = hertzian(hertz_damping(e))
    lasts = hertz_contact_time(HERTZ * math.sqrt(RADIUS), MASS, speed)
    coarse, fine = (on_wall(law, lasts / n, longest=2.0 * lasts, speed=speed).e for n in STEPS)
    assert extrapolated(coarse, fine, 1) == pytest.approx(e, abs=1e-5)
