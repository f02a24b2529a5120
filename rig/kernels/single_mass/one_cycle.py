"""One mass in a free gap of a box in programmed motion, event by event: walls, weight along the axis, or a rough floor.

The mass is one, lengths and times are those of the waveform. q is its position in the box, u = q' its velocity
against the box. Walls at `lower` and `upper` (infinite where there is none) give back `restitution` of a closing speed;
`weight` pulls towards the lower one; `band` is Coulomb friction against the box. Between events the motion is closed
form (rig.kernels.single_mass.flight), event phases are bracketed roots: between two phases at which the relative
acceleration changes its sign, the velocity is monotonic, so that no passage through a wall can be missed.

Bouncing that dies out on a wall (Zeno) is ended once what that leaves out is proven negligible, see `_dies_out`.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from rig.kernels.single_mass.flight import at, drift, reach, turn
from rig.kernels.waveform import TWO_PI, Array, Ints, crossings, extrema, motion

MAX_EVENTS = 65536
"""Events in one cycle; a slug that needs more (elastic with a tiny gap or a tiny bounce) is refused."""

NEGLIGIBLE = 1e-13
"""Share of the energy of a series of bounces that its end may leave out."""

GRAZING = 1e-14
"""A slug that turns back so little behind a wall, of the way it came, turns back in front of it: round-off."""

STEADY = 1e-3
"""Largest relative change of the push on a wall while a series of bounces dies out."""

LONG = 0.5
"""Flight, rad, from which on the displacement, t^3/6 or more, may be the difference of two positions."""

PASS, STOP, LOW, HIGH = 0, 1, 2, 3
"""How a piece of a stretch ends: nothing happens, at rest in the box, at the lower wall, at the upper wall."""


class World(NamedTuple):
    """What the slug lives in, units of the waveform. jerk : the fastest that the box's acceleration can change."""

    weight: float
    band: float
    lower: float
    upper: float
    restitution: float
    jerk: float


class State(NamedTuple):
    """mode : 0 rests in the box, 1 moves, +1 and -1 slides towards that side of a rough floor."""

    mode: int
    q: float
    u: float


class Events(NamedTuple):
    """What starts at each event: phase, mode, velocity in the laboratory, each of shape (MAX_EVENTS,)."""

    phase: Array
    mode: Ints
    w: Array


class Cycle(NamedTuple):
    """A slug at the end of a cycle and what happened in it.

    events : their number, -1 for more than `MAX_EVENTS`; roots : steps of root searches; high : hits of the upper wall
    work : of the box on the slug; friction, collision : losses
    """

    mode: int
    q: float
    u: float
    events: int
    roots: int
    high: int
    work: float
    friction: float
    collision: float


def no_events() -> Events:
    """Room for the events of one cycle."""
    return Events(np.empty(MAX_EVENTS), np.empty(MAX_EVENTS, np.int64), np.empty(MAX_EVENTS))


def world(
    weight: float, band: float, lower: float, upper: float, restitution: float, P: Array, Q: Array
) -> tuple[World, Array]:
    """A slug's world on a waveform, and its table: lines of phase, box position, box velocity and region behind.

    region : -1 where a free slug is pushed up against the box, +1 where it is pushed down, 0 where friction holds it
    The first line is phase 0, the last 2 pi, the others are where the region changes. It is told between two lines, not
    from the crossings: where a level is just reached two of them are one, in either order.
    """
    if weight and band:
        raise ValueError("weight along the axis and friction of a floor do not go together")
    harmonics = np.arange(1, P.size + 1)
    jerk = float(np.sum(harmonics * np.hypot(P, Q)))
    lines = crossings(np.array([weight or band]), P, Q, extrema(P, Q)).tables[0]
    lines = lines[np.diff(lines[:, 0], append=np.inf) > 0.0]
    between = 0.5 * (lines[:-1, 0] + lines[1:, 0])
    push = -np.array([motion(phase, P, Q)[2] for phase in between])
    region = np.where(push > (weight or band), -1, np.where(push < (weight if band == 0.0 else -band), 1, 0))
    lines[:, 3] = np.append(region, region[-1])
    kept = np.append(np.append(True, region[1:] != region[:-1]), True)
    return World(weight, band, lower, upper, restitution, jerk), lines[kept]


@njit(cache=True, nogil=True, inline="always")
def _thrown(region: int, q: float, world: World) -> int:
    """Direction in which a slug at rest is pushed off, where there is room; 0 for none."""
    if region == -1 and q < world.upper:
        return 1
    if region == 1 and q > world.lower:
        return -1 if world.band > 0.0 else 1
    return 0


@njit(cache=True, nogil=True, inline="always")
def _dies_out(back: float, largest: float, push: float, world: World) -> bool:
    """Whether a slug that leaves a wall at speed `back` under the push g may as well stay there.

    With constant g it would bounce for T = 2 back/(g (1 - r)) and lose back^2/2, which is what staying counts; from
    hit to hit its speed falls by r = e sqrt(g/(g + 2 band)), as friction brakes it on the way out and back. The
    push changes by J T at most, J the jerk: as a share, by s = J T/g. For s << 1 it comes to rest before it is thrown
    again, so that its later motion is the same, and its loss is back^2/2 + integral g' q dt, with q <= back^2/(2 g):
    off by at most s back^2/2 (1 + O(s)). `largest` is the fastest hit of the series, which lost (1 - r^2) largest^2/2.
    On a rough floor friction takes its part of back^2/2, so that this has to be negligible as a whole.
    """
    if push <= 0.0:
        return False
    ratio = world.restitution * math.sqrt(push / (push + 2.0 * world.band))
    if ratio >= 1.0:
        return False
    share = 2.0 * world.jerk * back / (push * push * (1.0 - ratio))
    least = NEGLIGIBLE * (1.0 - ratio * ratio) * largest * largest
    return share < STEADY and (share if world.band == 0.0 else 1.0) * back * back < least


@njit(cache=True, nogil=True, inline="always")
def _next(
    t1: float, d1: float, u1: float, t2: float, d2: float, u2: float, rises: bool, low: float, high: float,
    mode: int, rough: bool, u0: float, a0: float, S: Array, C: Array,
) -> tuple[int, float, float, float, float, int]:  # fmt: skip
    """First event of the piece (t1, t2] of a stretch: kind, time, displacement, velocity and acceleration against the
    box, and the steps of root searches.

    The relative velocity rises (or falls) throughout the piece. low, high : displacements at which the walls stand
    """
    sense = 1.0 if rises else -1.0
    if rough and sense * mode < 0.0 and sense * u1 >= 0.0:
        return STOP, t1, d1, 0.0, 0.0, 0  # thrown for less than round-off: friction would drive it the other way
    before, ahead = (low, high) if rises else (high, low)
    roots = 0
    if sense * u1 < 0.0:
        end, hits = t2, sense * (d2 - before) <= 0.0
        if sense * u2 > 0.0:
            hits = False
            if rough or sense * (d1 + u1 * (t2 - t1) - before) <= 0.0:
                end, d, roots = turn(t1, u1, t2, u2, u0, a0, S, C)
                hits = sense * (d - before) < -GRAZING * max(abs(d), 1.0)
                if rough and not hits:
                    return STOP, end, d, 0.0, 0.0, roots
        if hits:
            t, u, a, steps = reach(t1, end, end, before, -sense, u0, a0, S, C)
            return LOW if rises else HIGH, t, before, u, a, roots + steps
    if sense * u2 > 0.0 and sense * (d2 - ahead) >= 0.0:
        guess = t2
        if u0 == 0.0:
            guess = t2 * np.cbrt(ahead / d2) if t1 == 0.0 else min(2.0 * t1, t2)
        elif t1 == 0.0 and ahead == 0.0 and u0 * a0 < 0.0:
            guess = min(-2.0 * u0 / a0, t2)
        t, u, a, steps = reach(t1, t2, guess, ahead, sense, u0, a0, S, C)
        return HIGH if rises else LOW, t, ahead, u, a, roots + steps
    return PASS, t2, d2, u2, 0.0, roots


@njit(cache=True, nogil=True)
def cycle(
    mode: int, q: float, u: float, world: World, table: Array, P: Array, Q: Array, S: Array, C: Array, events: Events
) -> Cycle:
    """Advance a slug by one cycle of the drive; its events go to `events`. S, C : room for the harmonics.

    One function on purpose: the state of a stretch in a record of its own costs a third more.
    """
    event_phase, event_mode, event_w = events
    theta, x, v, region, line = 0.0, table[0, 1], table[0, 2], int(table[0, 3]), 1
    last = table.shape[0] - 1
    weight, band = world.weight, world.band
    n, roots, high = 0, 0, 0
    work, friction, collision, largest = 0.0, 0.0, 0.0, 0.0
    a0 = 0.0
    if mode != 0:
        a0 = -at(0.0, P, Q, S, C)[2] - weight - mode * band
    while True:
        if mode == 0:
            start_x, start_v = x, v
            mode = _thrown(region, q, world)
            a0 = -at(theta, P, Q, S, C)[2] - weight - mode * band if mode != 0 else 0.0
            while mode == 0 and theta < TWO_PI:
                theta, x, v, region = table[line, 0], table[line, 1], table[line, 2], int(table[line, 3])
                if line < last:
                    line += 1
                    mode = _thrown(region, q, world)
                    if mode != 0:
                        at(theta, P, Q, S, C)
            work += 0.5 * (v * v - start_v * start_v) + weight * (x - start_x)
            if mode == 0:
                return Cycle(0, q, 0.0, n, roots, high, work, friction, collision)
            u, largest = 0.0, 0.0
            if n >= MAX_EVENTS:
                return Cycle(mode, q, u, -1, roots, high, work, friction, collision)
            event_phase[n], event_mode[n], event_w[n] = theta, mode, v
            n += 1
        start, start_x, low, top = theta, x, world.lower - q, world.upper - q
        t1, d1, u1 = 0.0, 0.0, u
        pull = weight + mode * band
        while True:
            t2 = table[line, 0] - start
            if t2 > LONG:
                d2 = (v + u - 0.5 * pull * t2) * t2 - (table[line, 1] - x)
                u2 = v + u - pull * t2 - table[line, 2]
            else:
                d2, u2, _, _, _, _, _, _ = drift(t2, u, a0, S, C)
            rises = region == -1 or (region == 0 and mode == -1)
            kind, t, d, slip, rate, steps = _next(
                t1, d1, u1, t2, d2, u2, rises, low, top, mode, band > 0.0, u, a0, S, C
            )
            roots += steps
            if kind != PASS or line == last:
                break
            t1, d1, u1, region = t2, d2, u2, int(table[line, 3])
            line += 1
        if band > 0.0:
            friction += band * abs(d)
        if kind == PASS:
            q, u = min(max(q + d, world.lower), world.upper), slip
            work -= mode * band * (table[last, 1] - start_x)
            return Cycle(mode, q, u, n, roots, high, work, friction, collision)
        theta = min(start + t, table[line, 0])
        x, v = x + (v + u - 0.5 * pull * t) * t - d, v + u - pull * t - slip
        q, u, slid = min(max(q + d, world.lower), world.upper), 0.0, mode * band  # not behind a wall by round-off
        closing, back, sense = 0.0, 0.0, 0.0
        if kind != STOP:
            sense = 1.0 if kind == HIGH else -1.0
            q = world.upper if kind == HIGH else world.lower
            high += kind == HIGH
            closing = max(sense * slip, 0.0)
            back = world.restitution * closing
            largest = max(largest, closing)
            if _dies_out(back, largest, sense * (rate + slid) - band, world):
                back = 0.0
            collision += 0.5 * (closing * closing - back * back)
            u = -sense * back
        mode = _thrown(region, q, world) if u == 0.0 else -1 if band > 0.0 and u < 0.0 else 1
        if mode != 0:
            x, v, a = at(theta, P, Q, S, C)
            a0 = -a - weight - mode * band
        work -= slid * (x - start_x) + sense * (closing + back) * v
        if n >= MAX_EVENTS:
            return Cycle(mode, q, u, -1, roots, high, work, friction, collision)
        event_phase[n], event_mode[n], event_w[n] = theta, mode, v + u
        n += 1
