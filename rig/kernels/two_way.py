"""Rows of grains in a box that they move: friction as one equation per step, impacts at the edges of a fine grid.

A step lasts some intervals of the grid. Over it every row feels a constant force: Coulomb friction against the box, or
what holds it at rest there, or the push of the wall that it leans on. All rows meet in one unknown, the box velocity V
at the end: V = V_free - gain sum_i p_i(V), p_i = m clip(V - w_i, lo_i t, hi_i t), monotone and piecewise linear, solved
by Newton steps (Moreau 1988 for the implicit friction; the smooth part is exact). A step ends early at the edge next to
the first impact. There, rows that have reached a wall exchange momentum with the free box, in the order of their
numbers: v' - V' = -e (v - V).
"""

import math
from typing import NamedTuple

from numba import njit

from rig.kernels.waveform import Array, Ints

NEWTON = 100
"""Newton or bisection steps at most; two or three are usual, the last of them as a check."""

ROUND_OFF = 4e-16
"""Relative residual at which the velocity counts as found."""

GROUND = 1e7
"""Mass of a guide at rest over that of the box: creep while it holds is below 1e-7 of what friction allows."""


class Pull(NamedTuple):
    """Forces on the box beside the rows, and the rows' common numbers, SI units.

    row_mass, restitution : of every row; `pull` the acceleration that gravity gives them along the axis
    box : mass that takes part in an impact; air : k of -k v |v|; guide : Coulomb friction against the ground, N;
    preload : constant force that holds what rests on the box
    """

    row_mass: float
    restitution: float
    pull: float
    box: float
    air: float
    guide: float
    preload: float


@njit(cache=True, nogil=True)
def rows_impulse(V: float, time: float, pull: float, w: Array, lo: Array, hi: Array) -> tuple[float, float]:
    """Impulse that the box gives the rows per row mass if it ends a step with velocity V, and how many rows it holds.

    Four sums side by side: independent additions, in an order that is always the same.
    """
    n = w.shape[0]
    V -= pull * time
    s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
    h0, h1, h2, h3 = 0.0, 0.0, 0.0, 0.0
    whole = n - n % 4
    for i in range(0, whole, 4):
        d0, d1, d2, d3 = V - w[i], V - w[i + 1], V - w[i + 2], V - w[i + 3]
        c0 = min(max(d0, lo[i] * time), hi[i] * time)
        c1 = min(max(d1, lo[i + 1] * time), hi[i + 1] * time)
        c2 = min(max(d2, lo[i + 2] * time), hi[i + 2] * time)
        c3 = min(max(d3, lo[i + 3] * time), hi[i + 3] * time)
        s0 += c0
        s1 += c1
        s2 += c2
        s3 += c3
        h0 += 1.0 if c0 == d0 else 0.0
        h1 += 1.0 if c1 == d1 else 0.0
        h2 += 1.0 if c2 == d2 else 0.0
        h3 += 1.0 if c3 == d3 else 0.0
    for i in range(whole, n):
        d0 = V - w[i]
        c0 = min(max(d0, lo[i] * time), hi[i] * time)
        s0 += c0
        h0 += 1.0 if c0 == d0 else 0.0
    return (s0 + s1) + (s2 + s3), (h0 + h1) + (h2 + h3)


@njit(cache=True, nogil=True)
def other_impulse(V: float, start: float, time: float, on: Pull) -> tuple[float, float, float, float]:
    """Impulses that the box gives air, guide and preload over a step from velocity `start` to V, and their slope."""
    middle = 0.5 * (start + V)
    air = on.air * time * middle * abs(middle)
    hold = GROUND * on.box * V
    limit = on.guide * time
    guide = min(max(hold, -limit), limit)
    slope = on.air * time * abs(middle) + (GROUND * on.box if guide == hold and limit > 0.0 else 0.0)
    return air, guide, -on.preload * time, slope


@njit(cache=True, nogil=True)
def end_velocity(
    V: float, start: float, free: float, gain: float, time: float, on: Pull, w: Array, lo: Array, hi: Array
) -> tuple[float, float, float, float]:
    """Box velocity at the end of a step, guessed as V, and the impulses that the box gives: all, the air, the guide."""
    low, high = -math.inf, math.inf
    total, air, guide = 0.0, 0.0, 0.0
    for _ in range(NEWTON):
        rows, held = rows_impulse(V, time, on.pull, w, lo, hi)
        air, guide, preload, slope = other_impulse(V, start, time, on)
        total = on.row_mass * rows + air + guide + preload
        error = V - free + gain * total
        if abs(error) <= ROUND_OFF * (abs(V) + abs(free) + gain * abs(total)):
            break
        if error > 0.0:
            high = V
        else:
            low = V
        better = V - error / (1.0 + gain * (on.row_mass * held + slope))
        if not low < better < high:
            better = 0.5 * (low + high)
        if better == V:
            break
        V = better
    return V, total, air, guide


@njit(cache=True, nogil=True)
def reached(
    V: float, time: float, interval: float, steps: int, pull: float, path: Array, w: Array, u: Array, lo: Array,
    hi: Array, play: Array, who: Ints, when: Array,
) -> tuple[int, float]:  # fmt: skip
    """Rows that reach a wall within a step, in `who`, and `when`, in intervals; their number and the earliest time.

    path : how far the box has moved at the edges of the step, m
    """
    count, first = 0, math.inf
    moved = path[steps]
    V -= pull * time
    for i in range(w.shape[0]):
        p = min(max(V - w[i], lo[i] * time), hi[i] * time)
        end = u[i] + (w[i] + 0.5 * (p + pull * time)) * time - moved
        if 0.0 <= end <= play[i]:
            continue
        z = w[i] + p - V
        low = end < 0.0
        if (low and (z >= 0.0 or hi[i] == math.inf)) or (not low and (z <= 0.0 or lo[i] == -math.inf)):
            continue
        a = p / time + pull
        before = u[i] if low else play[i] - u[i]
        t = 0.0
        for k in range(1, steps + 1):
            s = k * interval
            now = u[i] + (w[i] + 0.5 * a * s) * s - path[k]
            gap = now if low else play[i] - now
            if gap < 0.0:
                t = k - 1 + (before / (before - gap) if before > 0.0 else 0.0)
                break
            before = gap
        who[count], when[count] = (i if low else -1 - i), t
        count += 1
        first = min(first, t)
    return count, first


@njit(cache=True, nogil=True)
def carry(
    V: float, time: float, part: float, moved: float, on: Pull, band: Array, w: Array, u: Array, lo: Array, hi: Array
) -> tuple[float, float]:
    """Move the rows through the first `part` (s) of a step of `time` (s); friction heat, and that of leaning, J.

    moved : how far the box moves in that part, m
    """
    heat, leaning = 0.0, 0.0
    V -= on.pull * time
    for i in range(w.shape[0]):
        d = V - w[i]
        p = min(max(d, lo[i] * time), hi[i] * time)
        a = p / time
        way = (w[i] + 0.5 * (a + on.pull) * part) * part
        slip = moved - way
        w[i] += (a + on.pull) * part
        rub = min(max(a, -band[i]), band[i])
        heat += rub * slip
        if rub != a:
            leaning += (a - rub) * slip
        leans = hi[i] == math.inf or lo[i] == -math.inf
        if leans and p == d:
            leaning += on.pull * slip
            continue
        u[i] -= slip
        if leans:
            lo[i], hi[i] = -band[i], band[i]
    return on.row_mass * heat, on.row_mass * leaning


@njit(cache=True, nogil=True)
def collide(
    V: float, stop: int, interval: float, threshold: float, on: Pull, count: int, who: Ints, when: Array, play: Array,
    w: Array, u: Array, lo: Array, hi: Array,
) -> tuple[float, float]:  # fmt: skip
    """Impacts at the edge that ends a step: box velocity behind them, and the energy that they take, J.

    A row whose impact falls beside the edge is put where it would be had it met the wall at its own time. A rebound
    slower than `threshold` (m/s) is none: the row leans on the wall.
    """
    m = on.row_mass
    share, reduced = m / (m + on.box), m * on.box / (m + on.box)
    lost = 0.0
    for k in range(count):
        if when[k] > stop + 0.5:
            continue
        low = who[k] >= 0
        i = who[k] if low else -1 - who[k]
        s = 1.0 if low else -1.0
        closing = s * (V - w[i])
        if closing <= 0.0:
            continue
        back = on.restitution * closing
        if back <= threshold:
            back = 0.0
        lost += 0.5 * reduced * (closing * closing - back * back)
        V -= s * share * (closing + back)
        w[i] = V + s * back
        away = back * (stop - when[k]) * interval
        place = away if low else play[i] - away
        lost += m * on.pull * (place - u[i])
        u[i] = place
        if back == 0.0:
            if low:
                hi[i] = math.inf
            else:
                lo[i] = -math.inf
    return V, lost
