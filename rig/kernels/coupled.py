"""Exciter, box and rows in steps: the linear system exactly, the rows by one scalar equation, energy by quadrature.

States and symbols as in `rig.drive.electrodynamic`. Inside a step the forces on the box are constant, so its motion at
every edge of the grid is exact. Energies are integrals over each interval by the trapezoid with its end correction, of
fourth order; none of them is found as what is left over.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from rig.kernels.two_way import WINDOW, Pull, carry, collide, end_velocity, next_walls
from rig.kernels.waveform import Array

XA, VA, XB, VB, X, V, I = range(7)  # noqa: E741
STATES = 7

GAUGE, ELECTRIC, COPPER, FLEXURE, STINGER, ISOLATION, COIL, SQUARE, AIR, GUIDE, FRICTION, COLLISION = range(12)
MOST_VOLTAGE, MOST_CURRENT, MOST_TRAVEL, MOST_PULL, MOST_PUSH = range(12, 17)
ACCOUNTS = 17
"""What a stretch adds up: works through the gauge plane, out of the amplifier, in copper, flexure, stinger, isolation,
through the coil; the integral of the box's v^2; works against air, guide, friction and contacts of the rows.
Then largest values: voltage, current, travel of the coil, stinger tension and compression."""

MOMENTUM, SPEED, FLOW, PRESSURE, GAUGE_MASS, LIMITED = range(6)
SIGNALS = 6
"""Per interval: impulse of the stinger's force on the box, change of the box's velocity, integrals of current and
voltage, change of the armature's velocity, and 1 where the amplifier is at a limit. An impact at an edge counts half
in the intervals on either side; the last line is what falls behind the end."""


TOUCH = 0.05
"""Share of the way that a box of changing speed moves beside its mean: a row that it holds at a wall wobbles less."""


class Machine(NamedTuple):
    """The linear system's numbers (`rig.drive.electrodynamic.Plant`), the amplifier's limits, the grid's interval."""

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
    """How the amplifier drives the coil: `by_current`, else by voltage; `limit` is the voltage or the current that it
    is stuck at, nan where it follows its command."""

    by_current: bool
    limit: float


@njit(cache=True, nogil=True, inline="always")
def _rates(y: Array, on: Machine, force: float) -> tuple[float, float, float]:
    """Accelerations of armature, body and box under a force on the box."""
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
    """Voltage that keeps a current going."""
    voltage: float = on.resistance * y[I] + on.inductance * i_rate + on.force_constant * (y[VA] - y[VB])
    return voltage


@njit(cache=True, nogil=True)
def _powers(y: Array, force: float, e: float, e_rate: float, i_rate: float, on: Machine, q: Array, dq: Array) -> None:
    """The powers of accounts GAUGE to SQUARE at one instant, in `q`, and their rates of change, in `dq`."""
    aa, ab, a = _rates(y, on, force)
    i, v = y[I], y[V]
    vr, ar = y[VA] - y[VB], aa - ab
    vs, as_ = y[VA] - v, aa - a
    pull = on.stinger * (y[XA] - y[X]) + on.stinger_damping * vs
    pull_rate = on.stinger * vs + on.stinger_damping * as_
    q[GAUGE], dq[GAUGE] = pull * v, pull_rate * v + pull * a
    q[ELECTRIC], dq[ELECTRIC] = e * i, e_rate * i + e * i_rate
    q[COPPER], dq[COPPER] = on.resistance * i * i, 2.0 * on.resistance * i * i_rate
    q[FLEXURE], dq[FLEXURE] = on.flexure_damping * vr * vr, 2.0 * on.flexure_damping * vr * ar
    q[STINGER], dq[STINGER] = on.stinger_damping * vs * vs, 2.0 * on.stinger_damping * vs * as_
    q[ISOLATION], dq[ISOLATION] = on.isolation_damping * y[VB] ** 2, 2.0 * on.isolation_damping * y[VB] * ab
    q[COIL], dq[COIL] = on.force_constant * i * vr, on.force_constant * (i_rate * vr + i * ar)
    q[SQUARE], dq[SQUARE] = v * v, 2.0 * v * a


@njit(cache=True, nogil=True)
def _free(
    y: Array, steps: int, k0: int, feed: Feed, command: Array, phi: Array, now: Array, following: Array, on: Machine,
    path: Array,
) -> None:  # fmt: skip
    """States at the edges of a step without any force on the box, in `path`."""
    kind = 1 if feed.by_current else 0
    stuck = not math.isnan(feed.limit)
    for s in range(STATES):
        path[0, s] = y[s]
    for k in range(steps):
        if feed.by_current:
            target = path[k, I] if stuck else command[k0 + k + 1]
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
def _within(path: Array, steps: int, k0: int, feed: Feed, command: Array, on: Machine) -> tuple[int, Feed]:
    """Edge of a step at which the amplifier meets a limit or leaves it (else `steps`), and how it drives from there."""
    stuck = not math.isnan(feed.limit)
    for k in range(1, steps + 1):
        y, i = path[k], path[k, I]
        if on.is_current:
            if not stuck:
                e = _voltage(y, (i - path[k - 1, I]) / on.interval, on)
                if abs(e) > on.voltage_peak:
                    return k, Feed(False, math.copysign(on.voltage_peak, e))
            elif (i - command[k0 + k]) * feed.limit >= 0.0:
                return k, Feed(True, math.nan)
        elif not stuck:
            if abs(i) > on.current_peak and i * (i - path[k - 1, I]) > 0.0:
                return k, Feed(True, i)
        elif (command[k0 + k] - _voltage(y, 0.0, on)) * i < 0.0:
            return k, Feed(False, math.nan)
    return steps, feed


@njit(cache=True, nogil=True)
def _account(
    path: Array, stop: int, k0: int, force: float, impulse: float, feed: Feed, command: Array, on: Machine,
    signals: Array, accounts: Array, q: Array, dq: Array,
) -> None:  # fmt: skip
    """Signals and accounts of the intervals of a step; `impulse` : of the box on all but the stinger, per interval."""
    h = on.interval
    stuck = not math.isnan(feed.limit)
    for k in range(stop):
        y, z = path[k], path[k + 1]
        e_rate = 0.0
        if feed.by_current:
            i_rate = (z[I] - y[I]) / h
            i_rate_end, e, e_end = i_rate, _voltage(y, i_rate, on), _voltage(z, i_rate, on)
        else:
            e = feed.limit if stuck else command[k0 + k]
            e_end = feed.limit if stuck else command[k0 + k + 1]
            e_rate = (e_end - e) / h
            i_rate = (e - _voltage(y, 0.0, on)) / on.inductance
            i_rate_end = (e_end - _voltage(z, 0.0, on)) / on.inductance
        if feed.by_current:
            aa, ab, _ = _rates(y, on, force)
            e_rate = on.resistance * i_rate + on.force_constant * (aa - ab)
        _powers(y, force, e, e_rate, i_rate, on, q, dq)
        for s in range(SQUARE + 1):
            accounts[s] += 0.5 * h * q[s] + h * h / 12.0 * dq[s]
        if feed.by_current:
            aa, ab, _ = _rates(z, on, force)
            e_rate = on.resistance * i_rate + on.force_constant * (aa - ab)
        _powers(z, force, e_end, e_rate, i_rate_end, on, q, dq)
        for s in range(SQUARE + 1):
            accounts[s] += 0.5 * h * q[s] - h * h / 12.0 * dq[s]
        swing = on.force_constant * (z[XA] - z[XB] - y[XA] + y[XB])
        if feed.by_current:
            flow = 0.5 * h * (y[I] + z[I])
            pressure = on.resistance * flow + on.inductance * (z[I] - y[I]) + swing
        else:
            pressure = 0.5 * h * (e + e_end)
            flow = (pressure - on.inductance * (z[I] - y[I]) - swing) / on.resistance
        signals[k0 + k, MOMENTUM] = on.box * (z[V] - y[V]) + on.damping * (z[X] - y[X]) + impulse
        signals[k0 + k, SPEED] += z[V] - y[V]
        signals[k0 + k, FLOW] = flow
        signals[k0 + k, PRESSURE] = pressure
        signals[k0 + k, GAUGE_MASS] = z[VA] - y[VA]
        signals[k0 + k, LIMITED] = 1.0 if stuck else 0.0
        pull = on.stinger * (z[XA] - z[X]) + on.stinger_damping * (z[VA] - z[V])
        accounts[MOST_VOLTAGE] = max(accounts[MOST_VOLTAGE], abs(e_end))
        accounts[MOST_CURRENT] = max(accounts[MOST_CURRENT], abs(z[I]))
        accounts[MOST_TRAVEL] = max(accounts[MOST_TRAVEL], abs(z[XA] - z[XB]))
        accounts[MOST_PULL] = max(accounts[MOST_PULL], -pull)
        accounts[MOST_PUSH] = max(accounts[MOST_PUSH], pull)


@njit(cache=True, nogil=True)
def stretch(
    on: Machine, around: Pull, feed: Feed, phi: Array, now: Array, following: Array, thrust: Array, command: Array,
    y: Array, w: Array, u: Array, lo: Array, hi: Array, band: Array, play: Array,
) -> tuple[Feed, Array, Array]:  # fmt: skip
    """Advance exciter, box (`y`) and rows (`w`, `u`, `lo`, `hi`), in place, along the edges of a command.

    Returns how the amplifier drives at the end, the signals, shape (intervals + 1, SIGNALS), and the accounts.
    """
    longest, intervals, rows, h = thrust.shape[1] - 1, command.shape[0] - 1, w.shape[0], on.interval
    path, moved = np.empty((longest + 1, STATES)), np.empty(longest + 1)
    signals, accounts = np.zeros((intervals + 1, SIGNALS)), np.zeros(ACCOUNTS)
    q, dq = np.empty(SQUARE + 1), np.empty(SQUARE + 1)
    p, slip, heat = np.zeros(rows), np.empty(rows), np.empty(rows)
    who = np.empty(rows, np.int64)
    grip = 1.0 / np.maximum(band, 1e-300)
    leaning = bool(np.any(hi - lo == math.inf))
    k0, force, per_time, least, most = 0, 0.0, 1.0, 0.0, 0.0
    while k0 < intervals:
        steps, kind = min(longest, intervals - k0), 1 if feed.by_current else 0
        _free(y, steps, k0, feed, command, phi, now, following, on, path)
        for k in range(steps + 1):
            moved[k] = path[k, X] - y[X] + force * thrust[kind, k, X]
            speed = path[k, V] + force * thrust[kind, k, V]
            least, most = (speed, speed) if k == 0 else (min(least, speed), max(most, speed))
        depth = TOUCH * (most - least) * steps * h
        count, first = next_walls(h, steps, around.pull, per_time, moved, depth, p, w, u, lo, hi, play, who, slip)
        if count:
            steps = min(int(first) + WINDOW, steps)
        time = steps * h
        start, free, gain = y[V], path[steps, V], thrust[kind, steps, V] / time
        end, given, air, guide = end_velocity(
            free + gain * time * force, start, free, gain, time, around, band, w, lo, hi, p
        )
        force, per_time = -given / time, 1.0 / time
        for k in range(1, steps + 1):
            for s in range(STATES):
                path[k, s] += force * thrust[kind, k, s]
        stop, after = _within(path, steps, k0, feed, command, on)
        way = path[stop, X] - y[X]
        accounts[AIR] += air / time * way
        accounts[GUIDE] += guide / time * way
        rub, push = carry(
            (end - start) / time - around.pull, start, time, stop * h, way, around, p, band, grip, w, u, lo, hi, play,
            slip, heat, leaning, stop == steps and 2 * steps > longest,
        )  # fmt: skip
        accounts[FRICTION] += rub - push
        accounts[COLLISION] += push
        _account(path, stop, k0, force, -force * h, feed, command, on, signals, accounts, q, dq)
        for s in range(STATES):
            y[s] = path[stop, s]
        if count:
            slow = abs(path[stop, V] - path[stop - 1, V]) + abs(around.pull) * h
            behind, lost = collide(y[V], h, slow, around, count, who, play, w, u, lo, hi)
            signals[k0 + stop - 1, SPEED] += 0.5 * (behind - y[V])
            signals[k0 + stop, SPEED] += 0.5 * (behind - y[V])
            accounts[COLLISION] += lost
            y[V] = behind
            leaning = True
        k0, feed = k0 + stop, after
    return feed, signals, accounts
