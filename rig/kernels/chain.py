"""Event-driven collision of a file of grains, with or without a wall at its end."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

NEVER = np.inf
AT_REST = 1e-12
"""Grains that close more slowly than this share of the fastest one stay together: what that leaves out is below
n (1e-12)^2 of the energy. It ends files that do not collapse, n (1 - e) < pi; a collapse has a million hits before its
speeds have fallen so far, and is ended by a contact duration."""

MOST_HITS = 10_000_000
"""Hits after which a collision is given up."""


@njit(cache=True, nogil=True)
def _next_hit(x: Array, v: Array, wall: bool, still: float) -> tuple[float, int]:
    """Time to the next hit and the grain on its far side (0: grain 0 with the wall, -1: none)."""
    soonest, partner = NEVER, -1
    if wall and v[0] < -still:
        soonest, partner = -x[0] / v[0], 0
    for k in range(1, x.shape[0]):
        closing = v[k - 1] - v[k]
        if closing > still:
            wait = (x[k] - x[k - 1]) / closing
            if wait < soonest:
                soonest, partner = wait, k
    return max(soonest, 0.0), partner


@njit(cache=True, nogil=True)
def collide_file(
    mass: Array, restitution: Array, wall: bool, restitution_wall: float, x: Array, v: Array, contact_time: float
) -> tuple[float, float, int, int]:
    """All hits of a file of points until none closes on another; `x` (m) and `v` (m/s) are overwritten.

    restitution : of the contacts between neighbours, shape (grains - 1,)
    wall : whether a resting wall stands at x = 0, before grain 0
    contact_time : s; a grain hit again sooner than this is hit elastically (the contact-duration model of Luding and
        McNamara, Granular Matter 1 (1998) 113); 0 for none

    Returns the energy lost between grains and at the wall (J), the hits and how many of them were made elastic.
    """
    still = AT_REST * np.abs(v).max()
    last = np.full(x.shape[0], -NEVER)
    now, inside, at_wall = 0.0, 0.0, 0.0
    hits, elastic = 0, 0
    while hits < MOST_HITS:
        wait, k = _next_hit(x, v, wall, still)
        if k < 0:
            break
        now += wait
        hits += 1
        for i in range(x.shape[0]):
            x[i] += v[i] * wait
        j = max(k - 1, 0)
        e = restitution_wall if k == 0 else restitution[j]
        if now - max(last[j], last[k]) < contact_time:
            e = 1.0
            elastic += 1
        last[j] = last[k] = now
        if k == 0:
            x[0] = 0.0
            at_wall += 0.5 * mass[0] * (1.0 - e) * (1.0 + e) * v[0] ** 2
            v[0] = -e * v[0]
            continue
        x[k] = x[j]
        total = mass[j] + mass[k]
        closing = v[j] - v[k]
        mean = (mass[j] * v[j] + mass[k] * v[k]) / total
        inside += 0.5 * (mass[j] * mass[k] / total) * (1.0 - e) * (1.0 + e) * closing**2
        v[j] = mean - mass[k] / total * e * closing
        v[k] = mean + mass[j] / total * e * closing
    return inside, at_wall, hits, elastic


@njit(cache=True, nogil=True)
def rebound(grains: int, restitution: float, restitution_wall: float) -> float:
    """Rebound ratio of the centre of mass of `grains` equal grains that fly at -1 onto a wall at the origin.

    Grain k starts at k (unit gaps: hard points have no other scale), so that the result holds for any gap.
    """
    x = np.arange(1.0, grains + 1.0)
    v = -np.ones(grains)
    collide_file(np.ones(grains), np.full(max(grains - 1, 1), restitution), True, restitution_wall, x, v, 0.0)
    return max(float(v.mean()), 0.0)
