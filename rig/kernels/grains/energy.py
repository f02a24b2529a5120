"""Energy of the grains at a step: kinetic and rotational, of weight, and elastic in each contact."""

import math

import numpy as np

from daq.compiled import njit
from rig.kernels.grains.arrays import (
    INVERSE_INERTIA,
    INVERSE_MASS,
    RADIUS,
    SX,
    SY,
    SZ,
    WALL_ENTRIES,
    Floats,
    GrainArrays,
    Law,
    Lists,
    P,
    Room,
    U,
    X,
    Y,
    Z,
)
from rig.kernels.grains.walls import wall_normal

KINETIC, ROTATION, WEIGHT = range(3)
"""Columns of `energies`."""


@njit(cache=True, nogil=True)
def energies(grains: GrainArrays, room: Room, before: float, dt: float) -> Floats:
    """Return kinetic energy in the frame of the laboratory, rotational energy, energy of weight, J.

    before : velocity of the box half a step before this step, m/s

    The kinetic energy of a step is m v(n - 1/2) v(n + 1/2)/2: with it the account of velocity
    Verlet closes to rounding.
    """
    found = np.zeros(3)
    place, motion, load = grains.place, grains.motion, grains.load
    box = np.zeros(3)
    box[room.axis] = 1.0
    gravity = np.array([room.gravity_x, room.gravity_y, room.gravity_z])
    for i in range(place.shape[0]):
        mass, inertia = 1.0 / motion[i, INVERSE_MASS], 1.0 / motion[i, INVERSE_INERTIA]
        for k in range(3):
            # In the laboratory the box's own change of velocity is no force.
            old = motion[i, U + k] + before * box[k]
            new = old + dt * (load[i, k] / mass + gravity[k])
            found[KINETIC] += 0.5 * mass * old * new
            old = motion[i, P + k]
            new = old + dt * load[i, 3 + k] / inertia
            found[ROTATION] += 0.5 * inertia * old * new
            found[WEIGHT] -= mass * gravity[k] * place[i, k]
    return found


@njit(cache=True, nogil=True)
def _stored(
    stretch: Floats, overlap: float, radius: float, hertz: int, stiffness: float, shear: float
) -> tuple[float, float]:
    """Return the elastic energy of a contact along its normal and in its tangential spring, J."""
    square = stretch[SX] ** 2 + stretch[SY] ** 2 + stretch[SZ] ** 2
    if hertz:
        root = math.sqrt(radius * overlap)
        return 0.4 * stiffness * root * overlap**2, 0.5 * shear * root * square
    return 0.5 * stiffness * overlap**2, 0.5 * shear * square


@njit(cache=True, nogil=True)
def elastic(grains: GrainArrays, lists: Lists, law: Law, room: Room) -> Floats:
    """Return the elastic energy in contacts by kind, J: pairs normal and tangential, walls too.

    A rolling spring counts with the tangential one.
    """
    found = np.zeros(4)
    place = grains.place
    for i in range(place.shape[0]):
        for k in range(lists.first[i], lists.first[i + 1]):
            if not lists.touching[k]:
                continue
            j = lists.other[k]
            dx = place[i, X] - place[j, X]
            dy = place[i, Y] - place[j, Y]
            dz = place[i, Z] - place[j, Z]
            reach = place[i, RADIUS] + place[j, RADIUS]
            overlap = reach - math.sqrt(dx * dx + dy * dy + dz * dz)
            radius = place[i, RADIUS] * place[j, RADIUS] / reach
            stiffness, shear = law.pair_stiffness, law.pair_shear
            normal, tangential = _stored(
                lists.memory[k], overlap, radius, law.hertz, stiffness, shear
            )
            found[0] += normal
            found[1] += tangential
            if law.pair_rolling > 0.0:
                found[1] += _stored(lists.rolling[k], overlap, radius, law.hertz, 0.0, shear)[1]
    for k in range(lists.sizes[WALL_ENTRIES]):
        if not lists.wall_touching[k]:
            continue
        i = lists.wall_grain[k]
        y = place[i, Y] - room.pitch * grains.cavity[i]
        overlap = (
            place[i, RADIUS] - wall_normal(lists.wall[k], place[i, X], y, place[i, Z], room)[3]
        )
        radius = place[i, RADIUS]
        stiffness, shear = law.wall_stiffness, law.wall_shear
        normal, tangential = _stored(
            lists.wall_memory[k], overlap, radius, law.hertz, stiffness, shear
        )
        found[2] += normal
        found[3] += tangential
        if law.wall_rolling > 0.0:
            found[3] += _stored(lists.wall_rolling[k], overlap, radius, law.hertz, 0.0, shear)[1]
    return found
