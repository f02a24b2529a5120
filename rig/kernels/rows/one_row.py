"""A row of grains that slides, stops and hits the end walls of a box in prescribed motion, event by
event.

A row has unit mass, Coulomb friction `band` (an acceleration) against the box, a clearance and a
coefficient of restitution at both end walls. u in [0, clearance] is its position in the box, z = u'
its velocity relative to the box, w its velocity in the laboratory frame, all in units of the
waveform. A row with an infinite clearance has no end walls, and u may be negative. Between events
the motion is closed form; event phases are bracketed roots. Simultaneous events have a fixed order:
wall before stop, stop before region change.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from daq.compiled import njit
from rig.kernels.roots import EXACT, NEAR, TIGHT, halley
from rig.kernels.waveform import TWO_PI, Array, Ints, jet, motion, near_by

MAX_EVENTS = 512
"""Events of one row in one cycle; a row with more (elastic, frictionless, vanishing clearance) is
rejected.
"""

CHATTER = 1e-6
"""Rebound speed, in units of the waveform, below which a row stays at the wall: the neglected
energy is below 5e-13 of m V^2.
"""

GRAZING = 1e-14
"""Depth behind a wall up to which a stop counts as a stop at the wall: round-off, and below 1e-14
of m V^2.

A row that returns to the wall from which it was thrown, as in every orbit without drift, touches it
or not by round-off alone, and the phase of a contact at zero speed is known to half the digits
only.
"""

FREE, STOP, WALL = 0, 1, 2
"""Ends of a stretch of sliding: region change or end of the cycle; at rest in the box; at an end
wall.
"""


class RowSet(NamedTuple):
    """Independent rows of unit mass, units of the waveform.

    layer, clearance : layer number and clearance of each row, shape (rows,)
    restitution : of all rows at the end walls
    band, tables : threshold of each layer, shape (layers,), and its crossings by the waveform
        (`Crossings`)
    """

    layer: Ints
    clearance: Array
    restitution: float
    band: Array
    tables: Array


EVENTS = np.dtype(
    [
        ("phase", np.float64, (MAX_EVENTS,)),
        ("mode", np.int64, (MAX_EVENTS,)),
        ("w", np.float64, (MAX_EVENTS,)),
    ]
)
"""The new state at each event of a cycle: phase, mode, and the row's velocity in the laboratory
frame.

A record, because compiled code counts the references of every array that it passes on, which costs
as much as an event.
"""


def no_events() -> NDArray[np.void]:
    """Return room for the events of one cycle: an array of one record, which must outlive the
    record.
    """
    return np.empty(1, EVENTS)


class RowCycle(NamedTuple):
    """A row at the end of a cycle, and the energies of the cycle.

    mode : 0 rides with the box, +1 and -1 slide in that direction
    u, z : position and velocity relative to the box
    events : their number, -1 for more than `MAX_EVENTS`
    work : of the box on the row; friction, collision : losses
    roots : steps of root searches
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
def _stop(
    lo: float,
    f_lo: float,
    a_lo: float,
    hi: float,
    f_hi: float,
    start: float,
    y: float,
    w: float,
    band: float,
    s: float,
    wall: float,
    P: Array,
    Q: Array,
) -> tuple[float, float, float, float, int]:
    """Find the root of the sliding speed s z in a bracket where it falls from >= 0 to < 0.

    Halley's method, started from the parabola through both ends with the slope at `lo`, safeguarded
    by bisection; abandoned once the row is found behind the wall, because a hit comes first.
    Returns (phase; position, velocity, acceleration of the box there; number of steps).
    """
    span = hi - lo
    fall = (band + s * a_lo) * span
    bent = f_hi - f_lo + fall
    root = math.sqrt(max(fall * fall - 4.0 * bent * f_lo, 0.0))
    # Root of the parabola, in the form without cancellation.
    share = 2.0 * f_lo / (fall + root) if fall > 0.0 else 0.5 * (fall - root) / bent
    theta = lo + min(max(share, 0.0), 1.0) * span
    near = NEAR / P.shape[0]
    for n in range(1, 101):
        x, v, a, jerk, d4, d5, d6, d7 = jet(theta, P, Q)
        t = theta - start
        if s * (wall + x - y - w * t) + 0.5 * band * t * t < -GRAZING:
            return theta, x, v, a, n
        # Slip along the direction of sliding: friction decelerates the row at `band`.
        f = s * (w - v) - band * t
        if f >= 0.0:
            lo = theta
        else:
            hi = theta
        # Derivatives of f = s (w - v) - band t by the phase: f' = -band - s a, f'' = -s jerk.
        new, inside = halley(theta, lo, hi, f, -band - s * a, -s * jerk)
        step = new - theta
        if inside and abs(step) < near:
            for _ in range(3):
                place, speed, rate = near_by(step, x, v, a, jerk, d4, d5, d6, d7)
                steep = -band - s * rate
                if steep >= 0.0:
                    break
                fix = (s * (w - speed) - band * (t + step)) / steep
                step -= fix
                # Newton on the Taylor series; its error is known from curvature and slope, so no
                # further sine is needed.
                if fix * fix * (abs(jerk) + abs(steep)) <= EXACT * abs(steep):
                    return (
                        theta + step,
                        place - fix * speed,
                        speed - fix * rate,
                        rate - fix * jerk,
                        n,
                    )
        theta = new
        if hi - lo < TIGHT:
            break
    x, v, a = motion(theta, P, Q)
    return theta, x, v, a, n


@njit(cache=True, nogil=True, inline="always")
def _hit(
    lo: float,
    gap_lo: float,
    v_lo: float,
    hi: float,
    gap_hi: float,
    start: float,
    y: float,
    w: float,
    band: float,
    s: float,
    wall: float,
    P: Array,
    Q: Array,
) -> tuple[float, float, float, float, int]:
    """Find the root of the distance to the wall in a bracket where it falls from >= 0 to <= 0;
    returns as `_stop`.

    Halley's method, started from the parabola through both ends with the slope at `lo`, safeguarded
    by bisection.
    """
    span = hi - lo
    fall = (s * (w - v_lo) - band * (lo - start)) * span
    bent = fall * fall + 4.0 * (gap_lo - gap_hi - fall) * gap_lo
    below = fall + math.sqrt(max(bent, 0.0))
    theta = min(lo + 2.0 * gap_lo * span / below, hi) if below > 0.0 else hi
    near = NEAR / P.shape[0]
    for n in range(1, 101):
        x, v, a, jerk, d4, d5, d6, d7 = jet(theta, P, Q)
        t = theta - start
        # Distance to the wall: the row has moved w t - s band t^2/2 from its position y in the
        # laboratory frame.
        gap = s * (wall + x - y - w * t) + 0.5 * band * t * t
        closing = s * (w - v) - band * t
        if gap > 0.0:
            lo = theta
        else:
            hi = theta
        # Derivatives of the gap: gap' = -closing, gap'' = s a + band.
        new, inside = halley(theta, lo, hi, gap, -closing, s * a + band)
        step = new - theta
        if inside and abs(step) < near:
            for _ in range(3):
                place, speed, rate = near_by(step, x, v, a, jerk, d4, d5, d6, d7)
                u = t + step
                steep = s * (w - speed) - band * u
                if steep <= 0.0:
                    break
                fix = (s * (wall + place - y - w * u) + 0.5 * band * u * u) / steep
                step += fix
                if fix * fix * (abs(s * rate + band) + abs(steep)) <= EXACT * abs(steep):
                    return (
                        theta + step,
                        place + fix * speed,
                        speed + fix * rate,
                        rate + fix * jerk,
                        n,
                    )
        theta = new
        if hi - lo < TIGHT:
            break
    x, v, a = motion(theta, P, Q)
    return theta, x, v, a, n


@njit(cache=True, nogil=True, inline="always")
def _low(clearance: float) -> float:
    """Return the position of the lower end wall: 0, or minus infinity for a row without walls."""
    return 0.0 if clearance < math.inf else -math.inf


@njit(cache=True, nogil=True, inline="always")
def _thrown(region: int, u: float, low: float, clearance: float) -> int:
    """Return the direction in which a riding row starts to slide: against the box acceleration, if
    there is room; 0 for none.
    """
    if region == -1 and u < clearance:
        return 1
    if region == 1 and u > low:
        return -1
    return 0


@njit(cache=True, nogil=True, inline="always")
def cycle(
    mode: int,
    u: float,
    z: float,
    band: float,
    clearance: float,
    restitution: float,
    table: Array,
    P: Array,
    Q: Array,
    events: Any,
) -> RowCycle:
    """Advance a row by one cycle of the drive from (mode, u, z); its events are written to
    `events`, a record of `EVENTS`.

    `table` holds the crossings of the row's layer. One function on purpose, and inlined into its
    callers: a call passes six arrays, which costs as much as an event.
    """
    theta, x, v, a, region, ahead, n = (
        0.0,
        table[0, 1],
        table[0, 2],
        table[0, 4],
        int(table[0, 3]),
        1,
        0,
    )
    work, friction, collision, roots = 0.0, 0.0, 0.0, 0
    start, y, w = theta, x + u, v + z
    start_x, start_v, low = x, v, _low(clearance)
    while True:
        if mode == 0:
            mode = _thrown(region, u, low, clearance)
            # Ride on from crossing to crossing until one throws the row.
            while mode == 0 and theta < TWO_PI:
                theta, x, v, a = table[ahead, 0], table[ahead, 1], table[ahead, 2], table[ahead, 4]
                region = int(table[ahead, 3])
                ahead += 1
                mode = _thrown(region, u, low, clearance)
            # While riding, the row has the velocity of the box: the work is its change of kinetic
            # energy.
            work += 0.5 * (v * v - start_v * start_v)
            if mode == 0:
                return RowCycle(0, u, 0.0, n, work, friction, collision, roots)
            start, y, w, start_x = theta, x + u, v, x
            if n >= MAX_EVENTS:
                return RowCycle(mode, u, 0.0, -1, work, friction, collision, roots)
            events.phase[n], events.mode[n], events.w[n] = theta, mode, w
            n += 1
        s = float(mode)
        wall = clearance if mode == 1 else low
        end, x_end, v_end, a_end = (
            table[ahead, 0],
            table[ahead, 1],
            table[ahead, 2],
            table[ahead, 4],
        )
        t = end - start
        gap_end = s * (wall + x_end - y - w * t) + 0.5 * band * t * t
        closing_end = s * (w - v_end) - band * t
        hits = gap_end <= 0.0
        # In region -mode the box accelerates away from under the row, so the slip can only grow.
        stops = not hits and region != -mode and closing_end < 0.0
        begin = theta - start
        if stops:
            closing = s * (w - v) - band * begin
            end, x_end, v_end, a_end, steps = _stop(
                theta, max(closing, 0.0), a, end, closing_end, start, y, w, band, s, wall, P, Q
            )
            roots += steps
            t = end - start
            gap_end = s * (wall + x_end - y - w * t) + 0.5 * band * t * t
            hits = gap_end < -GRAZING
        if hits:
            gap = s * (wall + x - y - w * begin) + 0.5 * band * begin * begin
            end, x_end, v_end, a_end, steps = _hit(
                theta, max(gap, 0.0), v, end, gap_end, start, y, w, band, s, wall, P, Q
            )
            roots += steps
            t = end - start
        theta, x, v, a = end, x_end, v_end, a_end
        # Region change: the row slides on.
        if not hits and not stops and theta < TWO_PI:
            region = int(table[ahead, 3])
            ahead += 1
            continue
        before = u
        # Clamped: round-off must not put a row behind a wall.
        u = wall if hits else min(max(y + w * t - 0.5 * s * band * t * t - x, low), clearance)
        # Coulomb loss: friction times the slip relative to the box, whose sign is that of s.
        friction += band * s * (u - before)
        # Work of the box: friction force -s band on the row times the displacement of the box, not
        # of the slip.
        work -= s * band * (x - start_x)
        if not hits and not stops:
            return RowCycle(mode, u, w - s * band * t - v, n, work, friction, collision, roots)
        back = 0.0
        if hits:
            closing = max(s * (w - v) - band * t, 0.0)
            back = restitution * closing
            if back < CHATTER:
                back = 0.0
            collision += 0.5 * (closing * closing - back * back)
            # Impulse of the wall, -s (closing + back), times the velocity of the box, which it does
            # not change.
            work -= s * (closing + back) * v
        # After the rebound the row slides back; at rest on a wall it slides on if the box throws it
        # that way.
        mode = -mode if back > 0.0 or region == mode else 0
        w = v - s * back
        start, y, start_x, start_v = theta, x + u, x, v
        if n >= MAX_EVENTS:
            return RowCycle(mode, u, 0.0, -1, work, friction, collision, roots)
        events.phase[n], events.mode[n], events.w[n] = theta, mode, w
        n += 1
