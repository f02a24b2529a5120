"""A single mass in a free gap of a box in prescribed motion, event by event: walls, weight along
the axis, or a rough floor.

The mass is 1; lengths and times are those of the waveform. q is its position in the box, u = q' its
velocity relative to the box, w its velocity in the laboratory frame. Walls at `lower` and `upper`
(infinite if there is none) return the fraction `restitution` of a closing speed; `weight` pulls
towards the lower one; `band` is Coulomb friction against the box. Between events the motion is
closed form (rig.kernels.single_mass.flight), event phases are bracketed roots: between two phases
at which the relative acceleration changes sign, the velocity is monotonic, so that no passage
through a wall can be missed.

A series of bounces that dies out on a wall (Zeno) is ended once the remainder is proven negligible,
see `_dies_out`.
"""

import math
from typing import NamedTuple

import numpy as np

from daq.compiled import njit
from rig.kernels.single_mass.flight import at, drift, reach, turn
from rig.kernels.waveform import TWO_PI, Array, Ints, crossings, extrema, motion

MAX_EVENTS = 65536
"""Events in one cycle; a mass with more (elastic with a tiny gap or a tiny bounce) is rejected."""

NEGLIGIBLE = 1e-13
"""Fraction of the energy of a series of bounces that may be neglected at its end."""

GRAZING = 1e-14
"""Depth behind a wall, as a fraction of the distance travelled, up to which a turning point counts
as in front of it: round-off.
"""

STEADY = 1e-3
"""Largest relative change of the push on a wall while a series of bounces dies out."""

LONG = 0.5
"""Flight time, rad, from which the displacement, t^3/6 or more, may be computed as the difference
of two positions.
"""

PASS, STOP, LOW, HIGH = 0, 1, 2, 3
"""Ends of a piece of a stretch: no event, at rest in the box, at the lower wall, at the
upper wall.
"""


class World(NamedTuple):
    """Surroundings of the mass, units of the waveform.

    weight : acceleration towards the lower wall; band : friction of the floor
    lower, upper : positions of the walls; restitution : of both
    jerk : upper bound of the rate of change of the box acceleration
    """

    weight: float
    band: float
    lower: float
    upper: float
    restitution: float
    jerk: float


class State(NamedTuple):
    """State of the mass: position q and velocity u relative to the box.

    mode : 0 at rest in the box, 1 moving, +1 and -1 sliding in that direction on a rough floor
    """

    mode: int
    q: float
    u: float


class Events(NamedTuple):
    """The new state at each event: phase, mode, velocity in the laboratory frame, each of shape
    (MAX_EVENTS,).
    """

    phase: Array
    mode: Ints
    w: Array


class MassCycle(NamedTuple):
    """State of a mass at the end of a cycle, and the events and energies of the cycle.

    events : their number, -1 for more than `MAX_EVENTS`
    roots : steps of root searches
    high : hits of the upper wall
    work : of the box on the mass; friction, collision : losses
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
    """Return room for the events of one cycle."""
    return Events(np.empty(MAX_EVENTS), np.empty(MAX_EVENTS, np.int64), np.empty(MAX_EVENTS))


def world(
    weight: float, band: float, lower: float, upper: float, restitution: float, P: Array, Q: Array
) -> tuple[World, Array]:
    """Return the surroundings of a mass on a waveform, and its table: lines of phase, box position,
    box velocity and region after the phase.

    region : -1 where a free mass is pushed up relative to the box, +1 where it is pushed down, 0
        where friction holds it

    The first line is phase 0, the last 2 pi, the others are the changes of region. The region is
    determined midway between two lines, not from the crossings: where a level is just reached, two
    of them coincide in either order.
    """
    if weight and band:
        raise ValueError("weight along the axis and friction of a floor do not go together")
    harmonics = np.arange(1, P.size + 1)
    jerk = float(np.sum(harmonics * np.hypot(P, Q)))
    lines = crossings(np.array([weight or band]), P, Q, extrema(P, Q)).tables[0]
    lines = lines[np.diff(lines[:, 0], append=np.inf) > 0.0]
    between = 0.5 * (lines[:-1, 0] + lines[1:, 0])
    push = -np.array([motion(phase, P, Q)[2] for phase in between])
    up, down = (weight, weight) if band == 0.0 else (band, -band)
    region = np.where(push > up, -1, np.where(push < down, 1, 0))
    lines[:, 3] = np.append(region, region[-1])
    kept = np.append(np.append(True, region[1:] != region[:-1]), True)
    return World(weight, band, lower, upper, restitution, jerk), lines[kept]


@njit(cache=True, nogil=True, inline="always")
def _thrown(region: int, q: float, world: World) -> int:
    """Return the direction in which a mass at rest starts to move, if there is room; 0 for none."""
    if region == -1 and q < world.upper:
        return 1
    if region == 1 and q > world.lower:
        return -1 if world.band > 0.0 else 1
    return 0


@njit(cache=True, nogil=True, inline="always")
def _dies_out(back: float, largest: float, push: float, world: World) -> bool:
    """Return whether a mass that leaves a wall at speed `back` under the push g may as well stay
    there.

    With constant g it would bounce for T = 2 back/(g (1 - r)) and lose back^2/2, which is what
    staying counts. From hit to hit its speed falls by r = e sqrt(g/(g + 2 band)), because friction
    brakes it on the way out and back. The push changes by at most J T, J the jerk, a relative
    change of s = J T/g. For s << 1 the mass comes to rest before it is thrown again, so that its
    later motion is the same, and its loss is back^2/2 + integral g' q dt, with q <= back^2/(2 g):
    an error of at most s back^2/2 (1 + O(s)). `largest` is the fastest hit of the series, which
    lost (1 - r^2) largest^2/2. On a rough floor friction takes part of back^2/2, so the whole of it
    has to be negligible.
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
    t1: float,
    d1: float,
    u1: float,
    t2: float,
    d2: float,
    u2: float,
    rises: bool,
    low: float,
    high: float,
    mode: int,
    rough: bool,
    u0: float,
    a0: float,
    S: Array,
    C: Array,
) -> tuple[int, float, float, float, float, int]:
    """Find the first event of the piece (t1, t2] of a stretch.

    low, high : displacements at which the walls stand. The relative velocity rises (`rises`) or
        falls throughout the piece.

    Returns (kind; time; displacement, velocity, acceleration relative to the box; steps of root
    searches).
    """
    sense = 1.0 if rises else -1.0
    if rough and sense * mode < 0.0 and sense * u1 >= 0.0:
        return (
            STOP,
            t1,
            d1,
            0.0,
            0.0,
            0,
        )  # thrown for less than round-off: friction would drive it the other way
    before, ahead = (low, high) if rises else (high, low)
    roots = 0
    # The mass first moves against the sense of the acceleration: it may hit the wall behind, or
    # turn back.
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
    # Then it moves with it: it may hit the wall ahead, once.
    if sense * u2 > 0.0 and sense * (d2 - ahead) >= 0.0:
        guess = t2
        if u0 == 0.0:
            # From rest at a take-off the displacement grows like t^3; from a bounce, like u0 t + a0
            # t^2/2.
            guess = t2 * np.cbrt(ahead / d2) if t1 == 0.0 else min(2.0 * t1, t2)
        elif t1 == 0.0 and ahead == 0.0 and u0 * a0 < 0.0:
            guess = min(-2.0 * u0 / a0, t2)
        t, u, a, steps = reach(t1, t2, guess, ahead, sense, u0, a0, S, C)
        return HIGH if rises else LOW, t, ahead, u, a, roots + steps
    return PASS, t2, d2, u2, 0.0, roots


@njit(cache=True, nogil=True)
def cycle(
    mode: int,
    q: float,
    u: float,
    world: World,
    table: Array,
    P: Array,
    Q: Array,
    S: Array,
    C: Array,
    events: Events,
) -> MassCycle:
    """Advance a mass by one cycle of the drive; its events are written to `events`. S, C : work
    space for the harmonics.

    One function on purpose: passing the state of a stretch as a record would take a third longer.
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
                theta, x, v, region = (
                    table[line, 0],
                    table[line, 1],
                    table[line, 2],
                    int(table[line, 3]),
                )
                if line < last:
                    line += 1
                    mode = _thrown(region, q, world)
                    if mode != 0:
                        at(theta, P, Q, S, C)
            # At rest in the box the work is the change of kinetic and potential energy.
            work += 0.5 * (v * v - start_v * start_v) + weight * (x - start_x)
            if mode == 0:
                return MassCycle(0, q, 0.0, n, roots, high, work, friction, collision)
            u, largest = 0.0, 0.0
            # No room for another event: the caller gets -1.
            if n >= MAX_EVENTS:
                return MassCycle(mode, q, u, -1, roots, high, work, friction, collision)
            event_phase[n], event_mode[n], event_w[n] = theta, mode, v
            n += 1
        start, start_x, low, top = theta, x, world.lower - q, world.upper - q
        t1, d1, u1 = 0.0, 0.0, u
        pull = weight + mode * band
        while True:
            t2 = table[line, 0] - start
            # Short flights by series, long ones by positions in the laboratory frame (cheaper).
            if t2 > LONG:
                d2 = (v + u - 0.5 * pull * t2) * t2 - (table[line, 1] - x)
                u2 = v + u - pull * t2 - table[line, 2]
            else:
                d2, u2, _, _, _, _, _, _ = drift(t2, u, a0, S, C)
            # Sign of the relative acceleration within the piece; in the band friction decides it.
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
            return MassCycle(mode, q, u, n, roots, high, work, friction, collision)
        theta = min(start + t, table[line, 0])
        x, v = x + (v + u - 0.5 * pull * t) * t - d, v + u - pull * t - slip
        q, u, slid = (
            min(max(q + d, world.lower), world.upper),
            0.0,
            mode * band,
        )  # not behind a wall by round-off
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
        moving = -1 if band > 0.0 and u < 0.0 else 1
        mode = _thrown(region, q, world) if u == 0.0 else moving
        if mode != 0:
            x, v, a = at(theta, P, Q, S, C)
            a0 = -a - weight - mode * band
        # Impulse of the wall times the velocity of the box, plus friction times the displacement of
        # the box.
        work -= slid * (x - start_x) + sense * (closing + back) * v
        if n >= MAX_EVENTS:
            return MassCycle(mode, q, u, -1, roots, high, work, friction, collision)
        event_phase[n], event_mode[n], event_w[n] = theta, mode, v + u
        n += 1
