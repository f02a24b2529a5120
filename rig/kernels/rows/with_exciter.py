"""Exciter, box and rows in steps: linear system exact, rows by one scalar equation, energies by
quadrature.

States and symbols as in `rig.drive.electrodynamic`. The forces on the box are constant within a
step, so its motion is exact at every edge of the grid. Energies are integrals over each interval by
the trapezoid with end correction (fourth order); none is computed as the remainder of the others.
"""

import math
from typing import NamedTuple

import numpy as np

from daq.compiled import njit
from rig.kernels.rows.coupled_step import WINDOW, Pull, carry, collide, end_velocity, next_walls
from rig.kernels.rows.sleeping import (
    FARTHEST,
    FORCE,
    LEAST_ROWS,
    SINCE,
    SLACK,
    SPAN,
    fall_asleep,
    population,
    sleep_again,
    stays,
    wake,
)
from rig.kernels.rows.tiles import CHUNK, from_tiles, to_tiles
from rig.kernels.waveform import Array

XA, VA, XB, VB, X, V, I = range(7)  # noqa: E741
STATES = 7

(
    GAUGE,
    ELECTRIC,
    COPPER,
    FLEXURE,
    STINGER,
    ISOLATION,
    COIL,
    SQUARE,
    AIR,
    GUIDE,
    FRICTION,
    COLLISION,
) = range(12)
MOST_VOLTAGE, MOST_CURRENT, MOST_TRAVEL, MOST_PULL, MOST_PUSH = range(12, 17)
ACCOUNTS = 17
"""Sums over a stretch: work through the gauge plane, from the amplifier, in copper, flexure,
stinger, isolation, through the coil; the integral of the box's v^2; work against air, guide,
friction and contacts of the rows.

Then largest values: voltage, current, travel of the coil, stinger tension and compression.
"""

MOMENTUM, SPEED, FLOW, PRESSURE, GAUGE_MASS, LIMITED = range(6)
SIGNALS = 6
"""Per interval: impulse of the stinger force on the box, velocity change of the box, integrals of
current and voltage, velocity change of the armature, and 1 if the amplifier is at a limit.

An impact at an edge counts half in the interval on either side; the last line is the part after the
end.
"""


TOUCH = 0.05
"""Displacement of a box of changing speed relative to that at its mean speed, as a fraction of the
largest possible: a row that sticks at a wall moves by less.
"""


class Machine(NamedTuple):
    """Coefficients of the linear system (`rig.drive.electrodynamic.Plant`), limits of the
    amplifier, interval of the grid (s).
    """

    force_constant: float
    resistance: float
    inductance: float
    flexure: float
    flexure_damping: float
    stinger: float
    stinger_damping: float
    isolation: float
    isolation_damping: float
    armature: float
    body: float
    box: float
    damping: float
    read_mass: float
    voltage_peak: float
    current_peak: float
    is_current: bool
    interval: float


class Feed(NamedTuple):
    """Drive of the coil: by current if `by_current`, else by voltage.

    limit : voltage or current at which the amplifier is saturated, nan while it follows its command
    """

    by_current: bool
    limit: float


@njit(cache=True, nogil=True, inline="always")
def _rates(y: Array, on: Machine, force: float) -> tuple[float, float, float]:
    """Return the accelerations of armature, body and box under an additional force on the box."""
    r, vr = y[XA] - y[XB], y[VA] - y[VB]
    flexure = on.flexure * r + on.flexure_damping * vr
    pull = on.stinger * (y[XA] - y[X]) + on.stinger_damping * (y[VA] - y[V])
    coil = on.force_constant * y[I]
    mount = on.isolation * y[XB] + on.isolation_damping * y[VB]
    return (
        (coil - flexure - pull) / on.armature,
        (flexure - coil - mount) / on.body,
        (pull + force - on.damping * y[V]) / on.box,
    )


@njit(cache=True, nogil=True, inline="always")
def _voltage(y: Array, i_rate: float, on: Machine) -> float:
    """Return the coil voltage for a current that changes at `i_rate`: e = R i + L i' + BL r'."""
    voltage: float = (
        on.resistance * y[I] + on.inductance * i_rate + on.force_constant * (y[VA] - y[VB])
    )
    return voltage


@njit(cache=True, nogil=True, inline="always")
def _add_powers(y: Array, weight: float, on: Machine, accounts: Array) -> None:
    """Add the powers of the mechanical accounts at one instant, times `weight`."""
    v, vs, vr = y[V], y[VA] - y[V], y[VA] - y[VB]
    accounts[GAUGE] += weight * (on.stinger * (y[XA] - y[X]) + on.stinger_damping * vs) * v
    accounts[FLEXURE] += weight * on.flexure_damping * vr * vr
    accounts[STINGER] += weight * on.stinger_damping * vs * vs
    accounts[ISOLATION] += weight * on.isolation_damping * y[VB] ** 2
    accounts[COIL] += weight * on.force_constant * y[I] * vr
    accounts[SQUARE] += weight * v * v


@njit(cache=True, nogil=True, inline="always")
def _add_rates(
    y: Array, force: float, i_rate: float, weight: float, on: Machine, accounts: Array
) -> None:
    """Add the rates of change of these powers, times `weight`; `i_rate` is that of the current, for
    the coil power.
    """
    aa, ab, a = _rates(y, on, force)
    v, vs, vr = y[V], y[VA] - y[V], y[VA] - y[VB]
    pull = on.stinger * (y[XA] - y[X]) + on.stinger_damping * vs
    pull_rate = on.stinger * vs + on.stinger_damping * (aa - a)
    accounts[GAUGE] += weight * (pull_rate * v + pull * a)
    accounts[FLEXURE] += weight * 2.0 * on.flexure_damping * vr * (aa - ab)
    accounts[STINGER] += weight * 2.0 * on.stinger_damping * vs * (aa - a)
    accounts[ISOLATION] += weight * 2.0 * on.isolation_damping * y[VB] * ab
    accounts[COIL] += weight * on.force_constant * (i_rate * vr + y[I] * (aa - ab))
    accounts[SQUARE] += weight * 2.0 * v * a


@njit(cache=True, nogil=True)
def _free(
    y: Array,
    steps: int,
    k0: int,
    feed: Feed,
    command: Array,
    phi: Array,
    now: Array,
    following: Array,
    on: Machine,
    path: Array,
) -> None:
    """Fill `path` with the states at the edges of a step without any force on the box."""
    kind = 1 if feed.by_current else 0
    stuck = not math.isnan(feed.limit)
    for s in range(STATES):
        path[0, s] = y[s]
    for k in range(steps):
        if feed.by_current:
            target = path[k, I] if stuck else command[k0 + k + 1]
            # The current ramps to its next value; the input of the propagator is its rate.
            u0, u1 = (target - path[k, I]) / on.interval, 0.0
        else:
            u0 = feed.limit if stuck else command[k0 + k]
            u1 = feed.limit if stuck else command[k0 + k + 1]
        for s in range(STATES):
            total = now[kind, s] * u0 + following[kind, s] * u1
            for c in range(STATES):
                total += phi[kind, s, c] * path[k, c]
            path[k + 1, s] = total


@njit(cache=True, nogil=True)
def _within(
    path: Array, steps: int, k0: int, feed: Feed, command: Array, on: Machine
) -> tuple[int, Feed]:
    """Return the edge of a step at which the amplifier reaches or leaves a limit (else `steps`),
    and its drive from there on.
    """
    stuck = not math.isnan(feed.limit)
    for k in range(1, steps + 1):
        y, i = path[k], path[k, I]
        if on.is_current:
            if not stuck:
                e = _voltage(y, (i - path[k - 1, I]) / on.interval, on)
                if abs(e) > on.voltage_peak:
                    return k, Feed(False, math.copysign(on.voltage_peak, e))
            # Voltage limit of a current amplifier: left once the current has caught up with the
            # command.
            elif (i - command[k0 + k]) * feed.limit >= 0.0:
                return k, Feed(True, math.nan)
        elif not stuck:
            # Current limit of a voltage amplifier: only a current that still grows is stopped.
            if abs(i) > on.current_peak and i * (i - path[k - 1, I]) > 0.0:
                return k, Feed(True, i)
        elif (command[k0 + k] - _voltage(y, 0.0, on)) * i < 0.0:
            return k, Feed(False, math.nan)
    return steps, feed


@njit(cache=True, nogil=True)
def _account(
    path: Array,
    stop: int,
    k0: int,
    force: float,
    feed: Feed,
    command: Array,
    on: Machine,
    accounts: Array,
) -> None:
    """Add the accounts of a step by the trapezoid rule with end correction, h^2/12 times the jump
    of the derivative.

    The corrections of neighbouring intervals cancel except for terms that jump at an edge: the rate
    of the current with a current drive, of the voltage with a voltage drive.
    """
    h, end = on.interval, path[stop]
    stuck = not math.isnan(feed.limit)
    for k in range(stop + 1):
        _add_powers(path[k], 0.5 * h if k == 0 or k == stop else h, on, accounts)
    start_rate, end_rate = 0.0, 0.0
    if not feed.by_current:
        e = feed.limit if stuck else command[k0]
        e_end = feed.limit if stuck else command[k0 + stop]
        start_rate = (e - _voltage(path[0], 0.0, on)) / on.inductance
        end_rate = (e_end - _voltage(end, 0.0, on)) / on.inductance
        accounts[ELECTRIC] += h * h / 12.0 * (e * start_rate - e_end * end_rate)
        # End correction of R i^2: its derivative is 2 R i i'.
        accounts[COPPER] += (
            h * h / 6.0 * on.resistance * (path[0, I] * start_rate - end[I] * end_rate)
        )
    _add_rates(path[0], force, start_rate, h * h / 12.0, on, accounts)
    _add_rates(end, force, end_rate, -h * h / 12.0, on, accounts)
    for k in range(stop):
        y, z = path[k], path[k + 1]
        i, i_end = y[I], z[I]
        if feed.by_current:
            rate = (i_end - i) / h
            vr, vr_end = y[VA] - y[VB], z[VA] - z[VB]
            # Exact: the current is linear within the interval.
            heat = on.resistance * h / 3.0 * (i * i + i * i_end + i_end * i_end)
            accounts[COPPER] += heat
            accounts[COIL] += h * h / 12.0 * on.force_constant * rate * (vr - vr_end)
            accounts[ELECTRIC] += heat + 0.5 * on.inductance * (i_end * i_end - i * i)
            accounts[ELECTRIC] += 0.5 * h * on.force_constant * (i * vr + i_end * vr_end)
            accounts[ELECTRIC] += h * h / 12.0 * on.force_constant * rate * (vr - vr_end)
            e_end = _voltage(z, rate, on)
        else:
            e = feed.limit if stuck else command[k0 + k]
            e_end = feed.limit if stuck else command[k0 + k + 1]
            accounts[COPPER] += 0.5 * h * on.resistance * (i * i + i_end * i_end)
            accounts[ELECTRIC] += 0.5 * h * (e * i + e_end * i_end) + h / 12.0 * (e_end - e) * (
                i - i_end
            )
        pull = on.stinger * (z[XA] - z[X]) + on.stinger_damping * (z[VA] - z[V])
        accounts[MOST_VOLTAGE] = max(accounts[MOST_VOLTAGE], abs(e_end))
        accounts[MOST_CURRENT] = max(accounts[MOST_CURRENT], abs(i_end))
        accounts[MOST_TRAVEL] = max(accounts[MOST_TRAVEL], abs(z[XA] - z[XB]))
        accounts[MOST_PULL] = max(accounts[MOST_PULL], -pull)
        accounts[MOST_PUSH] = max(accounts[MOST_PUSH], pull)
    if feed.by_current:
        aa, ab, _ = _rates(path[0], on, force)
        bb, cb, _ = _rates(end, on, force)
        # The part of the end correction of BL i r' that is continuous over the edges.
        swing = path[0, I] * (aa - ab) - end[I] * (bb - cb)
        accounts[ELECTRIC] += h * h / 12.0 * on.force_constant * swing


@njit(cache=True, nogil=True)
def _tell(
    path: Array,
    stop: int,
    k0: int,
    impulse: float,
    feed: Feed,
    command: Array,
    on: Machine,
    signals: Array,
) -> None:
    """Fill the signals of the intervals of a step; `impulse` is that of the box on everything but
    the stinger, per interval.
    """
    h = on.interval
    stuck = not math.isnan(feed.limit)
    for k in range(stop):
        y, z = path[k], path[k + 1]
        swing = on.force_constant * (z[XA] - z[XB] - y[XA] + y[XB])
        if feed.by_current:
            flow = 0.5 * h * (y[I] + z[I])
            pressure = on.resistance * flow + on.inductance * (z[I] - y[I]) + swing
        else:
            pressure = (
                h * feed.limit if stuck else 0.5 * h * (command[k0 + k] + command[k0 + k + 1])
            )
            # Integral of the voltage equation over the interval: exact, no quadrature of the
            # current.
            flow = (pressure - on.inductance * (z[I] - y[I]) - swing) / on.resistance
        signals[k0 + k, MOMENTUM] = on.box * (z[V] - y[V]) + on.damping * (z[X] - y[X]) + impulse
        signals[k0 + k, SPEED] += z[V] - y[V]
        signals[k0 + k, FLOW] = flow
        signals[k0 + k, PRESSURE] = pressure
        signals[k0 + k, GAUGE_MASS] = z[VA] - y[VA]
        signals[k0 + k, LIMITED] = 1.0 if stuck else 0.0


@njit(cache=True, nogil=True)
def _foreseen(path: Array, steps: int, force: float, thrust: Array, moved: Array) -> float:
    """Predict the displacement of the box at the edges under a force, m, into `moved`. Returns
    `TOUCH` times its change of speed, m/s.
    """
    least, most = path[0, V], path[0, V]
    for k in range(steps + 1):
        moved[k] = path[k, X] - path[0, X] + force * thrust[k, X]
        speed = path[k, V] + force * thrust[k, V]
        least, most = min(least, speed), max(most, speed)
    share: float = TOUCH * (most - least)
    return share


@njit(cache=True, nogil=True)
def stretch(
    on: Machine,
    around: Pull,
    feed: Feed,
    phi: Array,
    now: Array,
    following: Array,
    thrust: Array,
    command: Array,
    y: Array,
    w: Array,
    u: Array,
    lo: Array,
    hi: Array,
    band: Array,
    clearance: Array,
) -> tuple[Feed, Array, Array]:
    """Advance exciter, box (`y`) and rows (`w`, `u`, `lo`, `hi`), in place, along the edges of a
    command.

    Returns (drive of the amplifier at the end; signals, shape (intervals + 1, SIGNALS); accounts).
    """
    longest, intervals, many, h = (
        thrust.shape[1] - 1,
        command.shape[0] - 1,
        np.uint64(w.shape[0]),
        on.interval,
    )
    path, moved = np.empty((longest + 1, STATES)), np.empty(longest + 1)
    signals, accounts = np.zeros((intervals + 1, SIGNALS)), np.zeros(ACCOUNTS)
    grouped, lanes, who = (
        population(to_tiles(w, u, lo, hi, band, clearance), many),
        np.empty((3, CHUNK)),
        np.empty(many, np.int64),
    )
    tiles, sleep, tally = (
        grouped.awake,
        grouped.sleep,
        np.ones((2, many // CHUNK + np.uint64(1)), np.int64),
    )
    ahead = SPAN * longest * h if many >= LEAST_ROWS else math.inf
    rows = fall_asleep(y[X], y[V], ahead, around.pull, many, grouped)
    k0, force, per_time = 0, 0.0, 1.0
    while k0 < intervals:
        if sleep[SINCE] + longest * h > ahead * (1.0 + 1e-9) or sleep[FARTHEST] > sleep[SLACK]:
            rows, heat = sleep_again(
                y[X], y[V], 1.0 / per_time, ahead, around.pull, many, rows, grouped
            )
            accounts[FRICTION] += around.row_mass * heat
            tally[:] = 1
        steps, kind = min(longest, intervals - k0), 1 if feed.by_current else 0
        _free(y, steps, k0, feed, command, phi, now, following, on, path)
        # Predict with the force of the previous step: it only selects the rows that may hit, not
        # their motion.
        depth = _foreseen(path, steps, force, thrust[kind], moved) * steps * h
        count, first = next_walls(
            h, steps, around.pull, per_time, moved, depth, tiles, rows, who, lanes[0]
        )
        if count:
            steps = min(int(first) + WINDOW, steps)
        time, steady = steps * h, around.row_mass * sleep[FORCE]
        start, free, gain = y[V], path[steps, V], thrust[kind, steps, V] / time
        guess = free + gain * time * force
        end, given, air, guide = end_velocity(
            guess, start, free, gain, time, around, tiles, rows, steady, tally, lanes[0]
        )
        force, per_time = -given / time, 1.0 / time
        for k in range(1, steps + 1):
            for s in range(STATES):
                path[k, s] += force * thrust[kind, k, s]
        stop, after = _within(path, steps, k0, feed, command, on)
        # The box left the bound under which rows sleep: nothing is committed; the loop wakes them
        # and repeats the step.
        if not stays(path[: stop + 1, V], sleep) and rows < many:
            continue
        sleep[SINCE] += stop * h
        way = path[stop, X] - y[X]
        accounts[AIR] += air / time * way
        accounts[GUIDE] += guide / time * way
        rub, push = carry(
            (end - start) / time - around.pull, start, time, stop * h, way, around, tiles, rows,
            tally, lanes, stop == steps and 2 * steps > longest,
        )  # fmt: skip
        accounts[FRICTION] += rub - push
        accounts[COLLISION] += push
        _account(path, stop, k0, force, feed, command, on, accounts)
        _tell(path, stop, k0, -force * h, feed, command, on, signals)
        for s in range(STATES):
            y[s] = path[stop, s]
        if count:
            slow = abs(path[stop, V] - path[stop - 1, V]) + abs(around.pull) * h
            behind, lost = collide(y[V], h, slow, around, count, who, tiles, tally)
            # An impact at an edge belongs half to each neighbouring interval.
            signals[k0 + stop - 1, SPEED] += 0.5 * (behind - y[V])
            signals[k0 + stop, SPEED] += 0.5 * (behind - y[V])
            accounts[COLLISION] += lost
            y[V] = behind
        k0, feed = k0 + stop, after
    accounts[FRICTION] += around.row_mass * wake(
        y[X], 1.0 / per_time, around.pull, many, rows, grouped
    )
    from_tiles(grouped.all_rows, w, u, lo, hi)
    return feed, signals, accounts
