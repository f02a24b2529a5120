"""Rows of grains that slide, stop and hit the end walls of a box in programmed motion, event by event.

A row has unit mass, Coulomb friction `band` (an acceleration) against the box, a free play and a restitution at
both end walls. u in [0, play] is its position in the box, z = u' its velocity against the box, all in the units
of the waveform. Between events the motion is closed form; event phases are bracketed roots. Simultaneous events
have a fixed order: wall before stop, stop before region change.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rig.kernels.waveform import TWO_PI, Array, Ints, motion, motion_and_jerk

MAX_EVENTS = 512
"""Events of one row in one cycle; a row that needs more (elastic, frictionless, vanishing play) is refused."""

CHATTER = 1e-6
"""Rebounds slower than this many waveform velocities end at the wall: what is cut off is below 5e-13 of m V^2."""

NEAR, STRAIGHT = 3e-6, 1e-6
"""Step, rad, and change of slope over it as a share, behind which the next step would lie below round-off: Halley's
error is the step times the square of that share. Both are asked for, because Halley's step vanishes with the slope,
root or not; where the slope changes by more than itself, Newton's step is taken.
"""

TIGHT = 1e-15
"""Bracket width, rad, at which bisection has nothing left to halve."""

FREE, STOP, WALL = 0, 1, 2
"""How a stretch of sliding ends: at a region change or the end of the cycle, at rest in the box, at an end wall."""


class Rows(NamedTuple):
    """Independent rows of unit mass, units of the waveform.

    layer, play : of each row, shape (rows,)
    restitution : of all rows at the end walls
    band, tables : threshold of each layer, shape (layers,), and where the waveform crosses it (`Crossings`)
    """

    layer: Ints
    play: Array
    restitution: float
    band: Array
    tables: Array


EVENTS = np.dtype(
    [("phase", np.float64, (MAX_EVENTS,)), ("mode", np.int64, (MAX_EVENTS,)), ("w", np.float64, (MAX_EVENTS,))]
)
"""What starts at each event of a cycle: phase, mode, and the row's velocity in the laboratory.

A record, because compiled code counts the references of every array that it hands on, which costs as much as an event.
"""


def no_events() -> NDArray[np.void]:
    """Room for the events of one cycle: an array of one record, which has to outlive the record."""
    return np.empty(1, EVENTS)


class Cycle(NamedTuple):
    """A row at the end of a cycle, the number of its events (-1: more than `MAX_EVENTS`), and the cycle's energies.

    mode : 0 rides with the box, +1 and -1 slide towards that side
    work : of the box on the row; friction, collision : losses; roots : steps of root searches
    """

    mode: int
    u: float
    z: float
    events: int
    work: float
    friction: float
    collision: float
    roots: int


@njit(cache=True, nogil=True, inline="always")
def _carried(step: float, x: float, v: float, a: float, jerk: float) -> tuple[float, float]:
    """Position and velocity of the box a phase `step` later, |step| <= `NEAR`: what is left out is below 1e-17."""
    return x + step * (v + step * (0.5 * a + step * jerk / 6.0)), v + step * (a + 0.5 * step * jerk)


@njit(cache=True, nogil=True, inline="always")
def _stop(
    lo: float, f_lo: float, hi: float, f_hi: float, start: float, w: float, band: float, s: float, P: Array, Q: Array
) -> tuple[float, float, float, int]:  # fmt: skip
    """Root of s z in a bracket where it falls from >= 0 to < 0: phase, the box's position and velocity, iterations.

    Halley's method from the secant, safeguarded by bisection.
    """
    theta = lo + (hi - lo) * f_lo / (f_lo - f_hi)
    for n in range(1, 101):
        x, v, a, jerk = motion_and_jerk(theta, P, Q)
        f = s * (w - v) - band * (theta - start)
        if f >= 0.0:
            lo = theta
        else:
            hi = theta
        slope = -band - s * a
        square, bend = slope * slope, 0.5 * f * s * jerk
        if abs(bend) > 0.5 * square:
            bend = 0.0
        new = theta - f * slope / (square + bend) if slope < 0.0 and square > 0.0 else lo - 1.0
        inside = lo <= new <= hi
        if not inside:
            new = 0.5 * (lo + hi)
        step = new - theta
        theta = new
        if inside and abs(step) < NEAR and abs(0.5 * f * jerk) <= STRAIGHT * square:
            x, v = _carried(step, x, v, a, jerk)
            return theta, x, v, n
        if hi - lo < TIGHT:
            break
    x, v, _ = motion(theta, P, Q)
    return theta, x, v, n


@njit(cache=True, nogil=True, inline="always")
def _hit(
    lo: float, gap_lo: float, v_lo: float, hi: float, gap_hi: float, start: float, y: float, w: float, band: float,
    s: float, wall: float, P: Array, Q: Array,
) -> tuple[float, float, float, int]:  # fmt: skip
    """Root of the distance to the wall in a bracket where it falls from >= 0 to <= 0; returns as `_stop` does.

    Halley's method from the parabola through both ends with the slope `v_lo` gives, safeguarded by bisection.
    """
    span = hi - lo
    fall = (s * (w - v_lo) - band * (lo - start)) * span
    bent = fall * fall + 4.0 * (gap_lo - gap_hi - fall) * gap_lo
    below = fall + math.sqrt(max(bent, 0.0))
    theta = min(lo + 2.0 * gap_lo * span / below, hi) if below > 0.0 else hi
    for n in range(1, 101):
        x, v, a, jerk = motion_and_jerk(theta, P, Q)
        t = theta - start
        gap = s * (wall + x - y - w * t) + 0.5 * band * t * t
        closing = s * (w - v) - band * t
        if gap > 0.0:
            lo = theta
        else:
            hi = theta
        square, bend = closing * closing, -0.5 * gap * (s * a + band)
        if abs(bend) > 0.5 * square:
            bend = 0.0
        new = theta + gap * closing / (square + bend) if closing > 0.0 and square > 0.0 else lo - 1.0
        inside = lo <= new <= hi
        if not inside:
            new = 0.5 * (lo + hi)
        step = new - theta
        theta = new
        if inside and abs(step) < NEAR and abs(0.5 * gap * (s * a + band)) <= STRAIGHT * square:
            x, v = _carried(step, x, v, a, jerk)
            return theta, x, v, n
        if hi - lo < TIGHT:
            break
    x, v, _ = motion(theta, P, Q)
    return theta, x, v, n


@njit(cache=True, nogil=True, inline="always")
def _thrown(region: int, u: float, play: float) -> int:
    """Direction in which a riding row is thrown: against the box's acceleration, where there is room; 0 for none."""
    if region == -1 and u < play:
        return 1
    if region == 1 and u > 0.0:
        return -1
    return 0


@njit(cache=True, nogil=True, inline="always")
def cycle(
    mode: int, u: float, z: float, band: float, play: float, restitution: float, table: Array, P: Array, Q: Array,
    events: Any,
) -> Cycle:  # fmt: skip
    """Advance a row by one cycle of the drive from (mode, u, z); `table` is its layer's, its events go to `events`.

    `events` is a record of `EVENTS`. One function on purpose, and compiled into its callers: a call hands on six
    arrays, which costs as much as an event.
    """
    theta, x, v, region, ahead, n = 0.0, table[0, 1], table[0, 2], int(table[0, 3]), 1, 0
    work, friction, collision, roots = 0.0, 0.0, 0.0, 0
    start, y, w = theta, x + u, v + z
    start_x, start_v = x, v
    while True:
        if mode == 0:
            mode = _thrown(region, u, play)
            while mode == 0 and theta < TWO_PI:
                theta, x, v, region = table[ahead, 0], table[ahead, 1], table[ahead, 2], int(table[ahead, 3])
                ahead += 1
                mode = _thrown(region, u, play)
            work += 0.5 * (v * v - start_v * start_v)
            if mode == 0:
                return Cycle(0, u, 0.0, n, work, friction, collision, roots)
            start, y, w, start_x = theta, x + u, v, x
            if n >= MAX_EVENTS:
                return Cycle(mode, u, 0.0, -1, work, friction, collision, roots)
            events.phase[n], events.mode[n], events.w[n] = theta, mode, w
            n += 1
        s = float(mode)
        wall = play if mode == 1 else 0.0
        end, x_end, v_end = table[ahead, 0], table[ahead, 1], table[ahead, 2]
        t = end - start
        gap_end = s * (wall + x_end - y - w * t) + 0.5 * band * t * t
        closing_end = s * (w - v_end) - band * t
        hits = gap_end <= 0.0
        stops = not hits and region != -mode and closing_end < 0.0
        begin = theta - start
        if stops:
            closing = s * (w - v) - band * begin
            end, x_end, v_end, steps = _stop(theta, max(closing, 0.0), end, closing_end, start, w, band, s, P, Q)
            roots += steps
            t = end - start
            gap_end = s * (wall + x_end - y - w * t) + 0.5 * band * t * t
            hits = gap_end <= 0.0
        if hits:
            gap = s * (wall + x - y - w * begin) + 0.5 * band * begin * begin
            end, x_end, v_end, steps = _hit(theta, max(gap, 0.0), v, end, gap_end, start, y, w, band, s, wall, P, Q)
            roots += steps
            t = end - start
        theta, x, v = end, x_end, v_end
        if not hits and not stops and theta < TWO_PI:
            region = int(table[ahead, 3])
            ahead += 1
            continue
        before = u
        u = wall if hits else min(max(y + w * t - 0.5 * s * band * t * t - x, 0.0), play)
        friction += band * s * (u - before)
        work -= s * band * (x - start_x)
        if not hits and not stops:
            return Cycle(mode, u, w - s * band * t - v, n, work, friction, collision, roots)
        back = 0.0
        if hits:
            closing = max(s * (w - v) - band * t, 0.0)
            back = restitution * closing
            if back < CHATTER:
                back = 0.0
            collision += 0.5 * (closing * closing - back * back)
            work -= s * (closing + back) * v
        mode = -mode if back > 0.0 or region == mode else 0
        w = v - s * back
        start, y, start_x, start_v = theta, x + u, x, v
        if n >= MAX_EVENTS:
            return Cycle(mode, u, 0.0, -1, work, friction, collision, roots)
        events.phase[n], events.mode[n], events.w[n] = theta, mode, w
        n += 1
