"""Semi-implicit Euler, first order, fixed step, compiled.

Impacts and stops happen at the end of their step.
"""

import math

from numba import njit

from rig.benchmarks.methods.first_order import first_order
from rig.kernels.waveform import Array

TWO_PI = 2.0 * math.pi


@njit(cache=True, nogil=True)
def _run(
    band: float,
    clearance: float,
    restitution: float,
    gravity: float,
    u: float,
    z: float,
    sine: Array,
    settle: int,
    average: int,
) -> tuple[float, int, int, int, int, float, float]:
    """Update the velocity, with friction capped at standstill, then the position, clipped to the
    walls.

    A wall costs energy only if the mass was off it before: a mass pressed on is stopped anew in
    every step. A rebound slower than the velocity change of one step ends there.
    """
    steps = sine.size
    h = TWO_PI / steps
    # The largest velocity change by the push in one step.
    least = h * (1.0 + gravity)
    grip = h * band
    energy, events = 0.0, 0
    for k in range(settle + average):
        lost = 0.0
        for n in range(steps):
            z += h * (sine[n] - gravity)
            # Friction cannot reverse a velocity: within its impulse the mass stops.
            if abs(z) <= grip:
                z = 0.0
            else:
                z -= math.copysign(grip, z)
            before = u
            u += h * z
            if u < 0.0 or u > clearance:
                wall = 0.0 if u < 0.0 else clearance
                back = -restitution * z
                if abs(back) < least:
                    back = 0.0
                if before != wall:
                    lost += 0.5 * (z * z - back * back)
                    events += 1
                u, z = wall, back
            lost += band * abs(u - before)
        if k >= settle:
            energy += lost / average
    taken = (settle + average) * steps
    return energy, events, taken, taken, 0, u, z


EULER = first_order("semi-implicit Euler", _run, 0.0)
