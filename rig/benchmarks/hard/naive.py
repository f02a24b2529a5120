"""Methods that fail on a hard case: fixed steps, tests on the gap alone.

Used only to show their failures.
"""

import math

import numpy as np


def pressed(restitution: float, steps: int, cycles: int) -> float:
    """Return the depth, in amplitudes, to which a mass pressed onto a wall by a constant push sinks
    into it, with fixed steps.

    The usual loop: velocity, position, and v = -e v where the gap is negative. Once a rebound is
    shorter than a step, the mass is still inside after it, its rebound is reversed again, and it
    falls through.
    """
    h = 2.0 * math.pi / steps
    gap, v = 0.0, 0.5
    deepest = 0.0
    for _ in range(steps * cycles):
        v -= h
        gap += h * v
        if gap < 0.0:
            v = -restitution * v
        deepest = max(deepest, -gap)
    return deepest


def friction_block(eta: float, steps: int, cycles: int) -> float:
    """Return the loss per cycle of a block on a rough floor, units m A^2/w^2, by semi-implicit
    steps with -eta sign(z).
    """
    h = 2.0 * math.pi / steps
    z, lost = 0.0, 0.0
    for n in range(steps * cycles):
        push = math.sin((n + 0.5) * h)
        z += h * (push - eta * float(np.sign(z)))
        if n >= steps * (cycles - 1):
            lost += h * eta * abs(z)
    return lost


def false_contacts(eta: float, samples: int) -> float:
    """Return the fraction of phases up to 1e-5 rad after a lift-off at which the gap in double
    precision is not open.

    The gap grows as cos(t0) (t - t0)^3/6, which is below 1e-16 there, and is computed as the
    difference of numbers near 1.
    """
    start = math.asin(eta)
    t = start + np.linspace(0.0, 1e-5, samples)[1:]
    past = t - start
    gap = (math.sin(start) + math.cos(start) * past) - 0.5 * eta * past**2 - np.sin(t)
    return float(np.mean(gap <= 0.0))


def single_mass(level: float, steps: int, cycles: int) -> float:
    """Return the loss per cycle of a plastic single mass on a floor, units m A^2/w^2, by
    semi-implicit steps: it is put down where u < 0.
    """
    h = 2.0 * math.pi / steps
    u, z, lost = 0.0, 0.0, 0.0
    for n in range(steps * cycles):
        z += h * (math.sin((n + 0.5) * h) - 1.0 / level)
        u += h * z
        if u < 0.0:
            if n >= steps * (cycles - 1):
                lost += 0.5 * z * z
            u, z = 0.0, 0.0
    return lost


def oscillator(turn: float, steps: int) -> float:
    """Return the largest energy relative to the first of an undamped oscillator in semi-implicit
    steps of `turn` rad.
    """
    x, v, most = 0.0, 1.0, 1.0
    for _ in range(steps):
        v -= turn * x
        x += turn * v
        most = max(most, x * x + v * v)
    return most
