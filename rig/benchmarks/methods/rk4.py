"""Classical Runge-Kutta of order 4 with impacts, stops and starts located inside the step,
compiled.

The motion between two events is smooth, so that the order holds if an event's phase is as exact as
the step. It is found by Newton's method on a partial step, and a shorter step leads from there back
to the grid, whose sines come from a table. A wall is hit only by a mass that closes on it: after a
lift-off the gap grows like t^3, and round-off alone would fake an impact.
"""

import math
from functools import lru_cache

import numpy as np
from numba import njit

from rig.benchmarks.methods.method import Failed, Method, Work
from rig.benchmarks.problems.sliders import Slider
from rig.kernels.rows.many_rows import HISTORY, find_recurrence
from rig.kernels.waveform import Array

TWO_PI = 2.0 * math.pi
CHATTER = 1e-6
CONVERGED = 1e-13
ROUND_OFF = 1e-14
"""Distance to the grid, rad, below which no step is taken."""

STUCK = 1_000_000
"""Events in one cycle after which the method gives up."""


def solve(slider: Slider, setting: float, settle: int, average: int) -> Work:
    """Follow a slider with `setting` steps per cycle."""
    found = _run(
        slider.band,
        slider.clearance,
        slider.restitution,
        slider.gravity,
        *slider.start,
        sines(int(setting)),
        settle,
        average,
    )
    return _checked(Work(*found[:-1]))


def solve_steady(slider: Slider, setting: float, settle: int, average: int) -> tuple[Work, int]:
    """Return (work, period in cycles), following a slider only until a state recurs, as the rig
    does.

    The energy is then the mean over that period; period 0 where none was found in settle + average
    cycles.
    """
    found = _steady(
        slider.band,
        slider.clearance,
        slider.restitution,
        slider.gravity,
        *slider.start,
        sines(int(setting)),
        settle,
        average,
    )
    return _checked(Work(*found[:-1])), found[-1]


def _checked(found: Work) -> Work:
    if found.events < 0:
        raise Failed("the events of a cycle do not end")
    return found


@lru_cache
def sines(steps: int) -> Array:
    """Return the drive at the edges and in the middle of every step of a cycle."""
    return np.asarray(np.sin(math.pi / steps * np.arange(2 * steps + 1)))


@njit(cache=True, nogil=True, inline="always")
def _step(
    t: float, h: float, u: float, z: float, f: float, pull: float
) -> tuple[float, float, float]:
    """Return (u, z, right-hand side) after one step of u'' = sin(t) - pull from (u, z); f:
    right-hand side at t.
    """
    return _stepped(h, u, z, f, math.sin(t + 0.5 * h) - pull, math.sin(t + h) - pull)


@njit(cache=True, nogil=True, inline="always")
def _stepped(
    h: float, u: float, z: float, f: float, middle: float, end: float
) -> tuple[float, float, float]:
    """Return the result of `_step` from the right-hand sides in the middle and at the end."""
    return u + h * z + h * h / 6.0 * (f + 2.0 * middle), z + h / 6.0 * (f + 4.0 * middle + end), end


@njit(cache=True, nogil=True)
def _located(
    t: float,
    h: float,
    u: float,
    z: float,
    f: float,
    pull: float,
    level: float,
    sign: float,
    stop: bool,
) -> tuple[float, int]:
    """Return the time within [0, h] at which z (a stop) or u - level (a wall) changes sign, and the
    iterations.
    """
    low, high = 0.0, h
    u_end, z_end, _ = _step(t, h, u, z, f, pull)
    at_low = sign * z if stop else sign * (level - u)
    at_high = sign * z_end if stop else sign * (level - u_end)
    # Secant as the first guess, then Newton steps kept inside the bracket.
    guess = h * at_low / (at_low - at_high) if at_low > at_high else h
    for n in range(1, 60):
        u_new, z_new, force = _step(t, guess, u, z, f, pull)
        value = sign * z_new if stop else sign * (level - u_new)
        slope = sign * force if stop else -sign * z_new
        if value > 0.0:
            low = guess
        else:
            high = guess
        new = guess - value / slope if slope < 0.0 else 0.5 * (low + high)
        if not low <= new <= high:
            new = 0.5 * (low + high)
        if abs(new - guess) < CONVERGED:
            return new, n
        guess = new
    return guess, 60


@njit(cache=True, nogil=True)
def _start(
    t: float, h: float, at_low: float, at_high: float, level: float, sign: float, gravity: float
) -> tuple[float, int]:
    """Return the time within [0, h] at which sign (sin(t) - gravity) rises through `level`, and the
    iterations.

    at_low, at_high: its excess over the level at both ends.
    """
    low, high = 0.0, h
    guess = h * at_low / (at_low - at_high)
    for n in range(1, 60):
        value = sign * (math.sin(t + guess) - gravity) - level
        slope = sign * math.cos(t + guess)
        if value < 0.0:
            low = guess
        else:
            high = guess
        new = guess - value / slope if slope > 0.0 else 0.5 * (low + high)
        if not low <= new <= high:
            new = 0.5 * (low + high)
        if abs(new - guess) < CONVERGED or high - low < CONVERGED:
            return new, n
        guess = new
    return guess, 60


@njit(cache=True, nogil=True)
def _run(
    band: float,
    clearance: float,
    restitution: float,
    gravity: float,
    mode: int,
    u: float,
    z: float,
    sine: Array,
    settle: int,
    average: int,
) -> tuple[float, int, int, int, int, float, float, int]:
    """Follow a slider through all cycles; return the fields of `Work` and the mode, events -1 where
    they do not end.

    sine: `sines` of the grid. A step ends at the grid edge `n`; it begins at edge n - 1, or after
    an event in between (not `whole`). known: f holds the right-hand side at the beginning.
    """
    steps = (sine.size - 1) // 2
    length = TWO_PI / steps
    energy, events, rhs, taken, roots = 0.0, 0, 0, 0, 0
    for k in range(settle + average):
        t, n, lost, known, f = 0.0, 1, 0.0, False, 0.0
        whole = True
        limit = events + STUCK
        while n <= steps:
            h = length if whole else n * length - t
            # An event on the grid itself: go on from the grid point.
            if h <= ROUND_OFF:
                t, n, whole, known = n * length, n + 1, True, False
                continue
            # At rest: look for the start of a slide in this step.
            if mode == 0:
                if not known:
                    f = (sine[2 * n - 2] if whole else math.sin(t)) - gravity
                    rhs += 1
                push = f
                later = sine[2 * n] - gravity
                rhs += 1
                taken += 1
                known = False
                if (push > band or (push == band and later > band)) and u < clearance:
                    mode = 1
                elif (push < -band or (push == -band and later < -band)) and u > 0.0:
                    mode = -1
                elif later > band and u < clearance:
                    wait, count = _start(t, h, push - band, later - band, band, 1.0, gravity)
                    t, whole, mode, roots = t + wait, False, 1, roots + count
                    rhs += 2 * count
                elif later < -band and u > 0.0:
                    wait, count = _start(t, h, -push - band, -later - band, band, -1.0, gravity)
                    t, whole, mode, roots = t + wait, False, -1, roots + count
                    rhs += 2 * count
                else:
                    t, n, whole, f, known = n * length, n + 1, True, later, True
                if mode != 0:
                    events += 1
                continue
            # Sliding or flying: take a trial step, then look for a stop and a wall in it.
            pull = gravity + mode * band
            if not known:
                f = (sine[2 * n - 2] if whole else math.sin(t)) - pull
                rhs += 1
            middle = (sine[2 * n - 1] if whole else math.sin(t + 0.5 * h)) - pull
            u_end, z_end, force = _stepped(h, u, z, f, middle, sine[2 * n] - pull)
            rhs += 2
            taken += 1
            wall = 0
            stops = band > 0.0 and mode * z_end < 0.0
            if stops and z == 0.0:  # starts and stops again within one step: no net motion
                t, n, whole, mode, known = n * length, n + 1, True, 0, False
                continue
            part = h
            # A mass may reach the wall before it would stop: the wall is tested at the stop.
            if stops:
                part, count = _located(t, h, u, z, f, pull, 0.0, float(mode), True)
                rhs += 2 * count
                roots += count
                u_end, z_end, force = _step(t, part, u, z, f, pull)
                if mode == 1 and u_end > clearance:
                    wall = 1
                elif mode == -1 and u_end < 0.0:
                    wall = -1
            elif u_end < 0.0 and z_end < 0.0:
                wall = -1
            elif u_end > clearance and z_end > 0.0:
                wall = 1
            if wall != 0:
                level = clearance if wall == 1 else 0.0
                part, count = _located(t, part, u, z, f, pull, level, float(wall), False)
                rhs += 2 * count
                roots += count
                u_end, z_end, force = _step(t, part, u, z, f, pull)
                # Exactly on the wall, so that round-off does not accumulate.
                u_end = level
            lost += band * abs(u_end - u)
            if stops or wall != 0:
                t, whole = t + part, False
            else:
                t, n, whole = n * length, n + 1, True
            u, z, f, known = u_end, z_end, force, True
            if wall != 0:
                back = -restitution * z
                if abs(back) < CHATTER:
                    back = 0.0
                lost += 0.5 * (z * z - back * back)
                z = back
                mode = 0
                if z != 0.0:
                    mode = 1 if z > 0.0 else -1
                known = False
                events += 1
            elif stops:
                z, mode, known = 0.0, 0, False
                events += 1
            # A rebound sequence that converges too slowly would never end.
            if events > limit:
                return energy, -1, rhs, taken, roots, u, z, mode
        if k >= settle:
            energy += lost / average
    return energy, events, rhs, taken, roots, u, z, mode


@njit(cache=True, nogil=True)
def _steady(
    band: float,
    clearance: float,
    restitution: float,
    gravity: float,
    mode: int,
    u: float,
    z: float,
    sine: Array,
    settle: int,
    average: int,
) -> tuple[float, int, int, int, int, float, float, int]:
    """Follow cycle by cycle until a state recurs; the last value returned is the period."""
    history, losses = np.empty((HISTORY, 3)), np.empty(HISTORY)
    energy, events, rhs, taken, roots = 0.0, 0, 0, 0, 0
    for now in range(settle + average):
        back = find_recurrence(history, now, mode, u, z)
        if back > 0:
            energy = 0.0
            for b in range(1, back + 1):
                energy += losses[(now - b) % HISTORY] / back
            return energy, events, rhs, taken, roots, u, z, back
        k = now % HISTORY
        history[k, 0], history[k, 1], history[k, 2] = mode, u, z
        lost, found, more, steps, tries, u, z, mode = _run(
            band, clearance, restitution, gravity, mode, u, z, sine, 0, 1
        )
        if found < 0:
            return energy, -1, rhs, taken, roots, u, z, 0
        losses[k] = lost
        events, rhs, taken, roots = events + found, rhs + more, taken + steps, roots + tries
        if now >= settle:
            energy += lost / average
    return energy, events, rhs, taken, roots, u, z, 0


RK4 = Method(
    "RK4, events located", "compiled", "steps per cycle",
    (8, 16, 32, 64, 128, 256, 512, 1024, 2048), (16, 64, 256, 1024), solve, order=4,
)  # fmt: skip
