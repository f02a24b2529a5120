"""Closed-form periodic motion, and the phases at which its acceleration crosses a level.

A waveform is two coefficient arrays P, Q (harmonics 1..H). With the phase theta = omega t and the
units acceleration A, velocity A/omega and length A/omega^2, x = sum (P_h sin h theta + Q_h cos h
theta)/h^2, v = x', a = v'.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from daq.compiled import njit

TWO_PI = 2.0 * math.pi

R6, R24, R120, R720 = 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0
"""Reciprocals of 3!, 4!, 5! and 6!."""

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


class Crossings(NamedTuple):
    """The phases at which an acceleration leaves or enters the bands [-threshold, threshold] of n
    thresholds in one cycle.

    counts : number of crossings in [0, 2 pi), shape (n,)
    tables : shape (n, m, 5), columns phase, box position, box velocity, region after the phase (-1
        below the band, 0 inside, +1 above), acceleration. The first line is phase 0, then the
        crossings in ascending order; the remaining lines are 2 pi
    """

    counts: Ints
    tables: Array


@njit(cache=True, nogil=True)
def sines(phase: Array) -> tuple[Array, Array]:
    """Return sine and cosine of phases, shape (n,), by the mathematical library that all kernels
    use.

    The last digits of numpy's own sine depend on the processor.
    """
    sine, cosine = np.empty_like(phase), np.empty_like(phase)
    for k in range(phase.shape[0]):
        sine[k], cosine[k] = math.sin(phase[k]), math.cos(phase[k])
    return sine, cosine


@njit(cache=True, nogil=True, inline="always")
def motion(theta: float, P: Array, Q: Array) -> tuple[float, float, float]:
    """Return position, velocity and acceleration of the waveform at a phase."""
    s1 = math.sin(theta)
    c1 = math.cos(theta)
    x = P[0] * s1 + Q[0] * c1
    v = P[0] * c1 - Q[0] * s1
    a = -x
    s, c = s1, c1
    for k in range(1, P.shape[0]):
        # Addition theorem: the next harmonic without another sine.
        s, c = s * c1 + c * s1, c * c1 - s * s1
        # Each integration in time divides harmonic h by h; the sign turns twice from x to a.
        h = k + 1.0
        wave = P[k] * s + Q[k] * c
        x += wave / (h * h)
        v += (P[k] * c - Q[k] * s) / h
        a -= wave
    return x, v, a


@njit(cache=True, nogil=True, inline="always")
def jet(
    theta: float, P: Array, Q: Array
) -> tuple[float, float, float, float, float, float, float, float]:
    """Return position, velocity and acceleration of the waveform and the derivatives by phase up to
    order 7.
    """
    s1 = math.sin(theta)
    c1 = math.cos(theta)
    x = P[0] * s1 + Q[0] * c1
    v = P[0] * c1 - Q[0] * s1
    a, jerk, d4, d5, d6, d7 = -x, -v, x, v, -x, -v
    s, c = s1, c1
    for k in range(1, P.shape[0]):
        s, c = s * c1 + c * s1, c * c1 - s * s1
        h = k + 1.0
        wave = P[k] * s + Q[k] * c
        # turn = h (P cos - Q sin): d/dtheta turns wave into turn and turn into -h^2 wave.
        turn = h * (P[k] * c - Q[k] * s)
        square = h * h
        x += wave / square
        v += turn / square
        a -= wave
        jerk -= turn
        d4 += square * wave
        d5 += square * turn
        d6 -= square * square * wave
        d7 -= square * square * turn
    return x, v, a, jerk, d4, d5, d6, d7


@njit(cache=True, nogil=True, inline="always")
def near_by(
    d: float, x: float, v: float, a: float, jerk: float, d4: float, d5: float, d6: float, d7: float
) -> tuple[float, float, float]:
    """Return position, velocity and acceleration at a phase offset d from a jet, by Taylor's
    series, summed in pairs.
    """
    square = d * d
    return (
        (x + d * v)
        + square
        * (
            (0.5 * a + d * (R6 * jerk))
            + square * ((R24 * d4 + d * (R120 * d5)) + square * (R720 * d6))
        ),
        (v + d * a)
        + square
        * (
            (0.5 * jerk + d * (R6 * d4))
            + square * ((R24 * d5 + d * (R120 * d6)) + square * (R720 * d7))
        ),
        (a + d * jerk)
        + square * ((0.5 * d4 + d * (R6 * d5)) + square * (R24 * d6 + d * (R120 * d7))),
    )


@njit(cache=True, nogil=True)
def _level_root(
    lo: float, hi: float, f_lo: float, f_hi: float, level: float, P: Array, Q: Array
) -> float:
    """Return the phase in a bracket where a(theta) = level, to round-off: regula falsi with the
    Illinois step.

    f_lo, f_hi : a - level at the ends, of opposite sign. They are passed in, because recomputed
        values could lose the opposite sign: an end may be an extremum that just touches the level,
        one cycle later.
    """
    if f_lo == 0.0:
        return lo
    side = 0
    for _ in range(100):
        if f_hi == 0.0 or hi - lo <= 4e-16 * hi:
            break
        theta = (lo * f_hi - hi * f_lo) / (f_hi - f_lo)
        # Round-off may put the secant on an end: bisect.
        if not (lo < theta < hi):
            theta = 0.5 * (lo + hi)
            if theta <= lo or theta >= hi:
                break
        f = motion(theta, P, Q)[2] - level
        if (f > 0.0) == (f_hi > 0.0):
            hi, f_hi = theta, f
            # Illinois: halve the value of an end that stays twice, or convergence would be linear.
            if side == 1:
                f_lo *= 0.5
            side = 1
        else:
            lo, f_lo = theta, f
            if side == -1:
                f_hi *= 0.5
            side = -1
        if abs(f) < 1e-16:
            return theta
    return hi


@njit(cache=True, nogil=True)
def extrema(P: Array, Q: Array) -> Array:
    """Return the phases in [0, 2 pi) of the extrema of the acceleration, ascending, shape (m,)."""
    harmonics = P.shape[0]
    # The jerk has at most 2 H zeros in a cycle: 128 samples per harmonic separate them.
    samples = 128 * harmonics
    jerk_P = np.empty(harmonics)
    jerk_Q = np.empty(harmonics)
    for k in range(harmonics):
        # `motion` with these coefficients gives the jerk in the place of the acceleration.
        jerk_P[k] = -(k + 1.0) * Q[k]
        jerk_Q[k] = (k + 1.0) * P[k]
    found = np.empty(samples)
    count = 0
    step = TWO_PI / samples
    before = motion(0.0, jerk_P, jerk_Q)[2]
    for k in range(samples):
        after = motion((k + 1) * step, jerk_P, jerk_Q)[2]
        if (after > 0.0) != (before > 0.0):
            found[count] = _level_root(k * step, (k + 1) * step, before, after, 0.0, jerk_P, jerk_Q)
            count += 1
        before = after
    return found[:count]


@njit(cache=True, nogil=True)
def crossings(thresholds: Array, P: Array, Q: Array, turning: Array) -> Crossings:
    """Return where the acceleration crosses each threshold, up or down; `turning` is
    its `extrema`.
    """
    n = thresholds.shape[0]
    counts = np.zeros(n, np.int64)
    tables = np.empty((n, 2 * turning.shape[0] + 2, 5))
    # Between neighbouring extrema the acceleration is monotonic, so each level is crossed at most
    # once.
    # Filled and counted by hand: a kernel that calls np.append or np.sum loads scipy.linalg.
    pieces = turning.shape[0]
    bounds = np.empty(pieces + 1 if pieces else 0)
    values = np.empty(bounds.shape[0])
    for k in range(pieces):
        bounds[k], values[k] = turning[k], motion(turning[k], P, Q)[2]
    if pieces:
        bounds[pieces], values[pieces] = turning[0] + TWO_PI, values[0]
    x0, v0, a0 = motion(0.0, P, Q)
    for i in range(n):
        band, table = thresholds[i], tables[i]
        table[:, 0], table[:, 1], table[:, 2], table[:, 3], table[:, 4] = TWO_PI, x0, v0, 0.0, a0
        table[0, 0] = 0.0
        if abs(a0) > band:
            table[0, 3] = math.copysign(1.0, a0)
        phases, behind = _crossings_of(band, bounds, values, P, Q)
        # Two crossings may coincide where the acceleration just touches a threshold. The order of
        # the monotonic pieces decides which comes first; those of the next cycle precede all
        # others.
        line, count, wrapped = 0, phases.shape[0], 0
        for phase in phases:
            wrapped += phase >= TWO_PI
        for n in range(count):
            k = (n - wrapped) % count
            phase = max(phases[k] % TWO_PI, table[line, 0])
            if phase > 0.0:
                line += 1
                table[line, 0] = phase
                table[line, 1], table[line, 2], table[line, 4] = motion(phase, P, Q)
            table[line, 3] = behind[k]
        counts[i] = phases.shape[0]
    return Crossings(counts, tables)


@njit(cache=True, nogil=True)
def _crossings_of(
    band: float, bounds: Array, values: Array, P: Array, Q: Array
) -> tuple[Array, Array]:
    """Return the phases (m,) at which the acceleration crosses -band or band, and the region after
    each.

    Computed for one monotonic piece after another, between consecutive `bounds`; the phases ascend
    from the first bound and may exceed 2 pi.
    """
    pieces = max(bounds.shape[0] - 1, 0)
    phases = np.empty(2 * pieces)
    behind = np.empty(2 * pieces)
    count = 0
    for k in range(pieces):
        lo, hi = values[k], values[k + 1]
        # In the order in which a rising (falling) piece meets the two levels.
        first = -band if hi > lo else band
        for level in (first, -first):
            if (lo > level) != (hi > level):
                phases[count] = _level_root(
                    bounds[k], bounds[k + 1], lo - level, hi - level, level, P, Q
                )
                if hi > lo:
                    behind[count] = 1.0 if level == band else 0.0
                else:
                    behind[count] = -1.0 if level == -band else 0.0
                count += 1
    return phases[:count], behind[:count]
