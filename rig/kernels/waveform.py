"""Closed-form periodic motion and the phases at which its acceleration crosses a level.

A waveform is two coefficient arrays P, Q (harmonics 1..H): with the phase theta = omega t and the units
acceleration A, velocity A/omega and length A/omega^2,
x = sum (P_h sin h theta + Q_h cos h theta)/h^2, v = x', a = v'.
"""

import math

import numpy as np
from numba import njit

TWO_PI = 2.0 * math.pi


@njit(cache=True, nogil=True, inline="always")
def motion(theta, P, Q):
    """Position, velocity and acceleration of the waveform at a phase."""
    s1 = math.sin(theta)
    c1 = math.cos(theta)
    x = P[0] * s1 + Q[0] * c1
    v = P[0] * c1 - Q[0] * s1
    a = -x
    s, c = s1, c1
    for k in range(1, P.shape[0]):
        s, c = s * c1 + c * s1, c * c1 - s * s1
        h = k + 1.0
        wave = P[k] * s + Q[k] * c
        x += wave / (h * h)
        v += (P[k] * c - Q[k] * s) / h
        a -= wave
    return x, v, a


@njit(cache=True, nogil=True)
def _level_root(lo, hi, level, P, Q):
    """Phase in a bracket where a(theta) = level, to round-off: regula falsi with the Illinois step."""
    f_lo = motion(lo, P, Q)[2] - level
    f_hi = motion(hi, P, Q)[2] - level
    if f_lo == 0.0:
        return lo
    side = 0
    for _ in range(100):
        if f_hi == 0.0 or hi - lo <= 4e-16 * hi:
            break
        theta = (lo * f_hi - hi * f_lo) / (f_hi - f_lo)
        if not (lo < theta < hi):
            theta = 0.5 * (lo + hi)
            if theta <= lo or theta >= hi:
                break
        f = motion(theta, P, Q)[2] - level
        if (f > 0.0) == (f_hi > 0.0):
            hi, f_hi = theta, f
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
def extrema(P, Q):
    """Phases in [0, 2 pi) where the acceleration is largest or smallest, ascending, shape (m,)."""
    harmonics = P.shape[0]
    samples = 128 * harmonics
    jerk_P = np.empty(harmonics)
    jerk_Q = np.empty(harmonics)
    for k in range(harmonics):
        jerk_P[k] = -(k + 1.0) * Q[k]
        jerk_Q[k] = (k + 1.0) * P[k]
    found = np.empty(samples)
    count = 0
    step = TWO_PI / samples
    before = motion(0.0, jerk_P, jerk_Q)[2] > 0.0
    for k in range(samples):
        after = motion((k + 1) * step, jerk_P, jerk_Q)[2] > 0.0
        if after != before:
            found[count] = _level_root(k * step, (k + 1) * step, 0.0, jerk_P, jerk_Q)
            count += 1
        before = after
    return found[:count]


@njit(cache=True, nogil=True)
def crossings(thresholds, P, Q, turning):
    """Where the acceleration leaves or enters the band [-threshold, threshold], for each threshold.

    Returns counts (n,), tables (n, m, 3) of phase (ascending in [0, 2 pi)), box position and box velocity there,
    regions (n, m) behind each phase (-1 below the band, 0 inside, +1 above) and the region at phase 0, shape (n,).
    """
    n = thresholds.shape[0]
    pieces = turning.shape[0]
    counts = np.zeros(n, np.int64)
    tables = np.zeros((n, 2 * pieces + 2, 3))
    phases = np.empty(2 * pieces + 2)
    behind = np.empty(2 * pieces + 2, np.int64)
    regions = np.zeros((n, 2 * pieces + 2), np.int64)
    first = np.zeros(n, np.int64)
    values = np.empty(pieces + 1)
    bounds = np.empty(pieces + 1)
    for k in range(pieces):
        bounds[k] = turning[k]
        values[k] = motion(turning[k], P, Q)[2]
    if pieces > 0:
        bounds[pieces] = turning[0] + TWO_PI
        values[pieces] = values[0]
    for i in range(n):
        band = thresholds[i]
        start = motion(0.0, P, Q)[2]
        first[i] = 1 if start > band else (-1 if start < -band else 0)
        count = 0
        for k in range(pieces):
            lo, hi = values[k], values[k + 1]
            for level in (-band, band):
                if (lo > level) != (hi > level):
                    phase = _level_root(bounds[k], bounds[k + 1], level, P, Q)
                    region = 0
                    if hi > lo and level == band:
                        region = 1
                    elif hi < lo and level == -band:
                        region = -1
                    phases[count] = phase % TWO_PI
                    behind[count] = region
                    count += 1
        order = np.argsort(phases[:count])
        for k in range(count):
            phase = phases[order[k]]
            x, v, _ = motion(phase, P, Q)
            tables[i, k, 0], tables[i, k, 1], tables[i, k, 2] = phase, x, v
            regions[i, k] = behind[order[k]]
        counts[i] = count
    return counts, tables, regions, first
