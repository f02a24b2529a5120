"""Energy of grains that LAMMPS moves, from what it returns: places, velocities, forces."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from rig.kernels.grains.arrays import Law, Room
from rig.kernels.grains.engine import Packing

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Snapshot:
    """Grains half a step ago and the loads on them now, in the order of their numbers; SI units.

    grains : places now, velocities half a step ago
    force, torque : of contacts and weight, shape (n, 3)
    """

    grains: Packing
    force: Array
    torque: Array


def energies(now: Snapshot, law: Law, room: Room, before: float, dt: float) -> Array:
    """Return kinetic (laboratory), rotational, weight and elastic energy, J, as `Engine.energy`.

    before : velocity of the box half a step ago, m/s

    The elastic energy is that of the normal springs alone: LAMMPS does not tell the stretch of the
    tangential ones.
    """
    grains = now.grains
    box = np.zeros(3)
    box[room.axis] = before
    old = grains.velocity + box
    new = old + dt * now.force / grains.mass[:, None]
    inertia = 0.4 * grains.mass * grains.radius**2
    spin = grains.spin + dt * now.torque / inertia[:, None]
    gravity = np.array([room.gravity_x, room.gravity_y, room.gravity_z])
    return np.array(
        [
            0.5 * float(grains.mass @ np.sum(old * new, axis=1)),
            0.5 * float(inertia @ np.sum(grains.spin * spin, axis=1)),
            -float(grains.mass @ (grains.place @ gravity)),
            normal_energy(grains, law, room),
        ]
    )


def normal_energy(grains: Packing, law: Law, room: Room) -> float:
    """Return the elastic energy in the normal springs of pairs and walls, J."""
    if grains.radius.size == 0:
        return 0.0
    tree = KDTree(grains.place)
    pairs = tree.query_pairs(2.0 * float(grains.radius.max()), output_type="ndarray")
    one, two = pairs[:, 0], pairs[:, 1]
    between = grains.place[one] - grains.place[two]
    reach = grains.radius[one] + grains.radius[two]
    overlap = reach - np.sqrt(np.sum(between * between, axis=1))
    found = _stored(overlap, grains.radius[one] * grains.radius[two] / reach, law.hertz)
    walls = 0.0
    for distance in _distances(grains, room):
        walls += _stored(grains.radius - distance, grains.radius, law.hertz)
    return law.pair_stiffness * found + law.wall_stiffness * walls


def _stored(overlap: Array, radius: Array, hertz: int) -> float:
    """Return the energy of springs of stiffness 1."""
    deep = np.maximum(overlap, 0.0)
    if hertz:
        return 0.4 * float(np.sum(np.sqrt(radius * deep) * deep**2))
    return 0.5 * float(np.sum(deep**2))


def _distances(grains: Packing, room: Room) -> list[Array]:
    """Return the distances of all grains from each wall, m."""
    x, z = grains.place[:, 0], grains.place[:, 2]
    y = grains.place[:, 1] - room.pitch * grains.cavity
    if room.cylinder:
        half = 0.5 * room.length
        found = [half - np.hypot(x - half, y - half)]
    else:
        found = [x, room.length - x, y, room.width - y]
    return [*found, z, *([room.height - z] if room.lid else [])]
