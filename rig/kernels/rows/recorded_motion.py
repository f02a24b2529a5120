"""Rows of grains in a box whose acceleration is known by samples: linear between them, events
exact.

A row has unit mass, Coulomb friction `band` (an acceleration) against the box, a clearance and a
coefficient of restitution at both end walls; u in [0, clearance] is its position in the box, z = u'
its velocity relative to the box, SI units. A row with an infinite clearance has no end walls. The
laws are those of `rig.kernels.rows.one_row`, where the motion is a few harmonics in closed form;
here it is arbitrary. Between two samples z is a parabola and u a cubic in time: a stop is a root of
the first, a hit one of the second.
"""

import math

import numpy as np
from numpy.typing import NDArray

from daq.compiled import njit

Array = NDArray[np.float64]

CHATTER = 1e-6
"""Rebound speed, as a fraction of the largest box velocity, below which a row stays at the wall, as
in `rig.kernels.rows.one_row`.
"""

MOST_EVENTS = 200
"""Most events of a row between two samples; a row with more ends its chatter there."""


@njit(cache=True, nogil=True, inline="always")
def _stop(z: float, c: float, j: float, most: float) -> float:
    """Return the first time in (0, most] at which z + c t + j t^2/2 falls below 0, z >= 0; inf for
    none.
    """
    if z <= 0.0:
        if c > 0.0 and j < 0.0:
            time = -2.0 * c / j
            return time if time <= most else math.inf
        return math.inf if c > 0.0 or (c == 0.0 and j >= 0.0) else 0.0
    square = c * c - 2.0 * j * z
    if square < 0.0:
        return math.inf
    root = math.sqrt(square)
    if c < 0.0:
        # Both branches avoid the difference of nearly equal numbers.
        time = 2.0 * z / (-c + root)
    elif j < 0.0:
        time = (-c - root) / j
    else:
        return math.inf
    return time if time <= most else math.inf


@njit(cache=True, nogil=True)
def _hit(gap: float, z: float, c: float, j: float, hi: float) -> float:
    """Return the time in (0, hi] at which z t + c t^2/2 + j t^3/6 reaches `gap`, which it exceeds
    at `hi`.

    Newton's method in a bracket.
    """
    lo, t = 0.0, hi
    for _ in range(100):
        over = ((j / 6.0 * t + 0.5 * c) * t + z) * t - gap
        if over > 0.0:
            hi = t
        else:
            lo = t
        speed = z + (c + 0.5 * j * t) * t
        new = t - over / speed if speed > 0.0 else lo - 1.0
        newton = lo <= new <= hi
        if not newton:
            new = 0.5 * (lo + hi)
        step = abs(new - t)
        t = new
        if step <= 1e-15 * (hi + t) or (newton and step < 1e-9 * t):
            break
    return t


@njit(cache=True, nogil=True)
def sampled_energy(
    band: Array,
    clearance: Array,
    restitution: float,
    acceleration: Array,
    step: float,
    settle: int,
    ramp: int = 0,
) -> tuple[float, float]:
    """Return the friction and collision losses of all rows over one period of a sampled box
    acceleration, J per kg of a row.

    band, clearance : of each row, m/s^2 and m, shape (rows,)
    acceleration : at uniform times `step` (s) apart, m/s^2, shape (samples,); it is periodic, the
        last sample joins the first
    settle : number of final samples that the rows, initially at rest at one wall, go through before
        the count begins
    ramp : number of samples before those, in which the acceleration grows linearly from zero
    """
    n = acceleration.shape[0]
    velocity, drift, fastest = 0.0, acceleration.mean(), 0.0
    for k in range(n):
        # A mean acceleration would integrate to an endless velocity: only the fluctuation sets the
        # scale.
        velocity += (acceleration[k] - drift) * step
        fastest = max(fastest, abs(velocity))
    slow = CHATTER * fastest
    largest = np.abs(acceleration).max()
    friction, collision = 0.0, 0.0
    for r in range(band.shape[0]):
        # The box never exceeds the friction of this row: it rides.
        if band[r] >= largest:
            continue
        mode, u, z = 0, 0.0, 0.0
        # Negative m: ramp and settling, on the end of the periodic record.
        for m in range(-settle - ramp, n):
            k = m % n
            first, last = acceleration[k], acceleration[(k + 1) % n]
            if m < -settle:
                first *= (m + settle + ramp) / ramp
                last *= (m + 1 + settle + ramp) / ramp
            mode, u, z, rubbed, struck = _across(
                mode, u, z, band[r], clearance[r], restitution, first, last, step, slow
            )
            if m >= 0:
                friction += rubbed
                collision += struck
    return friction, collision


@njit(cache=True, nogil=True)
def _across(
    mode: int,
    u: float,
    z: float,
    band: float,
    clearance: float,
    restitution: float,
    first: float,
    last: float,
    step: float,
    slow: float,
) -> tuple[int, float, float, float, float]:
    """Advance a row from one sample to the next; returns mode (0 rides, +1 and -1 slide), u, z, and
    losses by friction and hits.
    """
    if mode == 0 and abs(first) <= band and abs(last) <= band:
        return 0, u, 0.0, 0.0, 0.0
    rate = (last - first) / step
    low = 0.0 if clearance < math.inf else -math.inf
    t, rubbed, struck = 0.0, 0.0, 0.0
    for _ in range(MOST_EVENTS):
        a = first + rate * t
        thrown = False
        if mode == 0:
            if a < -band and u < clearance:
                mode = 1
            elif a > band and u > low:
                mode = -1
            else:
                # The linear acceleration reaches the threshold within the interval: the row starts
                # to slide then.
                wait = math.inf
                if last < -band and a >= -band and u < clearance:
                    wait, mode = (-band - a) / rate, 1
                elif last > band and a <= band and u > low:
                    wait, mode = (band - a) / rate, -1
                if t + wait >= step:
                    return 0, u, 0.0, rubbed, struck
                t += wait
                thrown = True
        s = float(mode)
        left = step - t
        # Thrown exactly at the threshold: the net acceleration starts at zero, which round-off must
        # not turn negative.
        pull = 0.0 if thrown else -band - s * (first + rate * t)
        # Relative motion along s: constant friction -band, box acceleration -s (first + rate t).
        jerk = -s * rate
        speed = max(s * z, 0.0)
        stop = _stop(speed, pull, jerk, left)
        end = min(stop, left)
        gap = clearance - u if mode == 1 else u - low
        way = ((jerk / 6.0 * end + 0.5 * pull) * end + speed) * end
        if way >= gap and (speed > 0.0 or end > 0.0):
            end = _hit(gap, speed, pull, jerk, end)
            closing = max(speed + (pull + 0.5 * jerk * end) * end, 0.0)
            back = restitution * closing
            if back < slow:
                back = 0.0
            # Friction acts over the whole distance to the wall.
            rubbed += band * gap
            struck += 0.5 * (closing * closing - back * back)
            u = clearance if mode == 1 else 0.0
            t += end
            z = -s * back
            mode = -mode if back > 0.0 else 0
        elif stop <= left:
            rubbed += band * way
            u += s * way
            t += end
            mode, z = 0, 0.0
        else:
            rubbed += band * way
            return mode, u + s * way, s * (speed + (pull + 0.5 * jerk * end) * end), rubbed, struck
        if t >= step:
            return mode, u, z, rubbed, struck
    return 0, u, 0.0, rubbed, struck
