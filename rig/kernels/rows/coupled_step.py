"""Rows of grains that react on the box: friction as one equation per step, impacts at the edges of
a fine grid.

A step lasts several intervals of the grid. During a step every row exerts a constant force: Coulomb
friction against the box, or the constraint force that keeps it at rest there, or the push of the
wall on which it leans. All rows enter one scalar equation for the box velocity V at the end of the
step: V = V_free - gain sum_i p_i(V), p_i = m clip(V - w_i, lo_i t, hi_i t), monotone and piecewise
linear, solved by Newton's method (Moreau 1988 for the implicit friction; the smooth part is exact).
A step ends early, at an edge at most `WINDOW` intervals after the first impact. There, rows that
have reached a wall exchange momentum with the free box, in order of their numbers: v' - V' = -e (v
- V).
"""

import math
from typing import NamedTuple

import numpy as np

from daq.compiled import njit
from rig.kernels.rows.tiles import BAND, CHUNK, CLEARANCE, FIELDS, HI, LO, P, U, W, clear, total
from rig.kernels.waveform import Array, Ints

NEWTON = 100
"""Most Newton or bisection steps; two or three are usual, the last of them as a check."""

RESIDUAL = 1e-14
"""Relative residual at which the velocity is accepted: the round-off of a sum over about a thousand
rows.
"""

WINDOW = 2
"""Intervals before and after an edge whose impacts are computed at that edge."""

NEAR = 1e-4
"""A leaning row stays in contact within this fraction of its clearance."""
NEARBY = 0.01
"""Clearance, m, above which `NEAR` no longer grows with it. Impacts elsewhere shake a leaning row
by less.
"""

HELD, LEANING = range(2)
"""Counts kept for each tile: rows that stick to the box, and rows that lean on a wall."""

GROUND = 1e7
"""Effective mass of a guide at rest, as a multiple of the box mass: creep while it sticks is below
1e-7 of the friction limit.
"""


class Pull(NamedTuple):
    """Forces on the box other than the rows', and the common properties of the rows, SI units.

    row_mass, restitution : of every row
    pull : acceleration of the rows along the axis due to gravity
    box : mass that takes part in an impact
    air : k of -k v |v|
    guide : Coulomb friction against the ground, N
    preload : constant support force on the box
    """

    row_mass: float
    restitution: float
    pull: float
    box: float
    air: float
    guide: float
    preload: float


@njit(cache=True, nogil=True)
def impulses(
    V: float, time: float, tiles: Array, rows: np.uint64, tally: Ints, lanes: Array
) -> tuple[float, int]:
    """Fill `P` with the impulse per unit mass on each row for a trial box velocity V at the end of
    the step. Returns (sum of impulses, number of sticking rows).

    V : relative to the velocity that gravity adds to the rows during the step
    tally : receives the number of sticking rows of each tile
    """
    held = 0
    clear(lanes)
    for begin in range(np.uint64(0), rows, CHUNK):
        tile, holds = begin * FIELDS, 0
        for j in range(np.uint64(0), min(CHUNK, rows - begin)):
            i = tile + j
            d = V - tiles[i + W]
            least, most = tiles[i + LO] * time, tiles[i + HI] * time
            # A row sticks (c = d: it reaches the box velocity) unless that exceeds its friction
            # limits.
            c = least if d < least else d
            c = most if c > most else c
            tiles[i + P] = c
            lanes[j] += c
            holds += 1 if c == d else 0
        tally[HELD, begin // CHUNK] = holds
        held += holds
    return total(lanes), held


@njit(cache=True, nogil=True)
def other_impulse(
    V: float, start: float, speed: float, time: float, on: Pull
) -> tuple[float, float, float, float]:
    """Return the impulses of the box on air, guide and preload over a step from velocity `start` to
    V, and their derivative by V.

    The air force is k |v| v with |v| = `speed`, predicted, and v the mean of both ends: linear in
    V, second order in the step.
    """
    air = 0.5 * on.air * time * speed * (start + V)
    # Sticking is a stiff viscous law, limited by Coulomb friction: it keeps the equation for V
    # scalar.
    hold = GROUND * on.box * V
    limit = on.guide * time
    guide = min(max(hold, -limit), limit)
    slope = 0.5 * on.air * time * speed + (
        GROUND * on.box if guide == hold and limit > 0.0 else 0.0
    )
    return air, guide, -on.preload * time, slope


@njit(cache=True, nogil=True, error_model="numpy")
def turn(V: float, start: float, time: float, tiles: Array, rows: np.uint64, lanes: Array) -> float:
    """Correct the friction impulse of rows whose slip reverses within the step. Returns the change
    of the sum, per mass.

    V : as in `impulses`; the box has the acceleration a = (V - start)/time relative to the rows.
        Slip z ends at t = |z|/(band + |a|) and, for |a| > band, starts again in the opposite
        direction: p = band (time - 2 t) in the direction of a. The implicit law applies full
        friction in one direction over the whole step, or none. A row that its wall pushes harder
        than friction could does not slide.
    """
    change, a = 0.0, (V - start) / time
    fast, toward = abs(a), math.copysign(1.0, a)
    for begin in range(np.uint64(0), rows, CHUNK):
        tile, here, turned = begin * FIELDS, min(CHUNK, rows - begin), 0
        for j in range(np.uint64(0), here):
            i = tile + j
            w = tiles[i + W]
            # Count first: reversals are rare, and most tiles need no second pass.
            turned += (
                1 if ((start - w) * (V - w - tiles[i + P]) <= 0.0) & (fast > tiles[i + BAND]) else 0
            )
        if turned == 0:
            continue
        clear(lanes)
        for j in range(np.uint64(0), here):
            i = tile + j
            w, p, band = tiles[i + W], tiles[i + P], tiles[i + BAND]
            z = start - w
            turns = (z * (V - w - p) <= 0.0) & (fast > band) & (abs(p) <= band * time)
            friction = toward * band * (time - 2.0 * abs(z) / (band + fast))
            friction = friction if turns & (abs(friction) <= abs(p)) else p
            lanes[j] = friction - p
            tiles[i + P] = friction
        change += total(lanes)
    return change


@njit(cache=True, nogil=True)
def end_velocity(
    V: float,
    start: float,
    free: float,
    gain: float,
    time: float,
    on: Pull,
    tiles: Array,
    rows: np.uint64,
    steady: float,
    tally: Ints,
    lanes: Array,
) -> tuple[float, float, float, float]:
    """Solve for the box velocity at the end of a step, starting from the guess V.

    steady : constant force on rows that are not in the tiles, N

    Returns (V; total impulse of the box, on the air, on the guide, N s). The impulses on the rows
    are in `P`, per mass.
    """
    low, high = -math.inf, math.inf
    given, air, guide, fall = 0.0, 0.0, 0.0, on.pull * time
    speed = 0.5 * abs(start + V)
    for _ in range(NEWTON):
        taken, count = impulses(V - fall, time, tiles, rows, tally, lanes)
        air, guide, preload, slope = other_impulse(V, start, speed, time, on)
        given = on.row_mass * taken + steady * time + air + guide + preload
        # Momentum balance of the box; it rises with V with a slope of at least 1, so its root is
        # unique.
        error = V - free + gain * given
        if abs(error) <= RESIDUAL * (abs(V) + abs(free) + gain * abs(given)):
            break
        if error > 0.0:
            high = V
        else:
            low = V
        better = V - error / (1.0 + gain * (on.row_mass * count + slope))
        # Newton's method may cycle between two pieces of a piecewise linear function: bisection
        # ends that.
        if not low < better < high:
            better = 0.5 * (low + high)
        if better == V:
            break
        V = better
    given += on.row_mass * turn(V - fall, start, time, tiles, rows, lanes)
    return V, given, air, guide


@njit(cache=True, nogil=True)
def next_walls(
    interval: float,
    steps: int,
    pull: float,
    per_time: float,
    path: Array,
    depth: float,
    tiles: Array,
    rows: np.uint64,
    who: Ints,
    room: Array,
) -> tuple[int, float]:
    """Return the number of rows that will pass a wall within the next intervals at their present
    friction, and the time of the first.

    path : predicted displacement of the box at the edges, m
    per_time : reciprocal of the duration of the latest impulses, 1/s
    depth : penetration that counts as passing, m
    who : receives the places of these rows, as -1 - place for the far wall

    The time is in intervals.
    """
    time = steps * interval
    half, fall = 0.5 * time * time * per_time, 0.5 * time * time * pull - path[steps]
    count, first = 0, math.inf
    for begin in range(np.uint64(0), rows, CHUNK):
        tile, here, beyond = begin * FIELDS, min(CHUNK, rows - begin), 0
        for j in range(np.uint64(0), here):
            i = tile + j
            place = tiles[i + U] + tiles[i + W] * time + half * tiles[i + P] + fall
            room[j] = place
            # An infinite limit marks a row that already leans on that wall.
            low = (place < -depth) & (tiles[i + HI] < math.inf)
            far = (place > tiles[i + CLEARANCE] + depth) & (tiles[i + LO] > -math.inf)
            beyond += 1 if low | far else 0
        if beyond == 0:
            continue
        for j in range(np.uint64(0), here):
            i, place = tile + j, room[j]
            if -depth <= place <= tiles[i + CLEARANCE] + depth:
                continue
            low = place < 0.0
            if (tiles[i + HI] if low else -tiles[i + LO]) == math.inf:
                continue
            a = tiles[i + P] * per_time + pull
            t = _crossing(
                tiles[i + W], a, tiles[i + U], tiles[i + CLEARANCE], low, interval, steps, path
            )
            who[count] = np.int64(i) if low else -1 - np.int64(i)
            count += 1
            first = min(first, t)
    return count, first


@njit(cache=True, nogil=True)
def _crossing(
    w: float,
    a: float,
    u: float,
    clearance: float,
    low: bool,
    interval: float,
    steps: int,
    path: Array,
) -> float:
    """Return the time, in intervals, at which a row first passes a wall, by linear interpolation
    between edges; 0 if it is outside.
    """
    before = u if low else clearance - u
    for k in range(1, steps + 1):
        s = k * interval
        now = u + (w + 0.5 * a * s) * s - path[k]
        gap = now if low else clearance - now
        if gap < 0.0:
            return k - 1 + (before / (before - gap) if before > 0.0 else 0.0)
        before = gap
    return float(steps)


@njit(cache=True, nogil=True)
def carry(
    a: float,
    start: float,
    time: float,
    part: float,
    moved: float,
    on: Pull,
    tiles: Array,
    rows: np.uint64,
    tally: Ints,
    lanes: Array,
    settle: bool,
) -> tuple[float, float]:
    """Move the rows through the first `part` (s) of a step of `time` (s).

    a : as in `turn`
    moved : displacement of the box in that part, m
    tally : number of sticking and of leaning rows of each tile
    settle : whether to correct the displacements of rows that come to rest

    Returns (heat, J; the part of it at walls on which rows lean, J): work of the constant forces on
    the slip.
    """
    per_time, pull, leant = 1.0 / time, on.pull, 0.0
    heat, pushed, ways = lanes[0], lanes[1], lanes[2]
    clear(heat)
    for begin in range(np.uint64(0), rows, CHUNK):
        tile, here = begin * FIELDS, min(CHUNK, rows - begin)
        for j in range(np.uint64(0), here):
            i = tile + j
            p, w = tiles[i + P], tiles[i + W]
            speed = (p * per_time + pull) * part
            way = moved - (w * part + 0.5 * speed * part)
            ways[j] = way
            heat[j] += p * way
            tiles[i + U] -= way
            tiles[i + W] = w + speed
        if settle and tally[HELD, begin // CHUNK]:
            _settle(a, start, time, pull * part, tiles, tile, here, ways)
        if tally[LEANING, begin // CHUNK]:
            work, still = _lean(time, pull * time, tiles, tile, here, ways, heat, pushed)
            leant += work
            tally[LEANING, begin // CHUNK] = still
    return on.row_mass * total(heat) * per_time, on.row_mass * leant * per_time


@njit(cache=True, nogil=True, error_model="numpy")
def _settle(
    a: float,
    start: float,
    time: float,
    fall: float,
    tiles: Array,
    tile: np.uint64,
    here: np.uint64,
    ways: Array,
) -> None:
    """Correct the displacements of rows that come to rest in the box within a step: z t/2, with t =
    |z|/(band - a sign z).

    If the slip were spread over the whole step, they would creep by an amount of first order in the
    step.
    """
    for j in range(np.uint64(0), here):
        i = tile + j
        p, limit, way = tiles[i + P], tiles[i + BAND], ways[j]
        z = start - (tiles[i + W] - (p + fall))
        slows = limit - (a if z > 0.0 else -a)
        rests = (abs(p) < limit * time) & (abs(z) < slows * time) & (abs(a) < limit)
        short = 0.5 * z * abs(z) / slows
        short = short if rests else way
        tiles[i + U] += way - short
        ways[j] = short


@njit(cache=True, nogil=True)
def _lean(
    time: float,
    fall: float,
    tiles: Array,
    tile: np.uint64,
    here: np.uint64,
    ways: Array,
    heat: Array,
    lanes: Array,
) -> tuple[float, int]:
    """Keep rows that lean on a wall in place unless they slide off.

    Returns (heat per mass, times time; number of rows that still lean). The heat is the work of
    wall pushes beyond friction, plus the work of gravity on the positions that are kept, which is
    added to `heat` as well.
    """
    clear(lanes)
    still = 0
    for j in range(np.uint64(0), here):
        i = tile + j
        least, most, p, way = tiles[i + LO], tiles[i + HI], tiles[i + P], ways[j]
        rub, place, room = tiles[i + BAND], tiles[i + U], tiles[i + CLEARANCE]
        stays = (most - least == math.inf) & (p != least * time) & (p != most * time)
        kept = way if stays else 0.0
        lanes[j] = (p - min(max(p, -rub * time), rub * time)) * way + fall * kept
        heat[j] += fall * kept
        place += kept
        # Away from the wall its push is no longer available: the limit returns to friction.
        near = NEAR * min(room, NEARBY)
        most = rub if place > near else most
        least = -rub if room - place > near else least
        tiles[i + U], tiles[i + HI], tiles[i + LO] = place, most, least
        still += 1 if most - least == math.inf else 0
    return total(lanes), still


@njit(cache=True, nogil=True)
def collide(
    V: float, interval: float, threshold: float, on: Pull, count: int, who: Ints, tiles: Array,
    tally: Ints,
) -> tuple[float, float]:  # fmt: skip
    """Compute the impacts at an edge. Returns (box velocity after them, energy lost, J).

    The rows in `who` that meet their wall within `WINDOW` intervals before or after exchange
    momentum with the box. They are then placed where they would be after an impact at the actual
    time. A rebound slower than `threshold` (m/s) is none: the row leans on the wall.
    """
    m = on.row_mass
    share, reduced = m / (m + on.box), m * on.box / (m + on.box)
    lost = 0.0
    for k in range(count):
        low = who[k] >= 0
        i = np.uint64(who[k] if low else -1 - who[k])
        u, w = tiles[i + U], tiles[i + W]
        s = 1.0 if low else -1.0
        closing = s * (V - w)
        gap = u if low else tiles[i + CLEARANCE] - u
        if closing <= 0.0 or gap > WINDOW * interval * closing:
            continue
        back = on.restitution * closing
        if back <= threshold:
            back = 0.0
        # Loss of a pair, m_r (1 - e^2) w^2/2 with the reduced mass of row and box.
        lost += 0.5 * reduced * (closing * closing - back * back)
        V -= s * share * (closing + back)
        tiles[i + W] = V + s * back
        away = -gap / closing * back
        place = away if low else tiles[i + CLEARANCE] - away
        # Moving the row changes its potential energy: booked here, so that the ledger closes.
        lost += m * on.pull * (place - u)
        tiles[i + U] = place
        if back == 0.0:
            tally[LEANING, i // (CHUNK * FIELDS)] = 1
            if low:
                tiles[i + HI] = math.inf
            else:
                tiles[i + LO] = -math.inf
    return V, lost
