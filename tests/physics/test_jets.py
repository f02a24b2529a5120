"""A motion's derivatives and Taylor series, and the flight against it: 40 digits and closed forms."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rig.kernels.roots import NEAR
from rig.kernels.single_mass import flight
from rig.kernels.single_mass.flight import at, drift, reach, turn
from rig.kernels.waveform import jet, near_by

WAVES = (
    (np.ones(1), np.zeros(1)),
    (np.array([1.0, 0.3, -0.2, 0.05]), np.array([0.1, 0.0, 0.3, -0.02])),
)
ULP = np.finfo(float).eps


def derivative(order: int, theta: float, P: np.ndarray, Q: np.ndarray) -> float:
    """Of x = sum (P sin h theta + Q cos h theta)/h^2: each derivative turns a harmonic by a
    quarter, times h.
    """
    h = np.arange(1, P.size + 1)
    angle = h * theta + 0.5 * np.pi * order
    return float(np.sum(h ** (order - 2.0) * (P * np.sin(angle) + Q * np.cos(angle))))


@given(theta=st.floats(0.0, 2.0 * np.pi), wave=st.sampled_from(WAVES))
def test_a_jet_is_the_motions_derivatives(
    theta: float, wave: tuple[np.ndarray, np.ndarray]
) -> None:
    """To some units in the last place of the largest term, h^5 at the seventh derivative, and of h
    theta.
    """
    for order, value in enumerate(jet(theta, *wave)):
        scale = sum(np.abs(wave[0]) + np.abs(wave[1])) * wave[0].size ** max(order - 2, 0)
        assert abs(value - derivative(order, theta, *wave)) <= 64 * ULP * scale


@given(theta=st.floats(0.0, 2.0 * np.pi), share=st.floats(-1.0, 1.0), wave=st.sampled_from(WAVES))
def test_the_series_is_the_motion_near_by(
    theta: float, share: float, wave: tuple[np.ndarray, np.ndarray]
) -> None:
    """Over `NEAR` of the finders' steps the series leaves out less than round-off, in position and
    velocity; the acceleration, which only corrects the last step, lacks d^6/6! (1.4e-15)."""
    step = share * NEAR / wave[0].size
    found = near_by(step, *jet(theta, *wave))
    exact = jet(theta + step, *wave)
    assert abs(found[0] - exact[0]) <= 8 * ULP
    assert abs(found[1] - exact[1]) <= 8 * ULP
    assert abs(found[2] - exact[2]) <= 1.4e-15 * wave[0].size + 8 * ULP


def flown(t: float, u0: float, a0: float, S: np.ndarray, C: np.ndarray, order: int) -> mpmath.mpf:
    """Derivative of the displacement against the box, 40 digits, from its definition."""
    with mpmath.workdps(40):

        def displacement(time: mpmath.mpf) -> mpmath.mpf:
            d = mpmath.mpf(u0) * time + mpmath.mpf(a0) * time**2 / 2
            for k in range(S.size):
                h = k + 1
                y = h * time
                late, low = y - mpmath.sin(y), y**2 / 2 - 1 + mpmath.cos(y)
                d += (mpmath.mpf(C[k]) * late - mpmath.mpf(S[k]) * low) / h**2
            return d

        return (
            mpmath.diff(displacement, mpmath.mpf(t), order)
            if order
            else displacement(mpmath.mpf(t))
        )


@given(
    logarithm=st.floats(-8.0, 1.0),
    theta=st.floats(0.0, 6.0),
    u0=st.sampled_from([0.0, 0.3]),
    wave=st.sampled_from(WAVES),
)
@settings(max_examples=40, deadline=None)
def test_a_drift_keeps_its_digits_from_the_take_off_on(
    logarithm: float, theta: float, u0: float, wave: tuple[np.ndarray, np.ndarray]
) -> None:
    """However short the flight: displacement and velocity against the box to 1e-14 of their largest
    term, the derivatives above to 1e-12 of theirs (they only correct a step of 1 %)."""
    t, size = 10.0**logarithm, wave[0].size
    S, C = np.empty(size), np.empty(size)
    at(theta, *wave, S, C)
    found = drift(t, u0, 0.0, S, C)
    terms = float(np.sum(np.abs(S) + np.abs(C)))
    sizes = (
        u0 * t + terms * min(t, 1.0) ** 3 * max(t, 1.0) ** 2,
        u0 + terms * min(t, 1.0) ** 2 * max(t, 1.0),
    )
    for order in (0, 1):
        assert abs(float(found[order] - flown(t, u0, 0.0, S, C, order))) <= 1e-14 * sizes[order]
    for order in (2, 3, 4, 5, 6, 7):
        assert abs(
            float(found[order] - flown(t, u0, 0.0, S, C, order))
        ) <= 1e-12 * terms * size ** (order - 2)


@pytest.mark.parametrize("height", [1e-9, 1e-3, 0.5, 1.0])
def test_when_a_flight_from_rest_gets_there(height: float) -> None:
    """Released at the peak velocity of a sine in zero gravity: d = t - sin t, to the round-off of
    t.
    """
    S, C = np.empty(1), np.empty(1)
    at(0.0, *WAVES[0], S, C)
    t, u, a, steps = reach(0.0, np.pi, 3.0, height, 1.0, 0.0, 0.0, S, C)
    with mpmath.workdps(40):
        exact = mpmath.findroot(
            lambda y: y - mpmath.sin(y) - mpmath.mpf(height), (6 * height) ** (1 / 3)
        )
        assert abs(t / exact - 1) <= 4 * ULP
        assert abs(u / (1 - mpmath.cos(exact)) - 1) <= 16 * ULP
        assert abs(a / mpmath.sin(exact) - 1) <= 16 * ULP
    assert steps < flight.MOST_ROOT_STEPS


def test_when_a_flight_turns() -> None:
    """Under a weight of .5 from the take-off at asin .5: the velocity against the box is zero once
    before 3 pi/2.
    """
    S, C = np.empty(1), np.empty(1)
    begin = np.arcsin(0.5)
    at(begin, *WAVES[0], S, C)
    u_end = drift(4.0, 0.0, 0.0, S, C)[1]
    u_start = drift(1.0, 0.0, 0.0, S, C)[1]
    t, d, _ = turn(1.0, u_start, 4.0, u_end, 0.0, 0.0, S, C)
    with mpmath.workdps(40):
        b = mpmath.mpf(begin)
        exact = mpmath.findroot(
            lambda y: mpmath.cos(b) - mpmath.cos(b + y) - mpmath.sin(b) * y, 3.0
        )
        way = (
            mpmath.cos(b) * exact
            - mpmath.sin(b + exact)
            + mpmath.sin(b)
            - mpmath.sin(b) * exact**2 / 2
        )
        assert abs(t - exact) <= 8 * ULP * t
        assert abs(d - way) <= 8 * ULP
