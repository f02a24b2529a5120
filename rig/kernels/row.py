"""Rows of grains that slide, stop and hit the end walls of a box in programmed motion, event by event.

A row has unit mass, Coulomb friction `band` (an acceleration) against the box, a free play and a restitution at
both end walls. u in [0, play] is its position in the box, z = u' its velocity against the box, all in the units
of the waveform. Between events the motion is closed form; event phases are bracketed roots. Simultaneous events
have a fixed order: wall before stop, stop before region change.
"""

import math

import numpy as np
from numba import njit

from rig.kernels.waveform import TWO_PI, motion

MAX_EVENTS = 512
"""Events of one row in one cycle; a row that needs more (elastic, frictionless, vanishing play) is refused."""

CHATTER = 1e-6
"""Rebounds slower than this many waveform velocities end at the wall: what is cut off is below 5e-13 of m V^2."""


CONVERGED = 1e-9
"""Newton step, rad, behind which the next would lie below round-off (its square times the curvature)."""

TIGHT = 1e-15
"""Bracket width, rad, at which bisection has nothing left to halve."""


@njit(cache=True, nogil=True)
def _stop_phase(lo, f_lo, hi, f_hi, start, w, band, s, P, Q):
    """Root of s z in a bracket where it falls from >= 0 to < 0: safeguarded Newton from the secant."""
    theta = lo + (hi - lo) * f_lo / (f_lo - f_hi)
    for _ in range(100):
        _, v, a = motion(theta, P, Q)
        f = s * (w - v) - band * (theta - start)
        if f >= 0.0:
            lo = theta
        else:
            hi = theta
        slope = -band - s * a
        new = theta - f / slope if slope < 0.0 else lo - 1.0
        newton = lo <= new <= hi
        if not newton:
            new = 0.5 * (lo + hi)
        step = abs(new - theta)
        theta = new
        if (newton and step < CONVERGED) or hi - lo < TIGHT:
            break
    return theta


@njit(cache=True, nogil=True)
def _hit_phase(lo, gap_lo, hi, gap_hi, start, y, w, band, s, wall, P, Q):
    """Root of the distance to the wall in a bracket where it falls from >= 0 to <= 0: safeguarded Newton."""
    theta = lo + (hi - lo) * gap_lo / (gap_lo - gap_hi) if gap_lo > gap_hi else hi
    for _ in range(100):
        x, v, _ = motion(theta, P, Q)
        t = theta - start
        gap = s * (wall + x - y - w * t) + 0.5 * band * t * t
        closing = s * (w - v) - band * t
        if gap > 0.0:
            lo = theta
        else:
            hi = theta
        new = theta + gap / closing if closing > 0.0 else lo - 1.0
        newton = lo <= new <= hi
        if not newton:
            new = 0.5 * (lo + hi)
        step = abs(new - theta)
        theta = new
        if (newton and step < CONVERGED) or hi - lo < TIGHT:
            break
    return theta


@njit(cache=True, nogil=True)
def cycle(mode, u, z, band, play, restitution, count, table, regions, first, P, Q, event_phase, event_mode, event_w):
    """Advance one row by one cycle of the drive.

    mode 0 rides with the box, +1 and -1 slide; count, table, regions and first are those of `crossings`. Writes what starts at each event (phase, mode, velocity in the
    laboratory) and returns (mode, u, z, events, work of the box on the row, friction loss, collision loss).
    events is -1 where they exceed `MAX_EVENTS`.
    """
    x0, v0, _ = motion(0.0, P, Q)
    x, v = x0, v0
    theta, region, j, n = 0.0, first, 0, 0
    while j < count and table[j, 0] <= 0.0:
        region = regions[j]
        j += 1
    work, friction, collision = 0.0, 0.0, 0.0
    start, y, w = 0.0, x + u, v + z
    start_x, start_v = x, v
    while True:
        if mode == 0:
            leave = 0
            if region == -1 and u < play:
                leave = 1
            elif region == 1 and u > 0.0:
                leave = -1
            while leave == 0 and j < count:
                theta, x, v, region = table[j, 0], table[j, 1], table[j, 2], regions[j]
                j += 1
                if region == -1 and u < play:
                    leave = 1
                elif region == 1 and u > 0.0:
                    leave = -1
            if leave == 0:
                theta, x, v = TWO_PI, x0, v0
            work += 0.5 * (v * v - start_v * start_v)
            if leave == 0:
                return 0, u, 0.0, n, work, friction, collision
            mode, start, y, w, start_x = leave, theta, x + u, v, x
            if n >= MAX_EVENTS:
                return mode, u, 0.0, -1, work, friction, collision
            event_phase[n], event_mode[n], event_w[n] = theta, mode, w
            n += 1
        s = float(mode)
        wall = play if mode == 1 else 0.0
        if j < count:
            end, x_end, v_end = table[j, 0], table[j, 1], table[j, 2]
        else:
            end, x_end, v_end = TWO_PI, x0, v0
        t = end - start
        gap_end = s * (wall + x_end - y - w * t) + 0.5 * band * t * t
        closing_end = s * (w - v_end) - band * t
        hits = gap_end <= 0.0
        stops = not hits and region != -mode and closing_end < 0.0
        begin = theta - start
        if stops:
            closing = s * (w - v) - band * begin
            end = _stop_phase(theta, max(closing, 0.0), end, closing_end, start, w, band, s, P, Q)
            x_end, v_end, _ = motion(end, P, Q)
            t = end - start
            gap_end = s * (wall + x_end - y - w * t) + 0.5 * band * t * t
            hits = gap_end <= 0.0
        if hits:
            gap = s * (wall + x - y - w * begin) + 0.5 * band * begin * begin
            end = _hit_phase(theta, max(gap, 0.0), end, gap_end, start, y, w, band, s, wall, P, Q)
            x_end, v_end, _ = motion(end, P, Q)
            t = end - start
        x, v = x_end, v_end
        theta = end
        if not hits and not stops and j < count:
            region = regions[j]
            j += 1
            continue
        before = y - start_x
        u = wall if hits else min(max(y + w * t - 0.5 * s * band * t * t - x, 0.0), play)
        friction += band * s * (u - before)
        work -= s * band * (x - start_x)
        if not hits and not stops:
            return mode, u, w - s * band * t - v, n, work, friction, collision
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
            return mode, u, 0.0, -1, work, friction, collision
        event_phase[n], event_mode[n], event_w[n] = theta, mode, w
        n += 1
