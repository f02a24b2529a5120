"""The time loop of the grains in a box that follows a given motion."""

import math

import numpy as np
from numpy.typing import NDArray

from daq.compiled import njit
from rig.kernels.grains.arrays import (
    FASTEST,
    FAULT,
    GHOSTS,
    IMPULSE_X,
    INVERSE_INERTIA,
    INVERSE_MASS,
    SLABS,
    SPLIT,
    TRAVEL,
    WALL_X,
    WORK_OF_BOX,
    Cells,
    Floats,
    Ghosts,
    GrainArrays,
    Law,
    Lists,
    P,
    Q,
    R,
    Room,
    U,
    V,
    W,
    X,
    Y,
    Z,
)
from rig.kernels.grains.barrier import wait_for_all
from rig.kernels.grains.contacts import pair_forces, wall_forces
from rig.kernels.grains.neighbours import make_lists


@njit(cache=True, nogil=True)
def add_ghosts(grains: GrainArrays, ghosts: Ghosts, crossing: int) -> None:
    """Add the forces that slab 0 computed for grains of slab 1."""
    load = grains.load
    for k in range(crossing):
        j = ghosts.grain[k]
        for column in range(6):
            load[j, column] += ghosts.load[k, column]


@njit(cache=True, nogil=True)
def move(
    slab: int, grains: GrainArrays, lists: Lists, room: Room, dv: float, dt: float, sums: Floats
) -> None:
    """Kick and drift the grains of a slab over one step and clear their loads.

    dv : change of the box's velocity along its axis over the step, m/s
    """
    place, motion, load = grains.place, grains.motion, grains.load
    split = lists.sizes[SPLIT]
    begin, end = (0, split) if slab == 0 else (split, place.shape[0])
    ax, ay, az = room.gravity_x * dt, room.gravity_y * dt, room.gravity_z * dt
    if room.axis == 0:
        ax -= dv
    elif room.axis == 1:
        ay -= dv
    else:
        az -= dv
    fastest = 0.0
    for i in range(begin, end):
        kick = dt * motion[i, INVERSE_MASS]
        u = motion[i, U] + kick * load[i, 0] + ax
        v = motion[i, V] + kick * load[i, 1] + ay
        w = motion[i, W] + kick * load[i, 2] + az
        motion[i, U], motion[i, V], motion[i, W] = u, v, w
        kick = dt * motion[i, INVERSE_INERTIA]
        motion[i, P] += kick * load[i, 3]
        motion[i, Q] += kick * load[i, 4]
        motion[i, R] += kick * load[i, 5]
        place[i, X] += dt * u
        place[i, Y] += dt * v
        place[i, Z] += dt * w
        for column in range(6):
            load[i, column] = 0.0
        fastest = max(fastest, u * u + v * v + w * w)
    sums[slab, FASTEST] = fastest


@njit(cache=True, nogil=True)
def _farthest(grains: GrainArrays, lists: Lists) -> float:
    """Return the largest distance of a grain from its place when the lists were made, m."""
    place, before, most = grains.place, lists.made_at, 0.0
    for i in range(place.shape[0]):
        dx = place[i, X] - before[i, X]
        dy = place[i, Y] - before[i, Y]
        dz = place[i, Z] - before[i, Z]
        most = max(most, dx * dx + dy * dy + dz * dz)
    return math.sqrt(most)


@njit(cache=True, nogil=True)
def begin(
    grains: GrainArrays,
    lists: Lists,
    ghosts: Ghosts,
    old_grains: GrainArrays,
    old: Lists,
    grid: Cells,
    law: Law,
    room: Room,
    sums: Floats,
    totals: Floats,
) -> None:
    """Make the lists and the forces of grains as they lie, with relaxed tangential springs.

    `totals[FAULT]` is set where they cannot be followed.
    """
    make_lists(grains, lists, old_grains, old, grid, room, totals)
    if totals[FAULT] > 0.0:
        return
    for slab in range(SLABS):
        pair_forces(slab, grains, lists, ghosts, law, 0.0, sums)
        wall_forces(slab, grains, lists, law, room, 0.0, sums)
    add_ghosts(grains, ghosts, int(sums[0, GHOSTS]))
    sums[0, GHOSTS] = 0.0


@njit(cache=True, nogil=True)
def advance(
    thread: int,
    threads: int,
    flags: NDArray[np.int64],
    grains: GrainArrays,
    lists: Lists,
    ghosts: Ghosts,
    old_grains: GrainArrays,
    old: Lists,
    grid: Cells,
    law: Law,
    room: Room,
    velocity: Floats,
    dt: float,
    sums: Floats,
    totals: Floats,
    impulse: Floats,
) -> None:
    """Advance by `velocity.size - 1` steps; every thread calls it with the same arrays.

    velocity : of the box along its axis half a step before and after each step, m/s,
        shape (steps + 1,)
    impulse : filled with the impulse of the walls on the grains along the axis, N s: entry n is the
        sum up to half a step before step n, shape (steps + 1,)

    The lists are made anew in the first step, so that a run that starts here from a checkpoint
    takes the same way. `totals[FAULT]` is set where the run cannot go on.
    """
    steps = velocity.size - 1
    number = 0
    mine, stride = (thread, threads) if threads > 1 else (0, 1)
    for step in range(steps):
        # Forces of this step are known: kick and drift.
        for slab in range(mine, SLABS, stride):
            if slab == 1:
                add_ghosts(grains, ghosts, int(sums[0, GHOSTS]))
            move(slab, grains, lists, room, velocity[step + 1] - velocity[step], dt, sums)
        number += 1
        wait_for_all(flags, thread, threads, number)
        if thread == 0:
            column = WALL_X + room.axis
            force = sums[0, column] + sums[1, column]
            impulse[step + 1] = impulse[step] + dt * force
            # The mean of the forces at both ends of a step acts over it: half of the first force
            # belongs to the stretch before.
            mean = velocity[step + 1] + (velocity[step] if step > 0 else 0.0)
            totals[WORK_OF_BOX] += 0.5 * dt * force * mean
            for k in range(3):
                totals[IMPULSE_X + k] += dt * (sums[0, WALL_X + k] + sums[1, WALL_X + k])
            totals[TRAVEL] += dt * math.sqrt(max(sums[0, FASTEST], sums[1, FASTEST]))
            if not totals[TRAVEL] <= 0.5 * grid.reach or step == 0:
                totals[TRAVEL] = _farthest(grains, lists)
                if not totals[TRAVEL] <= 0.5 * grid.reach or step == 0:
                    make_lists(grains, lists, old_grains, old, grid, room, totals)
        number += 1
        wait_for_all(flags, thread, threads, number)
        if totals[FAULT] > 0.0:
            return
        for slab in range(mine, SLABS, stride):
            pair_forces(slab, grains, lists, ghosts, law, dt, sums)
            wall_forces(slab, grains, lists, law, room, dt, sums)
        number += 1
        wait_for_all(flags, thread, threads, number)
    if thread == threads - 1:
        add_ghosts(grains, ghosts, int(sums[0, GHOSTS]))
    number += 1
    wait_for_all(flags, thread, threads, number)
    if thread == 0:
        sums[0, GHOSTS] = 0.0
        force = sums[0, WALL_X + room.axis] + sums[1, WALL_X + room.axis]
        totals[WORK_OF_BOX] += 0.5 * dt * force * velocity[steps]
