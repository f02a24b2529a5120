"""Sliders and single masses with a known answer, on which the integrators are compared.

One mass in a box that moves as x = sin theta; units of the waveform (acceleration A, velocity
A/omega, length A/omega^2, energy m V^2). u in [0, clearance] is the mass's position in the box, z =
u' its velocity against the box:

    z' = sin(theta) - gravity - band sign(z),    u = 0 or clearance: z -> -restitution z,

and where z = 0 the mass rests as long as |sin(theta) - gravity| <= band or a wall is in its way.
`band` > 0 makes a slider with Coulomb friction, `gravity` = 1/Gamma > 0 a single mass on a floor,
with a lid at `clearance` where that is finite.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from rig.benchmarks.problems.reference import energies

WIDE = 40.0
"""Free clearance out of reach: a slider without friction in so wide a box would need more than 8
cycles to cross it.
"""

START_MIDDLE = 20.0


@dataclass(frozen=True)
class Slider:
    """A problem with its answer.

    start: mode (0 at rest, +1 or -1 the direction of sliding), u and z at phase 0. settle: cycles
    until its orbit is steady. period: of the orbit, cycles. exact: energy lost per cycle, m V^2.
    source: of that value, "closed form" or "reference".
    """

    name: str
    band: float
    clearance: float
    restitution: float
    gravity: float
    exact: float
    source: str = "closed form"
    start: tuple[int, float, float] = (0, 0.0, 0.0)
    settle: int = 4
    period: int = 1


def sliding_block(eta: float) -> Slider:
    """Return a block on a rough floor that never rests, eta < 0.537: W = 4 eta sqrt(1 - (pi
    eta/2)^2).

    It starts on its orbit: it reverses where cos theta = pi eta/2, and half a cycle later its state
    is mirrored.
    """
    turn = math.acos(0.5 * math.pi * eta)
    z = -(math.cos(turn) + 1.0 - eta * (math.pi - turn))
    exact = 4.0 * eta * math.sin(turn)
    return Slider(f"block, eta {eta:g}", eta, WIDE, 0.0, 0.0, exact, start=(-1, START_MIDDLE, z))


def resting_block(eta: float) -> Slider:
    """Return a block on a rough floor that rests twice per cycle, 0.537 < eta < 1: it starts where
    sin theta = eta.
    """
    begin = math.asin(eta)
    stop = _root(
        lambda t: math.cos(begin) - math.cos(t) - eta * (t - begin),
        math.pi - begin,
        begin + math.pi,
    )
    way = math.cos(begin) * (stop - begin) - math.sin(stop) + eta - 0.5 * eta * (stop - begin) ** 2
    return Slider(
        f"block, eta {eta:g}", eta, WIDE, 0.0, 0.0, 2.0 * eta * way, start=(0, START_MIDDLE, 0.0)
    )


def weightless(clearance: float) -> Slider:
    """Return a plastic slider without friction (zero gravity), clearance <= pi: tau - sin tau =
    clearance, W = (1 - cos tau)^2.
    """
    tau = _root(lambda t: t - math.sin(t) - clearance, 0.0, 2.0 * math.pi)
    return Slider(
        f"weightless, gap {clearance:g}", 0.0, clearance, 0.0, 0.0, (1.0 - math.cos(tau)) ** 2
    )


def rough(band: float, clearance: float) -> Slider:
    """Return a plastic slider with friction that reaches the other wall and waits there: W = 2 band
    clearance + z^2.

    It leaves where sin theta = band; `clearance` must be small enough for it to arrive while it is
    still pressed on.
    """
    begin = math.asin(band)

    def way(t: float) -> float:
        return (
            math.cos(begin) * (t - begin)
            - math.sin(t)
            + band
            - 0.5 * band * (t - begin) ** 2
            - clearance
        )

    hit = _root(way, begin, begin + math.pi)
    z = math.cos(begin) - math.cos(hit) - band * (hit - begin)
    return Slider(
        f"friction {band:g}, gap {clearance:g}",
        band,
        clearance,
        0.0,
        0.0,
        2.0 * band * clearance + z * z,
    )


def elastic(band: float, clearance: float, restitution: float, settle: int = 8) -> Slider:
    """Return a slider that rebounds; the answer comes from `reference`, closed flights with
    independent root finding.
    """
    found = energies(band, clearance, restitution, 0.0, (0, 0.0, 0.0), settle + 1)
    return Slider(
        f"e {restitution:g}, friction {band:g}",
        band,
        clearance,
        restitution,
        0.0,
        found[-1],
        "reference",
        settle=settle,
    )


def single_mass(level: float) -> Slider:
    """Return a plastic single mass on a floor without a lid, Gamma = `level`: leaves where sin
    theta = 1/Gamma, lands at the first root.
    """
    gravity = 1.0 / level
    begin = math.asin(gravity)

    def height(t: float) -> float:
        return (
            math.cos(begin) * (t - begin) - math.sin(t) + gravity - 0.5 * gravity * (t - begin) ** 2
        )

    apex = _root(
        lambda t: math.cos(begin) - math.cos(t) - gravity * (t - begin),
        math.pi - begin,
        begin + 3.0 * math.pi,
    )
    land = _root(height, apex, apex + 2.0 * math.pi)
    z = math.cos(begin) - math.cos(land) - gravity * (land - begin)
    return Slider(f"single mass, Gamma {level:g}", 0.0, WIDE, 0.0, gravity, 0.5 * z * z)


def lidded_single_mass(level: float, gap: float) -> Slider:
    """Return a plastic single mass that is thrown against a lid and falls back when the box's
    acceleration allows.
    """
    found = energies(0.0, gap, 0.0, 1.0 / level, (0, 0.0, 0.0), 5)
    return Slider(
        f"single mass, Gamma {level:g}, gap {gap:g}",
        0.0,
        gap,
        0.0,
        1.0 / level,
        found[-1],
        "reference",
    )


@lru_cache
def sliders() -> tuple[Slider, ...]:
    """Return the sliders of the comparison: friction without rest, with rest, impacts without
    friction, both, and a rebound.
    """
    return (
        sliding_block(0.3),
        resting_block(0.7),
        weightless(1.0),
        rough(0.1, 1.3),
        elastic(0.2, 1.3, 0.25),
    )


@lru_cache
def single_masses() -> tuple[Slider, ...]:
    """Return the single masses of the comparison: barely thrown (the gap grows like t^3), thrown,
    thrown far, and against a lid.
    """
    return single_mass(1.01), single_mass(1.5), single_mass(2.5), lidded_single_mass(4.0, 1.0)


def _root(function: Callable[[float], float], low: float, high: float) -> float:
    return float(brentq(function, low, high, xtol=1e-15, rtol=4.0 * np.finfo(float).eps))
