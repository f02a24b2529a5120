"""Balls, boxes and motions for the laws of the grains' kernel; SI units.

Unless a test says otherwise a ball is of steel, 5 mm, in contacts of 1e5 N/m that return half a
sine. A step is given as a fraction of the time of such a contact.
"""

import math
from dataclasses import dataclass

import numpy as np

from rig.kernels.grains.arrays import Law, Room
from rig.kernels.grains.engine import Engine, Packing
from rig.theory.contact import contact_time, damping_ratio

RADIUS, DENSITY, STIFFNESS, G = 2.5e-3, 7900.0, 1e5, 9.80665
MASS = DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3
WALL_TIME = contact_time(0.0, STIFFNESS, MASS)
"""Duration of an elastic contact of a ball and a wall, s."""
PAIR_TIME = contact_time(0.0, STIFFNESS, 0.5 * MASS)
"""Duration of an elastic contact of two balls, s: the t_c of the usual step t_c/14."""
HERTZ = 2e9
"""4/3 E* of the Hertz contacts, Pa: soft enough for overlaps that show."""


def linear(restitution: float = 1.0, friction: float = 0.0, **others: float) -> Law:
    """Return a linear law, the same for pairs and walls, with 2/7 of the stiffness in shear."""
    damping = 2.0 * damping_ratio(restitution)
    law = Law(
        hertz=0,
        pair_stiffness=STIFFNESS,
        wall_stiffness=STIFFNESS,
        pair_shear=2.0 / 7.0 * STIFFNESS,
        wall_shear=2.0 / 7.0 * STIFFNESS,
        pair_damping=damping,
        wall_damping=damping,
        shear_damping=0.5,
        pair_friction=friction,
        wall_friction=friction,
        pair_rolling=0.0,
        wall_rolling=0.0,
    )
    return law._replace(**others)


def hertzian(damping: float = 0.0, friction: float = 0.0, **others: float) -> Law:
    """Return a Hertz-Mindlin law for Poisson's ratio .3: 8 G*/(4/3 E*) = 3 (1 - nu)/(2 - nu)."""
    shear = 3.0 * 0.7 / 1.7 * HERTZ
    law = linear(1.0, friction, hertz=1, pair_damping=damping, wall_damping=damping)
    law = law._replace(pair_stiffness=HERTZ, wall_stiffness=HERTZ)
    return law._replace(pair_shear=shear, wall_shear=shear)._replace(**others)


def box(
    length: float = 0.1,
    width: float = 0.1,
    height: float = 0.1,
    axis: int = 0,
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    **others: float,
) -> Room:
    """Return one closed box; `pitch`, `cavities`, `cylinder`, `lid` change it."""
    room = Room(length, width, height, 0, 1, 1.0, 1, *gravity, axis)
    return room._replace(**others)


def down(tilt: float = 0.0) -> tuple[float, float, float]:
    """Return gravity seen from a floor tilted down towards larger x, m/s^2; tilt in rad."""
    return (G * math.sin(tilt), 0.0, -G * math.cos(tilt))


def balls(
    place: np.ndarray | list[list[float]],
    velocity: np.ndarray | list[list[float]],
    spin: np.ndarray | list[list[float]] | None = None,
    radius: np.ndarray | float = RADIUS,
) -> Packing:
    """Return balls of steel in cavity 0."""
    places = np.array(place, dtype=float)
    packing = Packing.at_rest(places, np.zeros(len(places)) + radius, DENSITY)
    packing.velocity[:] = velocity
    if spin is not None:
        packing.spin[:] = spin
    return packing


def still(steps: int) -> np.ndarray:
    """Return the velocity of a box at rest over a number of steps, for `Engine.advance`."""
    return np.zeros(steps + 1)


@dataclass(frozen=True)
class Flight:
    """Balls followed step by step: entry n belongs to the place n steps after the start.

    place, velocity, spin : shape (steps + 1, balls, 3); velocities half a step before each place
    """

    place: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray


def follow(engine: Engine, steps: int) -> Flight:
    """Advance a box at rest one step at a time and keep places and velocities."""
    seen = [engine.packing()]
    for _ in range(steps):
        engine.advance(still(1))
        seen.append(engine.packing())
    return Flight(
        np.array([now.place for now in seen]),
        np.array([now.velocity for now in seen]),
        np.array([now.spin for now in seen]),
    )


def extrapolated(coarse: float, fine: float, order: int) -> float:
    """Return the limit of a quantity from its values at a step and at half of it (Richardson)."""
    return fine + (fine - coarse) / (2**order - 1)


@dataclass(frozen=True)
class Shaken:
    """Balls in a box that is shaken: packing, law, room and its acceleration, m/s^2."""

    packing: Packing
    law: Law
    room: Room
    acceleration: float


FREQUENCY = 20.0


def heap(count: int, length: float, width: float, seed: int = 1, speed: float = 0.1) -> Packing:
    """Return balls that do not touch yet, layer upon layer, with random velocities (m/s)."""
    rng = np.random.default_rng(seed)
    pitch = 2.2 * RADIUS
    nx, ny = int(length / pitch), int(width / pitch)
    k = np.arange(count)
    place = np.stack(
        [
            (k % nx + 0.5) * length / nx,
            (k // nx % ny + 0.5) * width / ny,
            (k // (nx * ny) + 0.6) * pitch,
        ],
        axis=1,
    )
    place += rng.uniform(-0.09 * RADIUS, 0.09 * RADIUS, place.shape)
    return balls(place, rng.normal(0.0, speed, place.shape))


def in_cavities(packing: Packing, cavities: int, pitch: float) -> Packing:
    """Return the same grains in each of a number of cavities along y."""
    n = packing.radius.size
    place = np.tile(packing.place, (cavities, 1))
    place[:, 1] += np.repeat(np.arange(cavities), n) * pitch
    return Packing(
        place,
        np.tile(packing.radius, cavities),
        np.tile(packing.mass, cavities),
        np.tile(packing.velocity, (cavities, 1)),
        np.tile(packing.spin, (cavities, 1)),
        np.repeat(np.arange(cavities, dtype=np.int32), n),
    )


def shaken(name: str) -> Shaken:
    """Return one of the scenes on which every law of a shaken box is tried."""
    law, sides, weight = linear(0.6, 0.3), (0.05, 0.02, 0.05), down()
    packing = heap(130, sides[0], sides[1])
    if name == "horizontal":
        return Shaken(packing, law, box(*sides, 0, weight), 10.0)
    if name == "sideways":
        return Shaken(packing, law, box(*sides, 1, weight), 10.0)
    if name == "vertical":
        return Shaken(packing, law, box(*sides, 2, weight), 30.0)
    if name == "weightless":
        return Shaken(packing, law, box(*sides, 0), 20.0)
    if name == "hertz":
        return Shaken(packing, hertzian(0.4, 0.3), box(*sides, 0, weight), 10.0)
    if name == "rolling":
        rolls = law._replace(pair_rolling=0.1, wall_rolling=0.1)
        return Shaken(packing, rolls, box(*sides, 0, weight), 10.0)
    if name == "sizes":
        radius = np.random.default_rng(5).uniform(0.5 * RADIUS, RADIUS, 130)
        packing = balls(packing.place, packing.velocity, radius=radius)
        return Shaken(packing, law, box(*sides, 0, weight), 10.0)
    if name == "cavities":
        packing = in_cavities(heap(40, 0.025, 0.02), 3, 0.1)
        room = box(0.025, 0.02, 0.05, 0, weight, pitch=0.1, cavities=3)
        return Shaken(packing, law, room, 10.0)
    assert name == "cylinder"
    packing = heap(90, 0.02, 0.02)
    packing.place[:, :2] += 0.01 * (math.sqrt(2.0) - 1.0)
    across = 0.02 * math.sqrt(2.0)
    room = box(across, across, 0.09, 0, weight, cylinder=1)
    return Shaken(packing, law, room, 10.0)


SCENES = (
    "horizontal",
    "sideways",
    "vertical",
    "weightless",
    "hertz",
    "rolling",
    "sizes",
    "cavities",
    "cylinder",
)


def cycles(acceleration: float, count: int, steps: int) -> np.ndarray:
    """Return the velocity of a box that is shaken from its middle, half a step around each step."""
    n = np.arange(count * steps + 1) - 0.5
    top = acceleration / (2.0 * math.pi * FREQUENCY)
    return np.asarray(top * np.cos(2.0 * math.pi * n / steps))


def steps_of(part: float) -> int:
    """Return the number of steps in a cycle when a step is `part` of the time of a contact."""
    return round(1.0 / (FREQUENCY * part * PAIR_TIME))
