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

from rig.kernels.rows.pages import BAND, CHUNK, FIELDS, HI, LO, PLAY, P, U, W, clear, total
from rig.kernels.waveform import Array, Ints

NEWTON = 100
"""Newton or bisection steps at most; two or three are usual, the last of them as a check."""

RESIDUAL = 1e-14
"""Relative residual at which the velocity counts as found: some round-off of a sum over a thousand rows."""

WINDOW = 2
"""Intervals before and behind an edge whose impacts are dealt with at that edge."""

NEAR = 1e-4
NEARBY = 0.01
"""Share of its play, of 10 mm at most, within which a row that has leaned on a wall still does: impacts elsewhere shake
it by less."""

HELD, LEANING = range(2)
"""What is counted of each page: rows that the box holds, and rows that lean on a wall."""

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
def impulses(V: float, time: float, pages: Array, rows: np.uint64, tally: Ints, lanes: Array) -> tuple[float, int]:
    """Impulses per mass, `P`, that give rows a box that ends a step with velocity V; their sum, and how many it holds.

    V : less what gravity gives the rows meanwhile. How many are held stands in `tally` too, by page.
    """
    held = 0
    clear(lanes)
    for begin in range(np.uint64(0), rows, CHUNK):
        page, holds = begin * FIELDS, 0
        for j in range(np.uint64(0), min(CHUNK, rows - begin)):
            i = page + j
            d = V - pages[i + W]
            least, most = pages[i + LO] * time, pages[i + HI] * time
            c = least if d < least else d
            c = most if c > most else c
            pages[i + P] = c
            lanes[j] += c
            holds += 1 if c == d else 0
        tally[HELD, begin // CHUNK] = holds
        held += holds
    return total(lanes), held


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


@njit(cache=True, nogil=True, error_model="numpy")
def turn(V: float, start: float, time: float, pages: Array, rows: np.uint64, lanes: Array) -> float:
    """Give rows whose slip changes sign within a step the friction of both parts; the change of all impulses, per mass.

    V : as in `impulses`; the box gains a = (V - start)/time on the rows. Slip z ends at t = |z|/(band + |a|) and begins
    anew the other way for |a| > band: p = band (time - 2 t) in the direction of a. The implicit law has it all that
    way, or leaves none. A row that its wall pushes harder than friction could slides nowhere.
    """
    change, a = 0.0, (V - start) / time
    fast, toward = abs(a), math.copysign(1.0, a)
    for begin in range(np.uint64(0), rows, CHUNK):
        page, here, turned = begin * FIELDS, min(CHUNK, rows - begin), 0
        for j in range(np.uint64(0), here):
            i = page + j
            w = pages[i + W]
            turned += 1 if ((start - w) * (V - w - pages[i + P]) <= 0.0) & (fast > pages[i + BAND]) else 0
        if turned == 0:
            continue
        clear(lanes)
        for j in range(np.uint64(0), here):
            i = page + j
            w, p, band = pages[i + W], pages[i + P], pages[i + BAND]
            z = start - w
            turns = (z * (V - w - p) <= 0.0) & (fast > band) & (abs(p) <= band * time)
            friction = toward * band * (time - 2.0 * abs(z) / (band + fast))
            friction = friction if turns & (abs(friction) <= abs(p)) else p
            lanes[j] = friction - p
            pages[i + P] = friction
        change += total(lanes)
    return change


@njit(cache=True, nogil=True)
def end_velocity(
    V: float, start: float, free: float, gain: float, time: float, on: Pull, pages: Array, rows: np.uint64,
    steady: float, tally: Ints, lanes: Array,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Box velocity at the end of a step, guessed as V, and the impulses that the box gives: all, the air, the guide.

    steady : constant force on rows that are not in the pages, N. The rows' part stands in `P`, per mass.
    """
    low, high = -math.inf, math.inf
    given, air, guide, fall = 0.0, 0.0, 0.0, on.pull * time
    speed = 0.5 * abs(start + V)
    for _ in range(NEWTON):
        taken, count = impulses(V - fall, time, pages, rows, tally, lanes)
        air, guide, preload, slope = other_impulse(V, start, speed, time, on)
        given = on.row_mass * taken + steady * time + air + guide + preload
        error = V - free + gain * given
        if abs(error) <= RESIDUAL * (abs(V) + abs(free) + gain * abs(given)):
            break
        if error > 0.0:
            high = V
        else:
            low = V
        better = V - error / (1.0 + gain * (on.row_mass * count + slope))
        if not low < better < high:
            better = 0.5 * (low + high)
        if better == V:
            break
        V = better
    given += on.row_mass * turn(V - fall, start, time, pages, rows, lanes)
    return V, given, air, guide


@njit(cache=True, nogil=True)
def next_walls(
    interval: float, steps: int, pull: float, per_time: float, path: Array, depth: float, pages: Array,
    rows: np.uint64, who: Ints, room: Array,
) -> tuple[int, float]:  # fmt: skip
    """Rows that will pass a wall within some intervals if their friction stays as it was, and when the first one does.

    path : how far the box will have moved at the edges, m; `per_time` : one over the time that the latest impulses
    took; depth : how far a row has to pass, m. Places of rows go to `who`, as -1 - place for the far wall; returns
    their number and the time in intervals.
    """
    time = steps * interval
    half, fall = 0.5 * time * time * per_time, 0.5 * time * time * pull - path[steps]
    count, first = 0, math.inf
    for begin in range(np.uint64(0), rows, CHUNK):
        page, here, beyond = begin * FIELDS, min(CHUNK, rows - begin), 0
        for j in range(np.uint64(0), here):
            i = page + j
            place = pages[i + U] + pages[i + W] * time + half * pages[i + P] + fall
            room[j] = place
            low = (place < -depth) & (pages[i + HI] < math.inf)
            far = (place > pages[i + PLAY] + depth) & (pages[i + LO] > -math.inf)
            beyond += 1 if low | far else 0
        if beyond == 0:
            continue
        for j in range(np.uint64(0), here):
            i, place = page + j, room[j]
            if -depth <= place <= pages[i + PLAY] + depth:
                continue
            low = place < 0.0
            if (pages[i + HI] if low else -pages[i + LO]) == math.inf:
                continue
            a = pages[i + P] * per_time + pull
            t = _crossing(pages[i + W], a, pages[i + U], pages[i + PLAY], low, interval, steps, path)
            who[count] = np.int64(i) if low else -1 - np.int64(i)
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
    a: float, start: float, time: float, part: float, moved: float, on: Pull, pages: Array, rows: np.uint64,
    tally: Ints, lanes: Array, settle: bool,
) -> tuple[float, float]:  # fmt: skip
    """Move the rows through the first `part` (s) of a step of `time` (s); heat in all, and that of leaning, J.

    a : as in `turn`; moved : how far the box moves in that part, m; tally : how many rows of each page the box holds,
    and how many lean on a wall; settle : correct the ways of rows that come to rest. The heat is that of the constant
    forces.
    """
    per_time, pull, leant = 1.0 / time, on.pull, 0.0
    heat, pushed, ways = lanes[0], lanes[1], lanes[2]
    clear(heat)
    for begin in range(np.uint64(0), rows, CHUNK):
        page, here = begin * FIELDS, min(CHUNK, rows - begin)
        for j in range(np.uint64(0), here):
            i = page + j
            p, w = pages[i + P], pages[i + W]
            speed = (p * per_time + pull) * part
            way = moved - (w * part + 0.5 * speed * part)
            ways[j] = way
            heat[j] += p * way
            pages[i + U] -= way
            pages[i + W] = w + speed
        if settle and tally[HELD, begin // CHUNK]:
            _settle(a, start, time, pull * part, pages, page, here, ways)
        if tally[LEANING, begin // CHUNK]:
            work, still = _lean(time, pull * time, pages, page, here, ways, heat, pushed)
            leant += work
            tally[LEANING, begin // CHUNK] = still
    return on.row_mass * total(heat) * per_time, on.row_mass * leant * per_time


@njit(cache=True, nogil=True, error_model="numpy")
def _settle(
    a: float, start: float, time: float, fall: float, pages: Array, page: np.uint64, here: np.uint64, ways: Array
) -> None:
    """Ways of rows that come to rest in the box within a step: slip z ends at t = |z|/(band - a sign z), way z t/2.

    With the slip spread over the whole step they would creep by an amount of first order in the step.
    """
    for j in range(np.uint64(0), here):
        i = page + j
        p, limit, way = pages[i + P], pages[i + BAND], ways[j]
        z = start - (pages[i + W] - (p + fall))
        slows = limit - (a if z > 0.0 else -a)
        rests = (abs(p) < limit * time) & (abs(z) < slows * time) & (abs(a) < limit)
        short = 0.5 * z * abs(z) / slows
        short = short if rests else way
        pages[i + U] += way - short
        ways[j] = short


@njit(cache=True, nogil=True)
def _lean(
    time: float, fall: float, pages: Array, page: np.uint64, here: np.uint64, ways: Array, heat: Array, lanes: Array
) -> tuple[float, int]:  # fmt: skip
    """Keep rows that lean on a wall there unless they slide off; how many still lean.

    Heat, per mass and times time: of what walls push beyond friction, and gravity's work on what is kept, which goes to
    `heat` as well.
    """
    clear(lanes)
    still = 0
    for j in range(np.uint64(0), here):
        i = page + j
        least, most, p, way = pages[i + LO], pages[i + HI], pages[i + P], ways[j]
        rub, place, room = pages[i + BAND], pages[i + U], pages[i + PLAY]
        stays = (most - least == math.inf) & (p != least * time) & (p != most * time)
        kept = way if stays else 0.0
        lanes[j] = (p - min(max(p, -rub * time), rub * time)) * way + fall * kept
        heat[j] += fall * kept
        place += kept
        near = NEAR * min(room, NEARBY)
        most = rub if place > near else most
        least = -rub if room - place > near else least
        pages[i + U], pages[i + HI], pages[i + LO] = place, most, least
        still += 1 if most - least == math.inf else 0
    return total(lanes), still


@njit(cache=True, nogil=True)
def collide(
    V: float, interval: float, threshold: float, on: Pull, count: int, who: Ints, pages: Array,
    tally: Ints,
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
        i = np.uint64(who[k] if low else -1 - who[k])
        u, w = pages[i + U], pages[i + W]
        s = 1.0 if low else -1.0
        closing = s * (V - w)
        gap = u if low else pages[i + PLAY] - u
        if closing <= 0.0 or gap > WINDOW * interval * closing:
            continue
        back = on.restitution * closing
        if back <= threshold:
            back = 0.0
        lost += 0.5 * reduced * (closing * closing - back * back)
        V -= s * share * (closing + back)
        pages[i + W] = V + s * back
        away = -gap / closing * back
        place = away if low else pages[i + PLAY] - away
        lost += m * on.pull * (place - u)
        pages[i + U] = place
        if back == 0.0:
            tally[LEANING, i // (CHUNK * FIELDS)] = 1
            if low:
                pages[i + HI] = math.inf
            else:
                pages[i + LO] = -math.inf
    return V, lost
