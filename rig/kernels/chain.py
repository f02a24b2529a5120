"""Event-driven collision of a row of equal grains with a wall."""

import numpy as np
from numba import njit

NEVER = np.inf
AT_REST = 1e-12
"""Grains that close more slowly than this share of the first velocity stay together: an inelastic collapse ends."""


@njit(cache=True, nogil=True)
def rebound(grains, restitution, restitution_wall):
    """Rebound ratio of the centre of mass of `grains` equal grains that fly at -1 onto a wall at the origin.

    Grain k starts at k (unit gaps: hard points have no other scale), so that the result holds for any gap.
    """
    x = np.arange(1.0, grains + 1.0)
    v = -np.ones(grains)
    while True:
        soonest, partner = NEVER, -1
        if v[0] < -AT_REST:
            soonest, partner = -x[0] / v[0], 0
        for k in range(1, grains):
            closing = v[k - 1] - v[k]
            if closing > AT_REST:
                wait = (x[k] - x[k - 1]) / closing
                if wait < soonest:
                    soonest, partner = wait, k
        if partner < 0:
            return max(v.mean(), 0.0)
        soonest = max(soonest, 0.0)
        for k in range(grains):
            x[k] += v[k] * soonest
        if partner == 0:
            x[0] = 0.0
            v[0] = -restitution_wall * v[0]
        else:
            x[partner] = x[partner - 1]
            mean = 0.5 * (v[partner - 1] + v[partner])
            half = 0.5 * restitution * (v[partner - 1] - v[partner])
            v[partner - 1] = mean - half
            v[partner] = mean + half
