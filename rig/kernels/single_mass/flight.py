"""Free flight of a body relative to a box in prescribed motion: closed form without cancellation,
bracketed roots.

A body that leaves phase theta0 with velocity u0 relative to the box and feels a constant force
moves relative to the box by d(t) = u0 t + a0 t^2/2 + sum [C_h s(h t) - S_h c(h t)]/h^2, s(y) = y -
sin y, c(y) = y^2/2 - 1 + cos y, where a0 is the relative acceleration at the start and S_h, C_h are
the waveform's harmonics there (`at`). With a0 = 0, as at a take-off, d starts like t^3 to full
relative accuracy, so that round-off cannot produce a false impact. Units of the waveform
(rig.kernels.waveform).
"""

import math

from daq.compiled import njit
from rig.kernels.roots import EXACT, NEAR, TIGHT, halley
from rig.kernels.waveform import Array, near_by

MOST_ROOT_STEPS = 200
"""Bisections that reduce any bracket within a cycle to round-off."""


LATE = tuple((-1.0) ** k / math.factorial(2 * k + 3) for k in range(8))
LOW = tuple((-1.0) ** k / math.factorial(2 * k + 4) for k in range(8))
"""Taylor series of (y - sin y)/y^3 and (y^2/2 - 1 + cos y)/y^4 in y^2; the relative truncation
error is below 1e-16 for y < 1.
"""


@njit(cache=True, nogil=True, inline="always")
def _tail(q: float, series: tuple[float, ...]) -> float:
    """Return a polynomial in q, lowest order first, summed in pairs."""
    square = q * q
    low = (series[0] + q * series[1]) + square * (series[2] + q * series[3])
    high = (series[4] + q * series[5]) + square * (series[6] + q * series[7])
    return low + square * square * high


@njit(cache=True, nogil=True, inline="always")
def at(theta: float, P: Array, Q: Array, S: Array, C: Array) -> tuple[float, float, float]:
    """Return position, velocity and acceleration of the box; fill S = P sin + Q cos, C = P cos - Q
    sin of each harmonic.
    """
    x, v, a = 0.0, 0.0, 0.0
    for k in range(P.shape[0]):
        h = k + 1.0
        s, c = math.sin(h * theta), math.cos(h * theta)
        S[k] = P[k] * s + Q[k] * c
        C[k] = P[k] * c - Q[k] * s
        x += S[k] / (h * h)
        v += C[k] / h
        a -= S[k]
    return x, v, a


@njit(cache=True, nogil=True, inline="always")
def drift(
    t: float, u0: float, a0: float, S: Array, C: Array
) -> tuple[float, float, float, float, float, float, float, float]:
    """Return displacement, velocity and acceleration relative to the box at time t after the start,
    and derivatives up to order 7.
    """
    d = (u0 + 0.5 * a0 * t) * t
    u = u0 + a0 * t
    a = a0
    jerk, d4, d5, d6, d7 = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(S.shape[0]):
        # A harmonic that the waveform does not have.
        if S[k] == 0.0 and C[k] == 0.0:
            continue
        h = k + 1.0
        y = h * t
        q = y * y
        # Series for small angles, where the differences would cancel.
        if y < 1.0:
            # late = y - sin y, low = y^2/2 - 1 + cos y.
            late = y * q * _tail(q, LATE)
            low = q * q * _tail(q, LOW)
            sine, versine = y - late, 0.5 * q - low
        else:
            sine, versine = math.sin(y), 1.0 - math.cos(y)
            late, low = y - sine, 0.5 * q - versine
        # The formula of the module's head, and its derivatives by t.
        d += (C[k] * late - S[k] * low) / (h * h)
        u += (C[k] * versine - S[k] * late) / h
        a += C[k] * sine - S[k] * versine
        square = h * h
        turn = h * (C[k] - C[k] * versine - S[k] * sine)
        wave = square * (C[k] * sine + S[k] - S[k] * versine)
        jerk += turn
        d4 -= wave
        d5 -= square * turn
        d6 += square * wave
        d7 += square * square * turn
    return d, u, a, jerk, d4, d5, d6, d7


@njit(cache=True, nogil=True, inline="always")
def reach(
    lo: float,
    hi: float,
    guess: float,
    wall: float,
    sense: float,
    u0: float,
    a0: float,
    S: Array,
    C: Array,
) -> tuple[float, float, float, int]:
    """Return the time at which the displacement reaches `wall`, moving up (sense 1) or down (-1);
    velocity and acceleration then; steps.

    The bracket contains one such passage; the remaining distance is >= 0 at `lo` and <= 0 at `hi`.
    Halley's method, safeguarded by bisection.
    """
    t = guess
    near = NEAR / S.shape[0]
    for n in range(MOST_ROOT_STEPS):
        d, u, a, jerk, d4, d5, d6, d7 = drift(t, u0, a0, S, C)
        left = sense * (wall - d)
        if left > 0.0:
            lo = t
        else:
            hi = t
        new, inside = halley(t, lo, hi, left, -sense * u, -sense * a)
        step, scale = new - t, min(t, 1.0)
        if inside and abs(step) < near * scale:
            for _ in range(3):
                place, speed, rate = near_by(step, d, u, a, jerk, d4, d5, d6, d7)
                if sense * speed <= 0.0:
                    break
                fix = (wall - place) / speed
                step += fix
                if fix * fix * (abs(rate) + abs(speed)) <= EXACT * scale * scale * abs(speed):
                    return t + step, speed + fix * rate, rate + fix * jerk, n + 1
        t = new
        if hi - lo <= TIGHT * hi:
            break
    _, u, a, _, _, _, _, _ = drift(t, u0, a0, S, C)
    return t, u, a, n + 1


@njit(cache=True, nogil=True, inline="always")
def turn(
    lo: float, u_lo: float, hi: float, u_hi: float, u0: float, a0: float, S: Array, C: Array
) -> tuple[float, float, int]:
    """Return the time at which the relative velocity is zero, the displacement then, and the number
    of steps.

    The velocity is monotonic in the bracket and of opposite sign at its ends.
    """
    sense = 1.0 if u_lo > 0.0 else -1.0
    # Start with the secant.
    t = lo + (hi - lo) * u_lo / (u_lo - u_hi)
    near = NEAR / S.shape[0]
    for n in range(MOST_ROOT_STEPS):
        d, u, a, jerk, d4, d5, d6, d7 = drift(t, u0, a0, S, C)
        if sense * u > 0.0:
            lo = t
        else:
            hi = t
        new, inside = halley(t, lo, hi, sense * u, sense * a, sense * jerk)
        step, scale = new - t, min(t, 1.0)
        if inside and abs(step) < near * scale:
            for _ in range(3):
                place, speed, rate = near_by(step, d, u, a, jerk, d4, d5, d6, d7)
                if sense * rate >= 0.0:
                    break
                fix = -speed / rate
                step += fix
                if fix * fix * (abs(jerk) + abs(rate)) <= EXACT * scale * scale * abs(rate):
                    return t + step, place + fix * speed, n + 1
        t = new
        if hi - lo <= TIGHT * hi:
            break
    d, _, _, _, _, _, _, _ = drift(t, u0, a0, S, C)
    return t, d, n + 1
