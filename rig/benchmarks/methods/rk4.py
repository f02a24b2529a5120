"""Classical Runge-Kutta of order 4 with impacts, stops and starts located inside the step; compiled.

A stretch between two events is smooth, so that the order holds if an event's phase is as exact as the step: it is
found by Newton's method on the step itself taken to a fraction, and the next step starts there. A wall is hit only by
a mass that closes on it: behind a lift-off the gap grows like t^3, and round-off alone would fake an impact.
"""

import math

from numba import njit

from rig.benchmarks.methods.method import Failed, Method, Work
from rig.benchmarks.sliders import Slider

TWO_PI = 2.0 * math.pi
CHATTER = 1e-6
CONVERGED = 1e-13
STUCK = 1_000_000
"""Events in one cycle at which the method gives up."""


def solve(slider: Slider, setting: float, settle: int, average: int) -> Work:
    """`setting` steps per cycle."""
    found = Work(
        *_run(
            slider.band, slider.play, slider.restitution, slider.gravity, *slider.start, int(setting), settle, average
        )
    )
    if found.events < 0:
        raise Failed("the events of a cycle do not end")
    return found


@njit(cache=True, nogil=True, inline="always")
def _step(t: float, h: float, u: float, z: float, f: float, pull: float) -> tuple[float, float, float]:
    """One step of u'' = sin(t) - pull from (u, z), with f the right-hand side at t; also the one at its end."""
    middle = math.sin(t + 0.5 * h) - pull
    end = math.sin(t + h) - pull
    return u + h * z + h * h / 6.0 * (f + 2.0 * middle), z + h / 6.0 * (f + 4.0 * middle + end), end


@njit(cache=True, nogil=True)
def _located(
    t: float, h: float, u: float, z: float, f: float, pull: float, level: float, sign: float, stop: bool
) -> tuple[float, int]:
    """Share of a step after which z (a stop) or u - level (a wall) has lost the sign it starts with; iterations."""
    low, high = 0.0, h
    u_end, z_end, _ = _step(t, h, u, z, f, pull)
    at_low = sign * z if stop else sign * (level - u)
    at_high = sign * z_end if stop else sign * (level - u_end)
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
    """Share of a step after which sign (sin(t) - gravity) rises through `level`, from its excess at both ends."""
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
    band: float, play: float, restitution: float, gravity: float, mode: int, u: float, z: float, steps: int,
    settle: int, average: int,
) -> tuple[float, int, int, int, int, float, float]:  # fmt: skip
    length = TWO_PI / steps
    energy, events, rhs, taken, roots = 0.0, 0, 0, 0, 0
    for k in range(settle + average):
        t, lost, known, f = 0.0, 0.0, False, 0.0
        limit = events + STUCK
        while t < TWO_PI:
            h = min(length, TWO_PI - t)
            if mode == 0:
                if not known:
                    f = math.sin(t) - gravity
                    rhs += 1
                push = f
                later = math.sin(t + h) - gravity
                rhs += 1
                taken += 1
                known = False
                if (push > band or (push == band and later > band)) and u < play:
                    mode = 1
                elif (push < -band or (push == -band and later < -band)) and u > 0.0:
                    mode = -1
                elif later > band and u < play:
                    share, n = _start(t, h, push - band, later - band, band, 1.0, gravity)
                    t, mode, roots = t + share, 1, roots + n
                    rhs += 2 * n
                elif later < -band and u > 0.0:
                    share, n = _start(t, h, -push - band, -later - band, band, -1.0, gravity)
                    t, mode, roots = t + share, -1, roots + n
                    rhs += 2 * n
                else:
                    t, f, known = t + h, later, True
                if mode != 0:
                    events += 1
                continue
            pull = gravity + mode * band
            if not known:
                f = math.sin(t) - pull
                rhs += 1
            u_end, z_end, force = _step(t, h, u, z, f, pull)
            rhs += 2
            taken += 1
            wall = 0
            stops = band > 0.0 and mode * z_end < 0.0
            if stops and z == 0.0:  # thrown and caught again within one step: it does not get anywhere
                t, mode, known = t + h, 0, False
                continue
            part = h
            if stops:
                part, n = _located(t, h, u, z, f, pull, 0.0, float(mode), True)
                rhs += 2 * n
                roots += n
                u_end, z_end, force = _step(t, part, u, z, f, pull)
                if mode == 1 and u_end > play:
                    wall = 1
                elif mode == -1 and u_end < 0.0:
                    wall = -1
            elif u_end < 0.0 and z_end < 0.0:
                wall = -1
            elif u_end > play and z_end > 0.0:
                wall = 1
            if wall != 0:
                level = play if wall == 1 else 0.0
                part, n = _located(t, part, u, z, f, pull, level, float(wall), False)
                rhs += 2 * n
                roots += n
                u_end, z_end, force = _step(t, part, u, z, f, pull)
                u_end = level
            lost += band * abs(u_end - u)
            t += part
            u, z, f, known = u_end, z_end, force, True
            if wall != 0:
                back = -restitution * z
                if abs(back) < CHATTER:
                    back = 0.0
                lost += 0.5 * (z * z - back * back)
                z = back
                mode = 0 if z == 0.0 else (1 if z > 0.0 else -1)
                known = False
                events += 1
            elif stops:
                z, mode, known = 0.0, 0, False
                events += 1
            if events > limit:
                return energy, -1, rhs, taken, roots, u, z
        if k >= settle:
            energy += lost / average
    return energy, events, rhs, taken, roots, u, z


RK4 = Method(
    "RK4, events located", "compiled", "steps per cycle",
    (8, 16, 32, 64, 128, 256, 512, 1024, 2048), (16, 64, 256, 1024), solve, order=4,
)  # fmt: skip
