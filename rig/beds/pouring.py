"""Fill a box with grains as a laboratory does: pour them, let them settle, strike off the surplus.

The fill is the settled height over the box's height: grains whose top lies above it are taken away.
A refill is another seed.
"""

import math

import numpy as np
from numpy.typing import NDArray

from rig.kernels.grains.arrays import Law, Room
from rig.kernels.grains.engine import Engine, Packing
from rig.kernels.grains.rain import place_free

Array = NDArray[np.float64]

RAIN = 0.2
"""Volume fraction of the grains in the air before they fall. Denser rain settles looser (measured
on 584 balls: mean height 14.2 mm at .2, 14.5 mm at .3, 14.7 mm from a lattice)."""
SURPLUS = 1.15
"""Grains poured over those that a packing of volume fraction .6 would need."""
DENSE = 0.60
"""Volume fraction for that estimate."""
THROWN = 0.1
"""Standard deviation of the velocity components of a falling grain, m/s."""
QUIET = 1e-4
"""Settled: mean kinetic energy of a grain below this fraction of m g d."""
CHECKS = 0.025
"""Time between two looks at the kinetic energy, s."""
LONGEST = 4.0
"""Longest time allowed for settling, s; a bed that is not quiet then is used as it is."""
AFTERWARDS = 0.05
"""Time to settle after the surplus has been struck off, s."""
TRIES = 400
"""Places tried for each grain of the rain; at a volume fraction of .2 one in four is free."""


def pour(
    radii: Array, density: float, fill: float, law: Law, room: Room, dt: float, seed: int
) -> Packing:
    """Return a settled packing of one cavity, at rest, SI units.

    radii : a supply of radii in random order, at least `supply` many, m; density : of the balls,
        kg/m^3
    fill : settled height over the box's height
    room : its gravity acts along -z, its lid is left open while the grains fall
    """
    if fill <= 0.0 or radii.size == 0:
        none = np.zeros((0, 3))
        return Packing(none, np.zeros(0), np.zeros(0), none, none, np.zeros(0, np.int32))
    rng = np.random.default_rng(seed)
    place, radius = _rain(radii, room, rng)
    tall = room._replace(
        height=float(place[:, 2].max()) + 2.0 * float(radius.max()), lid=0, cavities=1
    )
    grains = Packing.at_rest(place, radius, density)
    grains.velocity[:] = THROWN * rng.standard_normal(place.shape)
    settled = _settle(Engine(grains, law, tall, dt), LONGEST)
    kept = settled.place[:, 2] + settled.radius <= fill * room.height
    struck = Packing.at_rest(settled.place[kept], settled.radius[kept], density)
    engine = Engine(struck, law, tall, dt)
    engine.advance(np.zeros(math.ceil(AFTERWARDS / dt) + 1))
    last = engine.packing()
    return Packing.at_rest(last.place, last.radius, density)


def supply(fill: float, room: Room, mean_volume: float) -> int:
    """Return how many grains to pour, surplus included. mean_volume : of a grain, m^3."""
    area = math.pi / 4.0 * room.length**2 if room.cylinder else room.length * room.width
    of_bed = math.ceil(SURPLUS * DENSE * area * room.height * fill / mean_volume)
    one_layer = math.ceil(area / math.pow(mean_volume, 2.0 / 3.0))
    return of_bed + one_layer


def _settle(engine: Engine, longest: float) -> Packing:
    steps = math.ceil(CHECKS / engine.dt)
    still = np.zeros(steps + 1)
    for _ in range(math.ceil(longest / CHECKS)):
        engine.advance(still)
        grains = engine.packing()
        speed = np.sum(grains.velocity**2, axis=1) @ grains.mass
        weight = 9.81 * grains.mass @ grains.radius
        if speed < 4.0 * QUIET * weight:
            break
    return grains


def _rain(radii: Array, room: Room, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return places (m) of balls that do not overlap, at random, and their radii.

    Random sequential addition in a column tall enough for the volume fraction `RAIN`; a ball that
    finds no place is left out.
    """
    largest = float(radii.max())
    area = math.pi / 4.0 * room.length**2 if room.cylinder else room.length * room.width
    height = float(np.sum(4.0 / 3.0 * np.pi * radii**3)) / (RAIN * area) + 2.0 * largest
    place = np.zeros((radii.size, 3))
    found = np.zeros(radii.size, np.bool_)
    cell = 2.0 * largest
    shape = [math.ceil(size / cell) for size in (room.length, room.width, height)]
    # Room in a cell for the smallest balls: as many as fit, and a few more.
    most = math.ceil(2.0 * (largest / float(radii.min())) ** 3) + 4
    slots = np.full((*shape, most), -1, np.int32)
    # Large balls first: they would not find a place later.
    order = np.argsort(-radii, kind="stable").astype(np.int32)
    waiting = order
    for _ in range(TRIES):
        place_free(
            waiting, rng.random((waiting.size, 3)), radii, room, height, cell, slots, place, found
        )
        waiting = order[~found[order]]
        if waiting.size == 0:
            break
    return place[found], radii[found]
