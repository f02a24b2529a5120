"""Collision of a grain with a wall: eqs 13 to 19, in the frame of the wall.

Axes of Fig. 3: x and y in the wall, z its normal into the cavity. Velocities have shape (..., 3),
in m/s, relative to the wall: the caller subtracts the wall velocity, because the wall's loss has a
meaning in this frame only. A grain is a point here; a grain that rotates, or a wall that recoils,
needs `rig.theory.collision.collide`, which is the same law.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def compression_slip(slip: ArrayLike, approach: ArrayLike, friction: ArrayLike) -> Array:
    """Return the tangential speed at the end of compression, m/s: max(0, v_t - mu |v_n|) (eq 14
    corrected).

    Erratum: printed -mu z' with z' < 0 on approach, so that friction accelerates the slip; and
    without a limit at sticking.
    """
    return np.maximum(0.0, _floats(slip) - _floats(friction) * np.abs(_floats(approach)))


def slip_after(
    slip: ArrayLike, approach: ArrayLike, friction: ArrayLike, restitution: ArrayLike
) -> Array:
    """Return the tangential speed after the hit, m/s: max(0, v_t - mu (1 + e0) |v_n|) (eq 18
    corrected).

    Erratum: printed with the speed after the hit on both sides, and with the normal speed after it;
    eq 18 replaces eq 14 and is not applied in addition.
    """
    whole = 1.0 + _floats(restitution)
    return compression_slip(slip, whole * _floats(approach), friction)


def compression_impulse(mass: ArrayLike, velocity: ArrayLike, friction: ArrayLike) -> Array:
    """Return the impulse on the grain until its normal velocity equals the wall's, N s, shape (...,
    3) (eq 13 corrected).

    Erratum: the superscript c is lost in print, and the first two lines read 0 = I. Zero for a
    grain that departs.
    """
    v = _floats(velocity)
    # The wall's normal points into the cavity: a grain approaches with v_z < 0.
    approach = np.maximum(0.0, -v[..., 2])
    slip = _slip(v)
    return _impulse(mass, v, slip - compression_slip(slip, approach, friction), approach)


def recovery_impulse(
    mass: ArrayLike, velocity: ArrayLike, friction: ArrayLike, restitution: ArrayLike
) -> Array:
    """Return the impulse on the grain after the end of compression, N s, shape (..., 3) (eq 16
    corrected).

    velocity : before the hit

    Erratum: printed from the velocity before the *compression*, which counts the compression twice.
    """
    v = _floats(velocity)
    approach = np.maximum(0.0, -v[..., 2])
    slip = _slip(v)
    compressed = compression_slip(slip, approach, friction)
    lost = compressed - slip_after(slip, approach, friction, restitution)
    return _impulse(mass, v, lost, _floats(restitution) * approach)


def impulse_ratio(impulse: ArrayLike) -> Array:
    """Return the ratio of tangential to normal impulse (eq 15), zero if there is no impulse.

    It is the friction coefficient of a hit that slides, and smaller for one that sticks. Erratum:
    the paper calls it the dynamic friction coefficient, which it is in full slip only.
    """
    i = _floats(impulse)
    tangential, normal = _slip(i), np.abs(i[..., 2])
    return np.divide(tangential, normal, out=np.zeros_like(normal), where=normal > 0.0)


def bounce(velocity: ArrayLike, friction: ArrayLike, restitution: ArrayLike) -> Array:
    """Return the velocity of the grain after the hit, relative to the wall, m/s, shape (..., 3)
    (eqs 13, 16, 17 together).
    """
    # Unit mass: impulse equals velocity change.
    both = compression_impulse(1.0, velocity, friction) + recovery_impulse(
        1.0, velocity, friction, restitution
    )
    return _floats(velocity) + both


def wall_restitution(
    grain_before: ArrayLike, grain_after: ArrayLike, wall_before: ArrayLike, wall_after: ArrayLike
) -> Array:
    """Return e0 from the velocities along the normal: (V2l - V1l)/(v1l - v2l), 1 the grain, 2 the
    wall (eq 17 corrected).

    Erratum: printed with capital letters in numerator and denominator, which is -1 for any
    velocities.
    """
    return (_floats(wall_after) - _floats(grain_after)) / (
        _floats(grain_before) - _floats(wall_before)
    )


def position_after(
    position: ArrayLike,
    before: ArrayLike,
    after: ArrayLike,
    step: float,
    hit_at: ArrayLike,
    radius: ArrayLike,
) -> Array:
    """Return the position at the end of a step in which the wall z = 0 is hit at `hit_at` (s), m,
    (..., 3) (eq 19 corrected).

    The grain touches at z = r and departs from there. Erratum: z = z0 + r adds a radius at every
    hit.
    """
    at = _floats(hit_at)[..., None]
    touching = _floats(position) + _floats(before) * at
    touching[..., 2] = _floats(radius)
    return touching + _floats(after) * (step - at)


def _floats(value: ArrayLike) -> Array:
    return np.asarray(value, dtype=np.float64)


def _slip(vector: Array) -> Array:
    return np.hypot(vector[..., 0], vector[..., 1])


def _impulse(mass: ArrayLike, velocity: Array, slip_lost: Array, normal_gained: Array) -> Array:
    """Return the impulse, N s, for a loss `slip_lost` of tangential and a gain `normal_gained` of
    normal speed (m/s).
    """
    slip = _slip(velocity)
    # Friction acts against the slip: both tangential components shrink by the same fraction.
    share = np.divide(slip_lost, slip, out=np.zeros_like(slip), where=slip > 0.0)
    change = np.stack(
        (-share * velocity[..., 0], -share * velocity[..., 1], normal_gained), axis=-1
    )
    return _floats(mass)[..., None] * change
