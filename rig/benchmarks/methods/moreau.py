"""Moreau's time stepping at the midpoint, compiled: contact and friction as inclusions on
velocities, no event located.

Source: J. J. Moreau, Numerical aspects of the sweeping process, Comput. Methods Appl. Mech. Eng.
177 (1999) 329; with Newton's impact law as in V. Acary and B. Brogliato, Numerical Methods for
Nonsmooth Dynamical Systems (2008), ch. 10.
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
    """Step with contacts active where the midpoint u + h z/2 has reached a wall; there z ->
    max(z_free, -e z), mirrored at the lid.
    """
    steps = sine.size
    h = TWO_PI / steps
    grip = h * band
    energy, events = 0.0, 0
    for k in range(settle + average):
        lost = 0.0
        for n in range(steps):
            middle = u + 0.5 * h * z
            free = z + h * (sine[n] - gravity)
            new = 0.0 if abs(free) <= grip else free - math.copysign(grip, free)
            if middle <= 0.0:
                new = max(new, -restitution * z)
            if middle >= clearance:
                new = min(new, -restitution * z)
            struck = (middle <= 0.0 and z < 0.0) or (middle >= clearance and z > 0.0)
            if struck:
                lost += 0.5 * (z * z - new * new)
                events += 1
            else:
                lost += band * abs(0.5 * h * (z + new))
            z = new
            u = middle + 0.5 * h * z
        if k >= settle:
            energy += lost / average
    taken = (settle + average) * steps
    return energy, events, taken, taken, 0, u, z


MOREAU = first_order("Moreau time stepping", _run, 0.5)
