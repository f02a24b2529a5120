"""Rows of grains in a box that they move: friction as one equation per step, impacts at the edges of a fine grid.

A step lasts some intervals of the grid. Over it every row feels a constant force: Coulomb friction against the box, or
what holds it at rest there, or the push of the wall that it leans on. All rows meet in one unknown, the box velocity V
at the end: V = V_free - gain sum_i p_i(V), p_i = m clip(V - w_i, lo_i t, hi_i t), monotone and piecewise linear, solved
by Newton steps (Moreau 1988 for the implicit friction; the smooth part is exact). A step ends early at an edge `WINDOW`
intervals at most behind the first impact. There, rows that have reached a wall exchange momentum with the free box, in
the order of their numbers: v' - V' = -e (v - V).
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from rig.kernels.waveform import Array, Ints

NEWTON = 100
"""Newton or bisection steps at most; two or three are usual, the last of them as a check."""

RESIDUAL = 1e-14
"""Relative residual at which the velocity counts as found: some round-off of a sum over a thousand rows."""

WINDOW = 2
"""Intervals before and behind an edge whose impacts are dealt with at that edge."""

CHUNK = np.uint64(64)
"""Rows that are counted together before one of them is looked for (unsigned: that compiles to several at a time)."""

NEAR = 1e-4
NEARBY = 0.01
"""Share of its play, of 10 mm at most, within which a row that has leaned on a wall still does: impacts elsewhere shake
it by less."""

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
def total(x: Array) -> float:
    """Sum of an array in eight lanes: independent additions, in an order that is always the same."""
    n = x.shape[0]
    a, b, c, d, e, f, g, h = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    whole = n - n % 8
    for i in range(0, whole, 8):
        a += x[i]
        b += x[i + 1]
        c += x[i + 2]
        d += x[i + 3]
        e += x[i + 4]
        f += x[i + 5]
        g += x[i + 6]
        h += x[i + 7]
    for i in range(whole, n):
        a += x[i]
    return ((a + b) + (c + d)) + ((e + f) + (g + h))


@njit(cache=True, nogil=True)
def impulses(V: float, time: float, w: Array, lo: Array, hi: Array, p: Array) -> int:
    """Impulses per mass, `p`, that give rows a box that ends a step with velocity V, and how many rows it holds."""
    held = 0
    for i in range(w.shape[0]):
        d = V - w[i]
        least, most = lo[i] * time, hi[i] * time
        c = least if d < least else d
        c = most if c > most else c
        p[i] = c
        held += 1 if c == d else 0
    return held


@njit(cache=True, nogil=True)
def other_impulse(V: float, start: float, speed: float, time: float, on: Pull) -> tuple[float, float, float, float]:
    """Impulses that the box gives air, guide and preload over a step from velocity `start` to V, and their slope.

    The air's force is k |v| v with |v| = `speed`, foreseen, and v the mean of both ends: linear, and of second order.
    """
    air = 0.5 * on.air * time * speed * (start + V)
    hold = GROUND * on.box * V
    limit = on.guide * time
    guide = min(max(hold, -limit), limit)
    slope = 0.5 * on.air * time * speed + (GROUND * on.box if guide == hold and limit > 0.0 else 0.0)
    return air, guide, -on.preload * time, slope


@njit(cache=True, nogil=True)
def turn(a: float, start: float, time: float, band: Array, w: Array, p: Array) -> float:
    """Give rows whose slip changes sign within a step the friction of both parts; the change of all impulses, per mass.

    a : acceleration of the box less that of gravity on the rows. Slip z ends at t = |z|/(band + |a|) and begins anew
    the other way for |a| > band: p = band (time - 2 t) in the direction of a. The implicit law has it all that way.
    A row that its wall pushes harder than friction could slides nowhere.
    """
    change, rows = 0.0, np.uint64(w.shape[0])
    for begin in range(np.uint64(0), rows, CHUNK):
        end, turned = min(begin + CHUNK, rows), 0
        for i in range(begin, end):
            z = start - w[i]
            turned += 1 if z * (z + a * time - p[i]) < 0.0 else 0
        if turned == 0:
            continue
        for i in range(begin, end):
            z = start - w[i]
            if z * (z + a * time - p[i]) < 0.0 and abs(a) > band[i] and abs(p[i]) <= band[i] * time:
                friction = math.copysign(band[i] * (time - 2.0 * abs(z) / (band[i] + abs(a))), a)
                if abs(friction) <= abs(p[i]):
                    change += friction - p[i]
                    p[i] = friction
    return change


@njit(cache=True, nogil=True)
def end_velocity(
    V: float,
    start: float,
    free: float,
    gain: float,
    time: float,
    on: Pull,
    band: Array,
    w: Array,
    lo: Array,
    hi: Array,
    p: Array,
) -> tuple[float, float, float, float]:
    """Box velocity at the end of a step, guessed as V, and the impulses that the box gives: all, the air, the guide.

    The rows' part of them stands in `p`, per mass.
    """
    low, high = -math.inf, math.inf
    given, air, guide = 0.0, 0.0, 0.0
    speed = 0.5 * abs(start + V)
    for _ in range(NEWTON):
        held = impulses(V - on.pull * time, time, w, lo, hi, p)
        air, guide, preload, slope = other_impulse(V, start, speed, time, on)
        given = on.row_mass * total(p) + air + guide + preload
        error = V - free + gain * given
        if abs(error) <= RESIDUAL * (abs(V) + abs(free) + gain * abs(given)):
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
    given += on.row_mass * turn((V - start) / time - on.pull, start, time, band, w, p)
    return V, given, air, guide


@njit(cache=True, nogil=True)
def next_walls(
    interval: float, steps: int, pull: float, per_time: float, path: Array, depth: float, p: Array, w: Array, u: Array,
    lo: Array, hi: Array, play: Array, who: Ints, room: Array,
) -> tuple[int, float]:  # fmt: skip
    """Rows that will pass a wall within some intervals if their friction stays as it was, and when the first one does.

    path : how far the box will have moved at the edges, m; `p`, `per_time` : the latest impulses, and one over the time
    that they took; depth : how far a row has to pass, m. Rows go to `who`, as -1 - row for the far wall; returns their
    number and the time in intervals.
    """
    time = steps * interval
    half, fall = 0.5 * time * time * per_time, 0.5 * time * time * pull - path[steps]
    count, first, rows = 0, math.inf, np.uint64(w.shape[0])
    for begin in range(np.uint64(0), rows, CHUNK):
        end, beyond = min(begin + CHUNK, rows), 0
        for i in range(begin, end):
            place = u[i] + w[i] * time + half * p[i] + fall
            room[i] = place
            beyond += 1 if (place < -depth) | (place > play[i] + depth) else 0
        if beyond == 0:
            continue
        for i in range(begin, end):
            place = room[i]
            if -depth <= place <= play[i] + depth:
                continue
            low = place < 0.0
            if (hi[i] if low else -lo[i]) == math.inf:
                continue
            t = _crossing(w[i], p[i] * per_time + pull, u[i], play[i], low, interval, steps, path)
            who[count] = int(i) if low else -1 - int(i)
            count += 1
            first = min(first, t)
    return count, first


@njit(cache=True, nogil=True)
def _crossing(w: float, a: float, u: float, play: float, low: bool, interval: float, steps: int, path: Array) -> float:
    """When a row first passes a wall, in intervals: straight between the edges around it; 0 if it is outside."""
    before = u if low else play - u
    for k in range(1, steps + 1):
        s = k * interval
        now = u + (w + 0.5 * a * s) * s - path[k]
        gap = now if low else play - now
        if gap < 0.0:
            return k - 1 + (before / (before - gap) if before > 0.0 else 0.0)
        before = gap
    return float(steps)


@njit(cache=True, nogil=True)
def carry(
    a: float, start: float, time: float, part: float, moved: float, on: Pull, p: Array, band: Array, grip: Array,
    w: Array, u: Array, lo: Array, hi: Array, play: Array, slip: Array, heat: Array, leaning: bool, settle: bool,
) -> tuple[float, float]:  # fmt: skip
    """Move the rows through the first `part` (s) of a step of `time` (s); heat in all, and that of leaning, J.

    a : as in `turn`; moved : how far the box moves in that part, m; `slip`, `heat` are room to work in; leaning : are
    there rows that do; settle : correct the ways of rows that come to rest. The heat is that of the constant forces.
    Loops are short and many, so that each is compiled for several rows at a time.
    """
    per_time, half, pull, rows = 1.0 / time, 0.5 * part, on.pull, w.shape[0]
    pushed, bound = 0, time * (1.0 + 1e-9)
    for i in range(rows):
        way = moved - (w[i] * part + half * (p[i] * per_time + pull) * part)
        slip[i] = way
        heat[i] = p[i] * way
        pushed += 1 if abs(p[i]) > band[i] * bound else 0
    rubbed, leant = total(heat), 0.0
    if pushed:
        for i in range(rows):
            given, way, rub = p[i], slip[i], band[i] * time
            over = given - rub if given > 0.0 else given + rub
            heat[i] = over * way if abs(given) > rub else 0.0
        leant = total(heat)
    if settle:
        _settle(a, start, time, p, band, grip, w, slip)
    if leaning:
        kept = _lean(time, pull * time, p, slip, lo, hi)
        rubbed, leant = rubbed + kept, leant + kept
    for i in range(rows):
        u[i] -= slip[i]
        w[i] += (p[i] * per_time + pull) * part
    if leaning:
        for i in range(rows):
            least, most, rub, place, room = lo[i], hi[i], band[i], u[i], play[i]
            near = NEAR * min(room, NEARBY)
            hi[i] = rub if place > near else most
            lo[i] = -rub if room - place > near else least
    return on.row_mass * rubbed * per_time, on.row_mass * leant * per_time


@njit(cache=True, nogil=True)
def _lean(time: float, fall: float, p: Array, slip: Array, lo: Array, hi: Array) -> float:
    """Keep rows that lean on a wall there unless they slide off; the work of gravity on what is kept, times time."""
    kept = 0.0
    if fall != 0.0:
        for i in range(p.shape[0]):
            if hi[i] - lo[i] == math.inf and p[i] != lo[i] * time and p[i] != hi[i] * time:
                kept += slip[i]
    for i in range(p.shape[0]):
        least, most, given, way = lo[i], hi[i], p[i], slip[i]
        slip[i] = 0.0 if (most - least == math.inf) & (given != least * time) & (given != most * time) else way
    return kept * fall


@njit(cache=True, nogil=True)
def _settle(a: float, start: float, time: float, p: Array, band: Array, grip: Array, w: Array, slip: Array) -> None:
    """Ways of rows that come to rest in the box within a step: slip z ends at t = |z|/(band - a sign z), way z t/2.

    With the slip spread over the whole step they would creep by an amount of first order in the step. `grip` is 1/band,
    x = a sign z/band; 1/(1 - x) is taken as (1 + x)(1 + x^2)(1 + x^4) for x > 0, as 1 + .9 x + .4 x^2 (3 %) below: a
    division costs more than all the rest, and a row with x near 1 does not come to rest within a step.
    """
    for i in range(w.shape[0]):
        z, limit, way = start - w[i], band[i], slip[i]
        s = a if z > 0.0 else -a
        x = s * grip[i]
        rests = (abs(p[i]) < limit * time) & (abs(z) < (limit - s) * time) & (way != 0.0) & (abs(x) < 1.0)
        square = x * x
        sooner = 1.0 + 0.9 * x + 0.4 * square
        inverse = (1.0 + x) * (1.0 + square) * (1.0 + square * square) if x > 0.0 else sooner
        short = 0.5 * z * abs(z) * grip[i] * inverse
        slip[i] = short if rests else way


@njit(cache=True, nogil=True)
def collide(
    V: float, interval: float, threshold: float, on: Pull, count: int, who: Ints, play: Array, w: Array, u: Array,
    lo: Array, hi: Array,
) -> tuple[float, float]:  # fmt: skip
    """Impacts at an edge: box velocity behind them, and the energy that they take, J.

    Of the rows in `who`, those that meet their wall within `WINDOW` intervals before or after exchange momentum with
    the box. Then they are put where they would be had they met the wall at their own time. A rebound slower than
    `threshold` (m/s) is none: the row leans on the wall.
    """
    m = on.row_mass
    share, reduced = m / (m + on.box), m * on.box / (m + on.box)
    lost = 0.0
    for k in range(count):
        low = who[k] >= 0
        i = who[k] if low else -1 - who[k]
        s = 1.0 if low else -1.0
        closing = s * (V - w[i])
        gap = u[i] if low else play[i] - u[i]
        if closing <= 0.0 or gap > WINDOW * interval * closing:
            continue
        back = on.restitution * closing
        if back <= threshold:
            back = 0.0
        lost += 0.5 * reduced * (closing * closing - back * back)
        V -= s * share * (closing + back)
        w[i] = V + s * back
        away = -gap / closing * back
        place = away if low else play[i] - away
        lost += m * on.pull * (place - u[i])
        u[i] = place
        if back == 0.0:
            if low:
                hi[i] = math.inf
            else:
                lo[i] = -math.inf
    return V, lost
