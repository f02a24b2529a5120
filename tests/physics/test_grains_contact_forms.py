"""Closed forms of the normal collision against the equation of motion, integrated independently.

The integrator's relative tolerance is 1e-11; what it leaves at the end of a contact, a hundred
times as much, is the tolerance of the comparisons.
"""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rig.theory.contact import (
    contact_time,
    damping_ratio,
    hertz_contact_time,
    hertz_damping,
    hertz_overlap,
    restitution,
)

TOLERANCE = 1e-9


def integrated(
    push: Callable[[float, float], float],
    still_pushing: Callable[[float, float], float],
    mass: float,
    velocity: float,
    longest: float,
) -> tuple[float, float, float]:
    """Return restitution, duration and largest overlap of a collision that ends without force.

    push : force over overlap and its rate, N; still_pushing : positive while the force is
    """

    def parts(_t: float, state: np.ndarray) -> float:
        return still_pushing(state[0], state[1])

    def turns(_t: float, state: np.ndarray) -> float:
        return float(state[1])

    parts.terminal, parts.direction = True, -1.0
    found = solve_ivp(
        lambda _t, state: (state[1], -push(state[0], state[1]) / mass),
        (0.0, longest),
        (0.0, velocity),
        method="DOP853",
        rtol=1e-11,
        atol=1e-15,
        max_step=longest / 200.0,
        events=(parts, turns),
    )
    end, deepest = found.y_events[0][0], found.y_events[1][0][0]
    return -end[1] / velocity, float(found.t_events[0][0]), float(deepest)


@pytest.mark.parametrize("zeta", [0.0, 0.01, 0.16, 0.5, 0.7, 0.71, 0.95, 1.0, 1.5])
def test_a_linear_contact_returns_and_lasts_as_the_equation_of_motion_says(zeta: float) -> None:
    mass, stiffness = 0.7, 300.0
    dashpot = 2.0 * zeta * math.sqrt(stiffness * mass)

    def push(x: float, v: float) -> float:
        return stiffness * x + dashpot * v

    e, lasts, _ = integrated(push, push, mass, 2.0, 10.0 / math.sqrt(stiffness / mass))
    assert restitution(zeta) == pytest.approx(e, rel=TOLERANCE)
    if zeta < 1.0:
        assert contact_time(zeta, stiffness, mass) == pytest.approx(lasts, rel=TOLERANCE)


@given(st.floats(0.01, 1.0))
def test_damping_ratio_inverts_restitution(e: float) -> None:
    # d(ln e)/d(zeta) is at most pi in size, so that a rounding of zeta moves e by no more than 4.
    assert restitution(damping_ratio(e)) == pytest.approx(e, rel=1e-14)


def test_damping_ratio_refuses_what_no_contact_has() -> None:
    for e in (0.0, -0.1, 1.01, math.nan):
        with pytest.raises(ValueError, match="above 0 and at most 1"):
            damping_ratio(e)


@pytest.mark.parametrize("velocity", [0.01, 0.3, 10.0])
def test_an_elastic_hertz_contact_lasts_and_deepens_as_the_equation_of_motion_says(
    velocity: float,
) -> None:
    mass, stiffness = 2e-3, 5e7

    def push(x: float, _v: float) -> float:
        return stiffness * max(x, 0.0) ** 1.5

    guess = 3.0 * (mass / stiffness) ** 0.4 / velocity**0.2
    e, lasts, deepest = integrated(
        push, lambda x, v: x if v < 0.0 else 1.0, mass, velocity, 2.0 * guess
    )
    assert e == pytest.approx(1.0, rel=TOLERANCE)
    # The overlap leaves as x^1.5: the end is found from the place, to the same tolerance.
    assert hertz_contact_time(stiffness, mass, velocity) == pytest.approx(lasts, rel=TOLERANCE)
    assert hertz_overlap(stiffness, mass, velocity) == pytest.approx(deepest, rel=TOLERANCE)


@pytest.mark.parametrize("velocity", [0.01, 0.3, 10.0])
@pytest.mark.parametrize("e", [0.05, 0.3, 0.6, 0.9, 1.0])
def test_a_damped_hertz_contact_has_its_restitution_at_any_velocity(
    e: float, velocity: float
) -> None:
    mass, stiffness = 2e-3, 5e7
    dashpot = hertz_damping(e) * math.sqrt(stiffness * mass)

    def scaled(x: float, v: float) -> float:
        """Return the force over x^0.25, which is not 0 at the first touch."""
        return stiffness * max(x, 0.0) ** 1.25 + dashpot * v

    def push(x: float, v: float) -> float:
        return max(x, 0.0) ** 0.25 * scaled(x, v)

    guess = 3.0 * (mass / stiffness) ** 0.4 / velocity**0.2
    found, _, _ = integrated(push, scaled, mass, velocity, 6.0 * guess)
    # Steps across the root x^0.25 at first touch are small, not exact: 1e-8 is what they leave.
    assert found == pytest.approx(e, rel=10.0 * TOLERANCE)
