"""The sliders' motion in closed form, event by event, in plain Python: slow, and independent of the
rig's code.

Between events u and z are known functions of the phase; a dense scan brackets the first event,
Brent's method finds it.
"""

import math
from collections.abc import Callable
from functools import partial

from scipy.optimize import brentq

SCAN = 2.0 * math.pi / 1024
"""Step of the scan, rad: closer events are distinguished only where a flight starts with a
velocity.
"""

CHATTER = 1e-6
"""Rebounds slower than this end at the wall, as in `rig.kernels.rows.one_row`: the energy cut off
is below 5e-13 of m V^2.
"""


def energies(
    band: float,
    clearance: float,
    restitution: float,
    gravity: float,
    start: tuple[int, float, float],
    cycles: int,
) -> list[float]:
    """Return the energy lost in each cycle, m V^2 (symbols: `rig.benchmarks.problems.sliders`)."""
    return followed(band, clearance, restitution, gravity, start, cycles)[0]


def followed(
    band: float,
    clearance: float,
    restitution: float,
    gravity: float,
    start: tuple[int, float, float],
    cycles: int,
) -> tuple[list[float], float, float]:
    """Return (energy lost in each cycle, position, velocity after the last one)."""
    lost = [0.0] * cycles
    end = 2.0 * math.pi * cycles
    mode, u, z = start
    t = 0.0
    while t < end:
        if mode == 0:
            t, mode = _release(t, u, band, clearance, gravity, end)
            z = 0.0
            continue
        arrival = _Flight(t, u, z, mode * band + gravity)
        until, kind = _next(arrival, mode, band, clearance, end)
        # A slide over the end of a cycle is divided between the cycles.
        for k in range(int(t / (2.0 * math.pi)), min(int(until / (2.0 * math.pi)), cycles - 1) + 1):
            first, last = max(t, 2.0 * math.pi * k), min(until, 2.0 * math.pi * (k + 1))
            lost[k] += band * abs(arrival.place(last) - arrival.place(first))
        u, z, t = arrival.place(until), arrival.speed(until), until
        if kind == "wall":
            u = clearance if z > 0.0 else 0.0
            back = -restitution * z if restitution * abs(z) >= CHATTER else 0.0
            lost[min(int(t / (2.0 * math.pi)), cycles - 1)] += 0.5 * (z * z - back * back)
            z = back
            mode = 0 if z == 0.0 else int(math.copysign(1, z))
        elif kind == "stop":
            mode = 0
    return lost, u, z


class _Flight:
    """Motion from (t, u, z) under sin(theta) - pull."""

    def __init__(self, t: float, u: float, z: float, pull: float) -> None:
        self._t, self._u, self._z, self.pull = t, u, z, pull
        self._sin, self._cos = math.sin(t), math.cos(t)

    def speed(self, t: float) -> float:
        """Return the velocity at phase t."""
        return self._z + self._cos - math.cos(t) - self.pull * (t - self._t)

    def place(self, t: float) -> float:
        """Return the position at phase t."""
        d = t - self._t
        return (
            self._u
            + (self._z + self._cos) * d
            - (math.sin(t) - self._sin)
            - 0.5 * self.pull * d * d
        )

    def soon(self) -> float:
        """Return a phase just after the start at which a rebound still leaves the wall."""
        force = abs(self._sin - self.pull)
        return self._t + min(SCAN, abs(self._z) / force if force > 0.0 else SCAN)


def _next(
    flight: _Flight, mode: int, band: float, clearance: float, end: float
) -> tuple[float, str]:
    """Return phase and kind of the first event of a flight: "wall", "stop" (only with friction) or
    "end".
    """
    before = flight.soon()
    while before < end:
        after = min(before + SCAN, end)
        found = []
        if flight.place(after) < 0.0 and flight.speed(after) < 0.0:
            found.append((_root(flight.place, before, after), "wall"))
        if flight.place(after) > clearance and flight.speed(after) > 0.0:
            found.append((_root(lambda x: flight.place(x) - clearance, before, after), "wall"))
        if band > 0.0 and mode * flight.speed(after) < 0.0:
            found.append((_root(flight.speed, before, after), "stop"))
        if found:
            return min(found)
        before = after
    return end, "end"


def _release(
    t: float, u: float, band: float, clearance: float, gravity: float, end: float
) -> tuple[float, int]:
    """Return the phase from t on at which a mass at rest starts to move, and the direction; (end,
    0) for never.
    """
    while t < end:
        mode = _thrown(t, u, band, clearance, gravity)
        if mode:
            return t, mode
        after = min(t + SCAN, end)
        mode = _thrown(after, u, band, clearance, gravity)
        if mode:
            return _root(partial(_excess, gravity + mode * band), t, after), mode
        t = after
    return end, 0


def _excess(level: float, t: float) -> float:
    return math.sin(t) - level


def _thrown(t: float, u: float, band: float, clearance: float, gravity: float) -> int:
    # A computed root may lie within round-off below its level: a push 4e-15 short of the band
    # counts as reaching it, if it still grows.
    """Return the direction in which a mass at rest at phase t starts to move, 0 where it stays."""
    push = math.sin(t) - gravity
    rising = math.cos(t) > 0.0
    if u < clearance and (push > band or (push > band - 4e-15 and rising)):
        return 1
    if u > 0.0 and (push < -band or (push < -band + 4e-15 and not rising)):
        return -1
    return 0


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    """Return the root in a bracket; without a change of sign (round-off at an end) the end with the
    smaller value.
    """
    at_low, at_high = function(low), function(high)
    if at_low == 0.0 or (at_low > 0.0) == (at_high > 0.0):
        return low if abs(at_low) <= abs(at_high) else high
    return float(brentq(function, low, high, xtol=1e-15, rtol=1e-15))
