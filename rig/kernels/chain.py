"""Event-driven collision of a chain of grains, with or without a wall at its end."""

import numpy as np
from numpy.typing import NDArray

from daq.compiled import njit

Array = NDArray[np.float64]

NEVER = np.inf
AT_REST = 1e-12
"""Closing speed, as a fraction of the fastest grain's, below which two grains count as in contact
for good.

The neglected energy is below the fraction n (1e-12)^2. This ends chains that do not collapse, n (1
- e) < pi. A collapse has a million hits before its speeds are so low; a contact duration ends it.
"""

MOST_HITS = 10_000_000
"""Number of hits after which a collision is given up."""


@njit(cache=True, nogil=True)
def _next_hit(x: Array, v: Array, wall: bool, still: float) -> tuple[float, int]:
    """Return the time to the next hit and the grain on its far side (0: grain 0 with the wall, -1:
    none).
    """
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
    mass: Array,
    restitution: Array,
    wall: bool,
    restitution_wall: float,
    x: Array,
    v: Array,
    contact_time: float,
) -> tuple[float, float, int, int]:
    """Compute all hits of a chain of points until none closes on another; `x` (m) and `v` (m/s) are
    overwritten.

    restitution : of the contacts between neighbours, shape (grains - 1,)
    wall : whether a wall at rest stands at x = 0, before grain 0
    contact_time : s; a grain hit again sooner than this is hit elastically (the contact-duration
        model of Luding and McNamara, Granular Matter 1 (1998) 113); 0 for none

    Returns (energy lost between grains, J; energy lost at the wall, J; number of hits; number of
    those made elastic).
    """
    # Round-off of the speeds scales with the fastest one.
    still = AT_REST * np.abs(v).max()
    last = np.full(x.shape[0], -NEVER)
    now, inside, at_wall = 0.0, 0.0, 0.0
    hits, elastic = 0, 0
    while hits < MOST_HITS:
        wait, k = _next_hit(x, v, wall, still)
        # No pair closes any more: the grains have separated.
        if k < 0:
            break
        now += wait
        hits += 1
        for i in range(x.shape[0]):
            x[i] += v[i] * wait
        j = max(k - 1, 0)
        # Grain 0 with the wall, or grain k with its predecessor j.
        e = restitution_wall if k == 0 else restitution[j]
        # Still in contact with a neighbour by the contact-duration model: no further loss.
        if now - max(last[j], last[k]) < contact_time:
            e = 1.0
            elastic += 1
        last[j] = last[k] = now
        if k == 0:
            # Exactly at the wall, whatever the round-off of the time.
            x[0] = 0.0
            at_wall += 0.5 * mass[0] * (1.0 - e) * (1.0 + e) * v[0] ** 2
            v[0] = -e * v[0]
            continue
        # Contact by definition: round-off must not leave a gap or an overlap.
        x[k] = x[j]
        total = mass[j] + mass[k]
        closing = v[j] - v[k]
        # Velocity of the common centre of mass; the closing speed about it is reversed and reduced
        # by e.
        mean = (mass[j] * v[j] + mass[k] * v[k]) / total
        inside += 0.5 * (mass[j] * mass[k] / total) * (1.0 - e) * (1.0 + e) * closing**2
        v[j] = mean - mass[k] / total * e * closing
        v[k] = mean + mass[j] / total * e * closing
    return inside, at_wall, hits, elastic


@njit(cache=True, nogil=True)
def rebound(grains: int, restitution: float, restitution_wall: float) -> float:
    """Return the rebound ratio of the centre of mass of `grains` equal grains that fly at -1 onto a
    wall at the origin.

    Grain k starts at k (unit gaps). Hard points have no other length scale, so the result holds for
    any gap.
    """
    x = np.arange(1.0, grains + 1.0)
    v = -np.ones(grains)
    collide_file(
        np.ones(grains), np.full(max(grains - 1, 1), restitution), True, restitution_wall, x, v, 0.0
    )
    return max(float(v.mean()), 0.0)
