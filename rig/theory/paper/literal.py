"""The paper's wrong equations as printed: kept to show their effect, used by no prediction.

Each function names the corrected one. `rig model --study errata` puts numbers of both side by side.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rig.theory.chain import chain_velocities
from rig.theory.friction import janssen_stress, slip_distance

Array = NDArray[np.float64]


def friction_energy(
    layers: int,
    diameter: float,
    length: float,
    width: float,
    bulk_density: float,
    gravity: float,
    grain_friction: float,
    saturation_length: float,
    wall_friction: float | None = None,
) -> float:
    """Return eq 5 with h_i = w H as printed, J: every layer at the depth of the whole bed.

    wall_friction : mu_s; if given, mu_i in the exponent is read as mu_p; None leaves mu_s there

    Corrected: `rig.theory.friction.friction_energy_per_slip`.
    """
    depth = layers * diameter
    stress = float(janssen_stress(depth, bulk_density, gravity, saturation_length))
    if wall_friction is not None:
        exponent = depth / saturation_length
        stress *= float(np.expm1(-exponent * grain_friction / wall_friction) / np.expm1(-exponent))
    return layers * grain_friction * length * width * slip_distance(diameter) * stress


def local_axes(normal: ArrayLike) -> Array:
    """Return the l, m, n axes of eq 7 as rows, shape (pairs, 3, 3).

    m is not normal to l, and both tangents are 0/0 for a vertical l. Corrected:
    `rig.theory.collision.local_axes`.
    """
    l_axis = np.asarray(normal, dtype=np.float64)
    a, b, c = l_axis[..., 0], l_axis[..., 1], l_axis[..., 2]
    s = np.hypot(a, b)
    with np.errstate(invalid="ignore", divide="ignore"):
        m_axis = np.stack((-b / s, -a / s, np.zeros_like(s)), axis=-1)
        n_axis = np.stack((-a * c / s, -b * c / s, s), axis=-1)
    return np.stack((l_axis, m_axis, n_axis), axis=-2)


def matrices(
    mass1: ArrayLike,
    mass2: ArrayLike,
    restitution: ArrayLike,
    lambda1: ArrayLike,
    lambda2: ArrayLike,
) -> tuple[Array, Array]:
    """Return A and B of eq 11 as printed, shape (pairs, 6, 6): V = A^-1 B v in local coordinates
    (l, m, n of 1, then of 2).

    Rows 1 to 3 (momentum) are right. With row 4 of B the pair still approaches after the hit; rows
    5 and 6 have the sign of friction reversed, row 5 also the wrong mass.
    """
    m1, m2, e, one, two = (
        np.asarray(value, dtype=np.float64)
        for value in np.broadcast_arrays(mass1, mass2, restitution, lambda1, lambda2)
    )
    A = np.zeros((*m1.shape, 6, 6))
    for row in range(3):
        A[..., row, row] = m1
        A[..., row, row + 3] = m2
    A[..., 3, 0], A[..., 3, 3] = -1.0, 1.0
    A[..., 4, 1], A[..., 4, 3] = m1, -one * m1
    A[..., 5, 2], A[..., 5, 3] = m1, -two * m2
    B = A.copy()
    B[..., 3, 0], B[..., 3, 3] = -e, e
    return A, B


def collide(
    mass1: ArrayLike,
    mass2: ArrayLike,
    restitution: ArrayLike,
    friction: ArrayLike,
    before: ArrayLike,
) -> Array:
    """Return the velocities after the hit by eqs 9 to 11 as printed, shape (pairs, 6), from those
    before in local coordinates.

    |lambda| = mu, its sign by eq 9 with sgn(0) = 1. Corrected: `rig.theory.collision.collide`.
    """
    v = np.asarray(before, dtype=np.float64)
    along = v[..., 3] - v[..., 0]
    mu = np.asarray(friction, dtype=np.float64)
    with np.errstate(invalid="ignore", divide="ignore"):
        lambda1 = mu * printed_sign((v[..., 4] - v[..., 1]) / along)
        lambda2 = mu * printed_sign((v[..., 5] - v[..., 2]) / along)
    A, B = matrices(mass1, mass2, restitution, lambda1, lambda2)
    return np.asarray(np.linalg.solve(A, B @ v[..., None])[..., 0], dtype=np.float64)


def printed_sign(value: ArrayLike) -> Array:
    """Return the sign by eq 9, at 0 by its first line: +1. Corrected:
    `rig.theory.collision.sign`.
    """
    return np.asarray(np.where(np.asarray(value) >= 0.0, 1.0, -1.0))


def kinetic_energy(mass1: ArrayLike, mass2: ArrayLike, velocities: ArrayLike) -> Array:
    """Return the kinetic energy of the pair in local coordinates, J, shape (pairs,)."""
    v = np.asarray(velocities, dtype=np.float64)
    m1, m2 = np.asarray(mass1, dtype=np.float64), np.asarray(mass2, dtype=np.float64)
    return np.asarray(
        0.5 * (m1 * np.sum(v[..., :3] ** 2, axis=-1) + m2 * np.sum(v[..., 3:] ** 2, axis=-1))
    )


def moved(position: float, before: float, after: float, step: float) -> float:
    """Return the position by eqs 12 and 19 a, b, m: the mean of both velocities, at whatever time
    in the step the hit was.
    """
    return position + 0.5 * (before + after) * step


def compression_slip(slip: float, normal_velocity: float, friction: float) -> float:
    """Return eq 14, m/s: with z' < 0 on approach the slip grows. Corrected:
    `rig.theory.wall.compression_slip`.
    """
    return slip - friction * normal_velocity


def slip_after(
    slip: float, normal_velocity_after: float, friction: float, restitution: float
) -> float:
    """Return eq 18, m/s; `slip` replaces the unknown on its right side: from eq 14 corrected, or
    from before the hit.

    Corrected: `rig.theory.wall.slip_after`.
    """
    return slip - friction * (1.0 + restitution) * normal_velocity_after


def wall_restitution(
    wall_before: float, wall_after: float, grain_before: float, grain_after: float
) -> float:
    """Return eq 17 with its capital letters in numerator and denominator: -1 for any velocities.

    V1l, V2l are after the hit; the velocities before it do not enter. Corrected:
    `rig.theory.wall.wall_restitution`.
    """
    del wall_before, grain_before
    return (wall_after - grain_after) / (grain_after - wall_after)


def height_after(height: float, radius: float, hits: int) -> float:
    """Return eq 19c applied at each of `hits` hits, m: z = z0 + r. Corrected:
    `rig.theory.wall.position_after`.
    """
    return height + hits * radius


def first_wave_loss(masses: ArrayLike, restitution: float, first_velocity: float) -> float:
    """Return eq 23 as printed, J: each grain's own energy drop in the hit in which it is the
    striker, summed.

    Grain n has v_n before it strikes and (m - e m')/(m + m') v_n after; the energy gained by the
    struck grain is not credited. Corrected: `rig.theory.chain.first_wave_loss`.
    """
    m = np.asarray(masses, dtype=np.float64)
    struck = chain_velocities(m, restitution, first_velocity)[:-1]
    kept = (m[:-1] - restitution * m[1:]) / (m[:-1] + m[1:]) * struck
    return float(np.sum(0.5 * m[:-1] * (struck**2 - kept**2)))
