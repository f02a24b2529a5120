"""The arrays that the compiled loops share: grains, their neighbours, contact law, box, sums."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Bytes = NDArray[np.uint8]

X, Y, Z, RADIUS = range(4)
U, V, W, P, Q, R, INVERSE_MASS, INVERSE_INERTIA = range(8)
SX, SY, SZ, FX, FY, FZ = range(6)
"""Columns of a contact: stretch of its tangential spring (m), force at the last step (N)."""

SLABS = 2
"""Parts of the grains, always two whatever the number of threads, so that sums keep their order."""

END_LOW, END_HIGH, SIDE_LOW, SIDE_HIGH, FLOOR, LID, SHELL = range(7)
"""Walls: x = 0 and x = L, y = 0 and y = W, z = 0 and z = H; the shell of a cylinder along z."""

PAIR_NORMAL, PAIR_FRICTION, WALL_NORMAL, WALL_FRICTION = range(4)
WALL_X, WALL_Y, WALL_Z, FASTEST, GHOSTS = range(4, 9)
SUMS = 16
"""Columns of the sums of a slab: work of the contact forces by kind (J, since the last reset), wall
force on the grains (N, this step), largest speed squared (m^2/s^2), contacts across the slabs.
"""

WORK_OF_BOX, IMPULSE_X, IMPULSE_Y, IMPULSE_Z, TRAVEL, REBUILDS, FAULT = range(7)
TOTALS = 16
"""Columns of the totals: work of the box on the grains (J), impulse of the walls (N s), bound on
the distance that a grain has moved since the lists were made (m), number of lists made, fault.
"""
LISTS_FULL, FLEW_AWAY = 1, 2
"""Faults: more neighbours than there is room for; a grain left the box or is not a number."""


class GrainArrays(NamedTuple):
    """State of the grains, sorted by cell; SI units, in the frame of the box.

    place : x, y, z, radius, shape (n, 4)
    motion : velocity and angular velocity half a step ago, 1/mass, 1/inertia, shape (n, 8)
    load : force and torque now (two columns are free), shape (n, 8)
    ident : number of each grain in the order of the packing, shape (n,)
    cavity : number of the cavity that each grain is in, shape (n,)
    """

    place: Floats
    motion: Floats
    load: Floats
    ident: Ints
    cavity: Ints


class Lists(NamedTuple):
    """Neighbours of each grain and what their contacts remember.

    first : place of a grain's first neighbour in `other`, shape (n + 1,)
    other : neighbours, each with a larger index than the grain, shape (room,)
    touching : 1 where the two touch, shape (room,)
    memory : of each contact (`SX` ...), shape (room, 6)
    rolling : the same of the rolling spring, shape (room, 6), or (0, 6) without rolling friction
    wall_grain, wall, wall_touching, wall_memory, wall_rolling : the same for grains near a wall
    made_at : place of each grain when the lists were made, m, shape (n, 3)
    sizes : neighbours, wall entries, first grain of slab 1, first wall entry of slab 1
    """

    first: Ints
    other: Ints
    touching: Bytes
    memory: Floats
    rolling: Floats
    wall_grain: Ints
    wall: Bytes
    wall_touching: Bytes
    wall_memory: Floats
    wall_rolling: Floats
    made_at: Floats
    sizes: NDArray[np.int64]


NEIGHBOURS, WALL_ENTRIES, SPLIT, WALL_SPLIT = range(4)


class Ghosts(NamedTuple):
    """Forces of slab 0 on grains of slab 1: which grain, shape (room,), and load, shape (room, 6)."""

    grain: Ints
    load: Floats


class Law(NamedTuple):
    """The contact law. SI units.

    hertz : 0 for linear springs, 1 for Hertz-Mindlin contacts
    pair_stiffness, wall_stiffness : N/m, or 4/3 E* (Pa) with Hertz
    pair_shear, wall_shear : tangential stiffness, N/m, or 8 G* (Pa) with Hertz
    pair_damping, wall_damping : dashpot over sqrt(stiffness x reduced mass): twice the damping
        ratio, F = damping sqrt(k m) v
    shear_damping : tangential dashpot over the normal one
    pair_friction, wall_friction : Coulomb coefficients
    pair_rolling, wall_rolling : coefficients of rolling friction, 0 for none
    """

    hertz: int
    pair_stiffness: float
    wall_stiffness: float
    pair_shear: float
    wall_shear: float
    pair_damping: float
    wall_damping: float
    shear_damping: float
    pair_friction: float
    wall_friction: float
    pair_rolling: float
    wall_rolling: float


class Room(NamedTuple):
    """The cavities and what acts in them; SI units.

    length, width, height : inner sizes; a cylinder has its diameter twice
    cylinder : 1 for a circular cross-section with its axis along z
    lid : 1 if there is a wall at z = height
    pitch : distance along y between the places of two cavities, more than any grain reaches
    cavities : number of equal cavities
    gravity_x, gravity_y, gravity_z : m/s^2
    axis : 0, 1, 2: the direction in which the box moves
    """

    length: float
    width: float
    height: float
    cylinder: int
    lid: int
    pitch: float
    cavities: int
    gravity_x: float
    gravity_y: float
    gravity_z: float
    axis: int


class Cells(NamedTuple):
    """Cells for finding neighbours.

    reach : distance beyond touching within which two grains are neighbours, m
    cell : edge of a cell, m
    nx, ny, nz : cells along each direction
    head : first grain of each cell, shape (cells + 1,)
    cell_of, order : cell of each grain, and the grains sorted by cell, shape (n,)
    """

    reach: float
    cell: float
    nx: int
    ny: int
    nz: int
    head: Ints
    cell_of: Ints
    order: Ints
