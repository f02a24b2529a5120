"""Forces of all contacts: pairs and walls; the work that each kind does.

The step is that of velocity Verlet: places are those of step n + 1, velocities those half a step
before. The work over a step is that of the mean of the old and the new force on the velocity
between them, which makes the sum of all energies constant to rounding: with the kinetic energy
taken as m v(n - 1/2) v(n + 1/2)/2, nothing is lost between the accounts.

A step of 0 s gives the forces of grains as they lie: springs are relaxed, no work is done.
"""

import math

import numpy as np

from daq.compiled import njit
from rig.kernels.grains.arrays import (
    FX,
    FY,
    FZ,
    GHOSTS,
    INVERSE_MASS,
    PAIR_FRICTION,
    PAIR_NORMAL,
    RADIUS,
    SHELL,
    SPLIT,
    SX,
    SY,
    SZ,
    WALL_ENTRIES,
    WALL_FRICTION,
    WALL_NORMAL,
    WALL_SPLIT,
    WALL_X,
    WALL_Y,
    WALL_Z,
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
from rig.kernels.grains.walls import wall_normal

_STILL = np.zeros(8)
"""Motion of a wall in the frame of the box."""


@njit(cache=True, nogil=True)
def pair_forces(
    slab: int, grains: GrainArrays, lists: Lists, ghosts: Ghosts, law: Law, dt: float, sums: Floats
) -> None:
    """Add the forces between the grains whose first grain lies in `slab` to `grains.load`.

    Forces of slab 0 on grains of slab 1 go to `ghosts`, which slab 1 adds itself.
    """
    place, motion, load = grains.place, grains.motion, grains.load
    first, other, touching, memory = lists.first, lists.other, lists.touching, lists.memory
    split = lists.sizes[SPLIT]
    begin, end = (0, split) if slab == 0 else (split, place.shape[0])
    keep = split if slab == 0 else place.shape[0]
    rolls = law.pair_rolling > 0.0
    normal_work, friction_work, crossing = 0.0, 0.0, 0
    for i in range(begin, end):
        x, y, z, radius = place[i, X], place[i, Y], place[i, Z], place[i, RADIUS]
        u, v, w = motion[i, U], motion[i, V], motion[i, W]
        p, q, r = radius * motion[i, P], radius * motion[i, Q], radius * motion[i, R]
        fx, fy, fz, mx, my, mz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for k in range(first[i], first[i + 1]):
            j = other[k]
            dx, dy, dz = x - place[j, X], y - place[j, Y], z - place[j, Z]
            reach = radius + place[j, RADIUS]
            square = dx * dx + dy * dy + dz * dz
            apart = square >= reach * reach
            if apart and not touching[k]:
                continue
            distance = math.sqrt(square)
            inverse = 1.0 / distance
            dx, dy, dz = dx * inverse, dy * inverse, dz * inverse
            ru, rv, rw = u - motion[j, U], v - motion[j, V], w - motion[j, W]
            closing = ru * dx + rv * dy + rw * dz
            other_radius = place[j, RADIUS]
            sp = p + other_radius * motion[j, P]
            sq = q + other_radius * motion[j, Q]
            sr = r + other_radius * motion[j, R]
            ru, rv, rw = ru - closing * dx, rv - closing * dy, rw - closing * dz
            # The torque of the old force had the old normal, n' = n - turn r - less n with the
            # tangential velocity r: what its work differs by from that with today's.
            turn, less = _turned(distance - dt * closing, dt, ru * ru + rv * rv + rw * rw)
            ax, ay, az = memory[k, FX], memory[k, FY], memory[k, FZ]
            bx, by, bz = sq * dz - sr * dy, sr * dx - sp * dz, sp * dy - sq * dx
            qx = turn * (sq * rw - sr * rv) + less * bx
            qy = turn * (sr * ru - sp * rw) + less * by
            qz = turn * (sp * rv - sq * ru) + less * bz
            # Velocity of i's surface against j's, tangential part.
            ru, rv, rw = ru - bx, rv - by, rw - bz
            if apart:
                # The old force acted over half of the step in which the two parted.
                normal_work += (ax * dx + ay * dy + az * dz) * closing
                friction_work += ax * (ru + qx) + ay * (rv + qy) + az * (rw + qz)
                if rolls:
                    friction_work += _old_power(lists.rolling[k], motion[i], motion[j])
                touching[k] = 0
                continue
            overlap = reach - distance
            mass = 1.0 / (motion[i, INVERSE_MASS] + motion[j, INVERSE_MASS])
            if law.hertz:
                root = math.sqrt(radius * other_radius / reach * overlap)
                stiffness, shear = law.pair_stiffness * root, law.pair_shear * root
            else:
                stiffness, shear = law.pair_stiffness, law.pair_shear
            dashpot = law.pair_damping * math.sqrt(stiffness * mass)
            push = stiffness * overlap - dashpot * closing
            push = max(push, 0.0)
            dashpot *= law.shear_damping
            if touching[k]:
                sx = memory[k, SX] + ru * dt
                sy = memory[k, SY] + rv * dt
                sz = memory[k, SZ] + rw * dt
                along = sx * dx + sy * dy + sz * dz
                sx, sy, sz = sx - along * dx, sy - along * dy, sz - along * dz
            else:
                touching[k] = 1
                ax, ay, az = 0.0, 0.0, 0.0
                sx, sy, sz = ru * dt, rv * dt, rw * dt
                if rolls:
                    lists.rolling[k] = 0.0
            tx = -(shear * sx + dashpot * ru)
            ty = -(shear * sy + dashpot * rv)
            tz = -(shear * sz + dashpot * rw)
            pull = tx * tx + ty * ty + tz * tz
            cap = law.pair_friction * push
            if pull > cap * cap:
                share = cap / math.sqrt(pull)
                tx, ty, tz = share * tx, share * ty, share * tz
                # A dashpot that alone reaches the cap leaves nothing to the spring. A Hertz spring,
                # soft at first touch, would be stretched backwards by it without bound; with linear
                # springs the backward stretch is bounded and does no harm.
                if law.hertz and dashpot * dashpot * (ru * ru + rv * rv + rw * rw) > cap * cap:
                    sx, sy, sz = 0.0, 0.0, 0.0
                else:
                    sx = -(tx + dashpot * ru) / shear
                    sy = -(ty + dashpot * rv) / shear
                    sz = -(tz + dashpot * rw) / shear
            normal_work += (ax * dx + ay * dy + az * dz + push) * closing
            friction_work += (ax + tx) * ru + (ay + ty) * rv + (az + tz) * rw
            friction_work += ax * qx + ay * qy + az * qz
            # Torque on both, over the radius of each.
            px = ty * dz - tz * dy
            py = tz * dx - tx * dz
            pz = tx * dy - ty * dx
            tx, ty, tz = tx + push * dx, ty + push * dy, tz + push * dz
            memory[k, SX], memory[k, SY], memory[k, SZ] = sx, sy, sz
            memory[k, FX], memory[k, FY], memory[k, FZ] = tx, ty, tz
            fx, fy, fz = fx + tx, fy + ty, fz + tz
            mx, my, mz = mx + radius * px, my + radius * py, mz + radius * pz
            px, py, pz = other_radius * px, other_radius * py, other_radius * pz
            if rolls:
                lx, ly, lz, lost = _rolling(
                    lists.rolling[k],
                    motion[i],
                    motion[j],
                    dx,
                    dy,
                    dz,
                    radius * other_radius / reach,
                    law.pair_rolling * push,
                    shear,
                    dashpot,
                    dt,
                )
                friction_work += lost
                mx, my, mz = mx + lx, my + ly, mz + lz
                px, py, pz = px - lx, py - ly, pz - lz
            if j < keep:
                load[j, 0] -= tx
                load[j, 1] -= ty
                load[j, 2] -= tz
                load[j, 3] += px
                load[j, 4] += py
                load[j, 5] += pz
            else:
                ghosts.grain[crossing] = j
                ghosts.load[crossing, 0] = -tx
                ghosts.load[crossing, 1] = -ty
                ghosts.load[crossing, 2] = -tz
                ghosts.load[crossing, 3] = px
                ghosts.load[crossing, 4] = py
                ghosts.load[crossing, 5] = pz
                crossing += 1
        load[i, 0] += fx
        load[i, 1] += fy
        load[i, 2] += fz
        load[i, 3] += mx
        load[i, 4] += my
        load[i, 5] += mz
    sums[slab, PAIR_NORMAL] += 0.5 * dt * normal_work
    sums[slab, PAIR_FRICTION] += 0.5 * dt * friction_work
    if slab == 0:
        sums[0, GHOSTS] = crossing


@njit(cache=True, nogil=True)
def _rolling(
    memory: Floats,
    one: Floats,
    two: Floats,
    nx: float,
    ny: float,
    nz: float,
    radius: float,
    cap: float,
    stiffness: float,
    dashpot: float,
    dt: float,
) -> tuple[float, float, float, float]:
    """Return the rolling torque on grain `one` (N m) and the power of the old and new one (W).

    A spring, dashpot and slider for the rolling displacement, as the tangential law has them for
    the sliding one; `cap` is the largest rolling force, N. Updates `memory`: stretch, m, and torque
    on `one`, N m, which keeps the work of the old torque exact however the normal turns.
    """
    p, q, r = one[P] - two[P], one[Q] - two[Q], one[R] - two[R]
    u = radius * (q * nz - r * ny)
    v = radius * (r * nx - p * nz)
    w = radius * (p * ny - q * nx)
    sx, sy, sz = memory[SX] + u * dt, memory[SY] + v * dt, memory[SZ] + w * dt
    along = sx * nx + sy * ny + sz * nz
    sx, sy, sz = sx - along * nx, sy - along * ny, sz - along * nz
    fx = -(stiffness * sx + dashpot * u)
    fy = -(stiffness * sy + dashpot * v)
    fz = -(stiffness * sz + dashpot * w)
    force = math.sqrt(fx * fx + fy * fy + fz * fz)
    if force > cap:
        share = cap / force
        fx, fy, fz = share * fx, share * fy, share * fz
        sx = -(fx + dashpot * u) / stiffness
        sy = -(fy + dashpot * v) / stiffness
        sz = -(fz + dashpot * w) / stiffness
    lx = radius * (ny * fz - nz * fy)
    ly = radius * (nz * fx - nx * fz)
    lz = radius * (nx * fy - ny * fx)
    power = (memory[FX] + lx) * p + (memory[FY] + ly) * q + (memory[FZ] + lz) * r
    memory[SX], memory[SY], memory[SZ] = sx, sy, sz
    memory[FX], memory[FY], memory[FZ] = lx, ly, lz
    return lx, ly, lz, power


@njit(cache=True, nogil=True)
def _old_power(memory: Floats, one: Floats, two: Floats) -> float:
    """Return the power of the rolling torque of the last step, W."""
    return float(
        memory[FX] * (one[P] - two[P])
        + memory[FY] * (one[Q] - two[Q])
        + memory[FZ] * (one[R] - two[R])
    )


@njit(cache=True, nogil=True)
def _turned(along: float, dt: float, square: float) -> tuple[float, float]:
    """Return by what the normal of the last step differs: n' = n - turn r - less n.

    along : the old line of centres along today's normal n, m; square : of the tangential velocity
    r, m^2/s^2. A line that turns by t = dt |r|/along in a step is longer by sqrt(1 + t^2), here to
    the order of t^6: 1e-12 for 10 m/s at a step of 5 us and balls of 5 mm.
    """
    turn = dt / along
    square *= turn * turn
    less = square * (0.5 - 0.375 * square)
    return turn * (1.0 - less), less


@njit(cache=True, nogil=True)
def wall_forces(
    slab: int, grains: GrainArrays, lists: Lists, law: Law, room: Room, dt: float, sums: Floats
) -> None:
    """Add the forces of the walls on the grains of `slab`, and their sums."""
    place, motion, load = grains.place, grains.motion, grains.load
    touching, memory = lists.wall_touching, lists.wall_memory
    split, entries = lists.sizes[WALL_SPLIT], lists.sizes[WALL_ENTRIES]
    begin, end = (0, split) if slab == 0 else (split, entries)
    rolls = law.wall_rolling > 0.0
    normal_work, friction_work = 0.0, 0.0
    wx, wy, wz = 0.0, 0.0, 0.0
    for k in range(begin, end):
        i, wall = lists.wall_grain[k], lists.wall[k]
        radius = place[i, RADIUS]
        y = place[i, Y] - room.pitch * grains.cavity[i]
        dx, dy, dz, distance = wall_normal(wall, place[i, X], y, place[i, Z], room)
        apart = distance >= radius
        if apart and not touching[k]:
            continue
        ru, rv, rw = motion[i, U], motion[i, V], motion[i, W]
        closing = ru * dx + rv * dy + rw * dz
        sp, sq, sr = radius * motion[i, P], radius * motion[i, Q], radius * motion[i, R]
        ru, rv, rw = ru - closing * dx, rv - closing * dy, rw - closing * dz
        ax, ay, az = memory[k, FX], memory[k, FY], memory[k, FZ]
        if wall == SHELL and touching[k]:
            # The torque of the old force had the old normal, here (ex, ey) more than today's.
            ox, oy, _, _ = wall_normal(
                wall, place[i, X] - dt * motion[i, U], y - dt * motion[i, V], place[i, Z], room
            )
            ex, ey = ox - dx, oy - dy
            friction_work += sp * -az * ey + sq * az * ex + sr * (ax * ey - ay * ex)
        ru = ru - (sq * dz - sr * dy)
        rv = rv - (sr * dx - sp * dz)
        rw = rw - (sp * dy - sq * dx)
        if apart:
            normal_work += (ax * dx + ay * dy + az * dz) * closing
            friction_work += ax * ru + ay * rv + az * rw
            if rolls:
                friction_work += _old_power(lists.wall_rolling[k], motion[i], _STILL)
            touching[k] = 0
            continue
        overlap = radius - distance
        mass = 1.0 / motion[i, INVERSE_MASS]
        if law.hertz:
            root = math.sqrt(radius * overlap)
            stiffness, shear = law.wall_stiffness * root, law.wall_shear * root
        else:
            stiffness, shear = law.wall_stiffness, law.wall_shear
        dashpot = law.wall_damping * math.sqrt(stiffness * mass)
        push = max(stiffness * overlap - dashpot * closing, 0.0)
        dashpot *= law.shear_damping
        if touching[k]:
            sx = memory[k, SX] + ru * dt
            sy = memory[k, SY] + rv * dt
            sz = memory[k, SZ] + rw * dt
            along = sx * dx + sy * dy + sz * dz
            sx, sy, sz = sx - along * dx, sy - along * dy, sz - along * dz
        else:
            touching[k] = 1
            ax, ay, az = 0.0, 0.0, 0.0
            sx, sy, sz = ru * dt, rv * dt, rw * dt
            if rolls:
                lists.wall_rolling[k] = 0.0
        tx = -(shear * sx + dashpot * ru)
        ty = -(shear * sy + dashpot * rv)
        tz = -(shear * sz + dashpot * rw)
        pull = tx * tx + ty * ty + tz * tz
        cap = law.wall_friction * push
        if pull > cap * cap:
            share = cap / math.sqrt(pull)
            tx, ty, tz = share * tx, share * ty, share * tz
            # A dashpot that alone reaches the cap leaves nothing to the spring. A Hertz spring,
            # soft at first touch, would be stretched backwards by it without bound; with linear
            # springs the backward stretch is bounded and does no harm.
            if law.hertz and dashpot * dashpot * (ru * ru + rv * rv + rw * rw) > cap * cap:
                sx, sy, sz = 0.0, 0.0, 0.0
            else:
                sx = -(tx + dashpot * ru) / shear
                sy = -(ty + dashpot * rv) / shear
                sz = -(tz + dashpot * rw) / shear
        normal_work += (ax * dx + ay * dy + az * dz + push) * closing
        friction_work += (ax + tx) * ru + (ay + ty) * rv + (az + tz) * rw
        load[i, 3] += radius * (ty * dz - tz * dy)
        load[i, 4] += radius * (tz * dx - tx * dz)
        load[i, 5] += radius * (tx * dy - ty * dx)
        tx, ty, tz = tx + push * dx, ty + push * dy, tz + push * dz
        memory[k, SX], memory[k, SY], memory[k, SZ] = sx, sy, sz
        memory[k, FX], memory[k, FY], memory[k, FZ] = tx, ty, tz
        load[i, 0] += tx
        load[i, 1] += ty
        load[i, 2] += tz
        wx, wy, wz = wx + tx, wy + ty, wz + tz
        if rolls:
            lx, ly, lz, lost = _rolling(
                lists.wall_rolling[k],
                motion[i],
                _STILL,
                dx,
                dy,
                dz,
                radius,
                law.wall_rolling * push,
                shear,
                dashpot,
                dt,
            )
            friction_work += lost
            load[i, 3] += lx
            load[i, 4] += ly
            load[i, 5] += lz
    sums[slab, WALL_NORMAL] += 0.5 * dt * normal_work
    sums[slab, WALL_FRICTION] += 0.5 * dt * friction_work
    sums[slab, WALL_X], sums[slab, WALL_Y], sums[slab, WALL_Z] = wx, wy, wz
