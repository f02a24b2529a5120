"""A single mass over many cycles: followed, in its steady state, on a sampling grid.

For one cycle see rig.kernels.single_mass.one_cycle.
"""

import math
from typing import NamedTuple

import numpy as np

from daq.compiled import njit
from rig.kernels.borrowed import borrowed
from rig.kernels.single_mass.one_cycle import (
    MAX_EVENTS,
    Events,
    State,
    World,
    cycle,
    no_events,
    world,
)
from rig.kernels.waveform import TWO_PI, Array, Ints

__all__ = [
    "MAX_EVENTS",
    "MassCycles",
    "MeanCycle",
    "State",
    "World",
    "follow",
    "no_events",
    "run",
    "steady",
    "world",
]

LOOK_BACK = 512
"""Longest period that is looked for, in cycles of the drive."""

SAME = 1e-12
"""Distance, as a fraction of the orbit's speed and height, below which two states are identical."""

MOST_IN_ALL = 10_000_000
"""Total number of events after which a mean is given up: some seconds."""

SETTLE, AVERAGE, BATCHES = 1024, 4096, 16
"""Cycles left out and averaged for an orbit without a period, and number of batches whose scatter
gives the standard error.
"""


class MassCycles(NamedTuple):
    """A mass over several cycles, one line per cycle.

    state : mode, q, u at its end, shape (cycles, 3)
    energy : work on the mass, friction, collision, and kinetic plus potential energy at its end,
        shape (cycles, 4)
    counts : events (-1: more than `MAX_EVENTS`, no valid lines after it), steps of root searches,
        hits of the upper wall, shape (cycles, 3)
    """

    state: Array
    energy: Array
    counts: Ints


def run(start: State, world: World, table: Array, P: Array, Q: Array, cycles: int) -> MassCycles:
    """Follow a mass from a start at phase 0 through whole cycles."""
    return MassCycles(*_run(*start, world, table, P, Q, no_events(), cycles))


@njit(cache=True, nogil=True)
def _run(
    mode: int,
    q: float,
    u: float,
    world: World,
    table: Array,
    P: Array,
    Q: Array,
    events: Events,
    cycles: int,
) -> tuple[Array, Array, Ints]:
    state, energy, count = (
        np.zeros((cycles, 3)),
        np.zeros((cycles, 4)),
        np.zeros((cycles, 3), np.int64),
    )
    harmonics = np.empty((2, P.shape[0]))
    table, P, Q, S, C = (
        borrowed(table),
        borrowed(P),
        borrowed(Q),
        borrowed(harmonics[0]),
        borrowed(harmonics[1]),
    )
    v = table[0, 2]
    for k in range(cycles):
        after = cycle(mode, q, u, world, table, P, Q, S, C, events)
        mode, q, u = after.mode, after.q, after.u
        state[k, 0], state[k, 1], state[k, 2] = mode, q, u
        energy[k, 0], energy[k, 1], energy[k, 2] = after.work, after.friction, after.collision
        energy[k, 3] = 0.5 * (v + u) ** 2 + world.weight * q
        count[k, 0], count[k, 1], count[k, 2] = after.events, after.roots, after.high
        if after.events < 0:
            break
    return state, energy, count


class MeanCycle(NamedTuple):
    """Mean cycle of a mass in its steady state.

    friction, collision : mean losses per cycle
    period : of its orbit in cycles, 0 if none was found, -1 if it exceeds `MAX_EVENTS` or
        `MOST_IN_ALL`
    lid : whether it hits the upper wall
    moves : whether it moves in the box at all
    error : standard error of the mean losses, 0 for an orbit with a period
    window : mean losses over the requested cycles
    """

    friction: float
    collision: float
    period: int
    lid: bool
    moves: bool
    error: float
    window: float


@njit(cache=True, nogil=True)
def _recurrence(history: Array, now: int, mode: int, q: float, u: float, walls: bool) -> int:
    """Return the smallest period in cycles after which the state at cycle `now` recurs, 0 for none
    yet.

    Lines of `history` are mode, q, u at the start of a cycle and the losses in it. Velocities are
    compared on the scale of the orbit, not of the state: a state may be close to rest in an orbit
    that is not.
    """
    length = history.shape[0]
    lost = 0.0
    for back in range(1, min(now, length) + 1):
        k = (now - back) % length
        lost += history[k, 3] + history[k, 4]
        if history[k, 0] != mode:
            continue
        # The losses give the scale: sqrt(2 W/m) is of the order of the impact speeds.
        speed = max(abs(u), math.sqrt(2.0 * lost / back))
        if abs(history[k, 2] - u) > SAME * speed:
            continue
        # Without walls the position has no meaning: only the velocity must recur.
        if not walls or abs(history[k, 1] - q) <= SAME * max(abs(q), speed):
            return back
    return 0


def steady(
    start: State,
    world: World,
    table: Array,
    P: Array,
    Q: Array,
    settle: int = SETTLE,
    average: int = AVERAGE,
    window: tuple[int, int] = (0, 0),
) -> MeanCycle:
    """Return the mean losses per cycle of a mass that starts at phase 0.

    The mean is over its period as soon as its state recurs within `LOOK_BACK` cycles; if it never
    does, over `average` cycles after the first `settle`. window : (first cycle, one past the last)
    of an additional mean.
    """
    return MeanCycle(*_steady(*start, world, table, P, Q, no_events(), settle, average, *window))


@njit(cache=True, nogil=True)
def _steady(
    mode: int,
    q: float,
    u: float,
    world: World,
    table: Array,
    P: Array,
    Q: Array,
    events: Events,
    settle: int,
    average: int,
    first: int,
    last: int,
) -> tuple[float, float, int, bool, bool, float, float]:
    harmonics = np.empty((2, P.shape[0]))
    table, P, Q, S, C = (
        borrowed(table),
        borrowed(P),
        borrowed(Q),
        borrowed(harmonics[0]),
        borrowed(harmonics[1]),
    )
    # Columns: mode, q, u at the start of the cycle; friction, collision, hits of the upper wall,
    # events in it.
    history = np.zeros((LOOK_BACK, 7))
    friction, collision, lid, moves, seen = 0.0, 0.0, False, False, 0.0
    wanted = max(last - first, 1)
    batches = np.zeros(BATCHES)
    walls = world.upper < np.inf or world.lower > -np.inf
    spent = 0
    for n in range(settle + average):
        back = _recurrence(history, n, mode, q, u, walls)
        if back > 0:
            lost = np.zeros(4)
            for b in range(1, back + 1):
                lost += history[(n - b) % LOOK_BACK, 3:] / back
            # The rest of the window lies in the periodic part: take it from the stored period.
            for m in range(max(n, first), last):
                line = history[(n - back + (m - n) % back) % LOOK_BACK]
                seen += line[3] + line[4]
            return (
                lost[0],
                lost[1],
                back,
                lost[2] > 0.0,
                mode != 0 or lost[3] > 0.0,
                0.0,
                seen / wanted,
            )
        after = cycle(mode, q, u, world, table, P, Q, S, C, events)
        spent += after.events
        if after.events < 0 or spent > MOST_IN_ALL:
            return friction, collision, -1, lid, True, 0.0, 0.0
        line = history[n % LOOK_BACK]
        line[0], line[1], line[2] = mode, q, u
        line[3], line[4], line[5], line[6] = (
            after.friction,
            after.collision,
            after.high,
            after.events,
        )
        mode, q, u = after.mode, after.q, after.u
        if first <= n < last:
            seen += after.friction + after.collision
        if n >= settle:
            friction += after.friction / average
            collision += after.collision / average
            lid = lid or after.high > 0
            moves = moves or mode != 0 or after.events > 0
            batches[(n - settle) * BATCHES // average] += (
                (after.friction + after.collision) * BATCHES / average
            )
    # Beyond the simulated cycles the mean is the best estimate.
    seen += max(last - max(settle + average, first), 0) * (friction + collision)
    # Batch means: the scatter of nearly independent parts gives the error of a correlated series.
    error = float(np.std(batches)) / math.sqrt(BATCHES - 1.0)
    return friction, collision, 0, lid, moves, error, seen / wanted


def follow(
    first_cycle: int,
    cycles: int,
    per_cycle: float,
    velocity: Array,
    scale: float,
    start: State,
    world: World,
    table: Array,
    P: Array,
    Q: Array,
    events: Events,
) -> tuple[Array, MassCycles]:
    """Advance a mass through cycles of a sampling grid. Returns its momentum, times `scale`, at the
    edges, and the cycles.

    Edge j lies at phase 2 pi j / per_cycle from the start of the motion.
    velocity : of the box at the edges, shape (edges,)
    """
    momentum, state, energy, counts = _follow(
        first_cycle, cycles, per_cycle, velocity, scale, *start, world, table, P, Q, events, *events
    )
    return momentum, MassCycles(state, energy, counts)


@njit(cache=True, nogil=True)
def _follow(
    first_cycle: int,
    cycles: int,
    per_cycle: float,
    velocity: Array,
    scale: float,
    mode: int,
    q: float,
    u: float,
    world: World,
    table: Array,
    P: Array,
    Q: Array,
    events: Events,
    phase: Array,
    modes: Ints,
    w: Array,
) -> tuple[Array, Array, Array, Ints]:
    state, energy, counts = (
        np.zeros((cycles, 3)),
        np.zeros((cycles, 4)),
        np.zeros((cycles, 3), np.int64),
    )
    harmonics = np.empty((2, P.shape[0]))
    table, P, Q, S, C = (
        borrowed(table),
        borrowed(P),
        borrowed(Q),
        borrowed(harmonics[0]),
        borrowed(harmonics[1]),
    )
    momentum = np.empty(velocity.shape[0])
    v = table[0, 2]
    origin = math.ceil(first_cycle * per_cycle)
    for k in range(cycles):
        before, since, speed = mode, 0.0, v + u
        after = cycle(mode, q, u, world, table, P, Q, S, C, events)
        mode, q, u = after.mode, after.q, after.u
        state[k, 0], state[k, 1], state[k, 2] = mode, q, u
        energy[k, 0], energy[k, 1], energy[k, 2] = after.work, after.friction, after.collision
        energy[k, 3] = 0.5 * (v + u) ** 2 + world.weight * q
        counts[k, 0], counts[k, 1], counts[k, 2] = after.events, after.roots, after.high
        if after.events < 0:
            break
        offset = (first_cycle + k) * per_cycle
        e, last = math.ceil(offset), math.ceil((first_cycle + k + 1) * per_cycle)
        for n in range(after.events + 1):
            end = (
                min(math.ceil(offset + phase[n] * per_cycle / TWO_PI), last)
                if n < after.events
                else last
            )
            # Between events the laboratory velocity changes uniformly by weight and friction.
            slope = -(world.weight + before * world.band)
            for j in range(e, end):
                now = TWO_PI * (j - offset) / per_cycle
                momentum[j - origin] = scale * (
                    velocity[j - origin] if before == 0 else speed + slope * (now - since)
                )
            e = max(e, end)
            if n < after.events:
                before, since, speed = modes[n], phase[n], w[n]
    return momentum, state, energy, counts
