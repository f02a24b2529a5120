"""Collision of a grain with a wall: eqs 13 to 19, in the frame of the wall.

Axes of Fig. 3: x and y in the wall, z its normal into the cavity. Velocities have shape (..., 3), in m/s, relative to
the wall: subtract the wall's own first, and its energy means nothing in any other frame. A grain is a point here; one
that turns, or a wall that gives way, goes through `rig.theory.collision.collide`, which is the same law.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def compression_slip(slip: ArrayLike, approach: ArrayLike, friction: ArrayLike) -> Array:
    """Tangential speed at the end of compression, m/s: max(0, v_t - mu |v_n|) (eq 14 corrected).

    Erratum: printed -mu z' with z' < 0 on approach, so that friction speeds the slip up; and no end at sticking.
    """
    return np.maximum(0.0, _floats(slip) - _floats(friction) * np.abs(_floats(approach)))


def slip_after(slip: ArrayLike, approach: ArrayLike, friction: ArrayLike, restitution: ArrayLike) -> Array:
    """Tangential speed after the hit, m/s: max(0, v_t - mu (1 + e0) |v_n|) (eq 18 corrected).

    Erratum: printed with the speed after the hit on both sides and with the normal speed after it; it stands in the
    place of eq 14 and is not applied on top of it.
    """
    whole = 1.0 + _floats(restitution)
    return compression_slip(slip, whole * _floats(approach), friction)


def compression_impulse(mass: ArrayLike, velocity: ArrayLike, friction: ArrayLike) -> Array:
    """Impulse on the grain until its normal velocity is the wall's, N s, shape (..., 3) (eq 13 corrected).

    Erratum: the superscript c is lost in print, and the first two lines read 0 = I. Zero for a grain that departs.
    """
    v = _floats(velocity)
    approach = np.maximum(0.0, -v[..., 2])
    slip = _slip(v)
    return _impulse(mass, v, slip - compression_slip(slip, approach, friction), approach)


def recovery_impulse(mass: ArrayLike, velocity: ArrayLike, friction: ArrayLike, restitution: ArrayLike) -> Array:
    """Impulse on the grain from the end of compression on, N s, shape (..., 3) (eq 16 corrected).

    velocity : before the hit. Erratum: printed from the velocity before the *compression*, which counts that twice.
    """
    v = _floats(velocity)
    approach = np.maximum(0.0, -v[..., 2])
    slip = _slip(v)
    compressed = compression_slip(slip, approach, friction)
    lost = compressed - slip_after(slip, approach, friction, restitution)
    return _impulse(mass, v, lost, _floats(restitution) * approach)


def impulse_ratio(impulse: ArrayLike) -> Array:
    """Tangential over normal impulse (eq 15): the friction coefficient of a hit that slides, less of one that sticks.

    Zero where there is no impulse. Erratum: the paper calls it the dynamic friction coefficient, which it is in full
    slip only.
    """
    i = _floats(impulse)
    tangential, normal = _slip(i), np.abs(i[..., 2])
    return np.divide(tangential, normal, out=np.zeros_like(normal), where=normal > 0.0)


def bounce(velocity: ArrayLike, friction: ArrayLike, restitution: ArrayLike) -> Array:
    """Velocity of the grain after the hit, relative to the wall, m/s, shape (..., 3) (eqs 13, 16 and 17 together)."""
    both = compression_impulse(1.0, velocity, friction) + recovery_impulse(1.0, velocity, friction, restitution)
    return _floats(velocity) + both


def wall_restitution(
    grain_before: ArrayLike, grain_after: ArrayLike, wall_before: ArrayLike, wall_after: ArrayLike
) -> Array:
    """e0 from the velocities along the normal: (V2l - V1l)/(v1l - v2l), 1 the grain, 2 the wall (eq 17 corrected).

    Erratum: printed with capital letters above and below the line, which is -1 whatever the velocities.
    """
    return (_floats(wall_after) - _floats(grain_after)) / (_floats(grain_before) - _floats(wall_before))


def position_after(
    position: ArrayLike, before: ArrayLike, after: ArrayLike, step: float, hit_at: ArrayLike, radius: ArrayLike
) -> Array:
    """Position at the end of a step in which the wall z = 0 is hit at `hit_at` (s), m, (..., 3) (eq 19 corrected).

    The grain touches at z = r and leaves from there. Erratum: z = z0 + r adds a radius at every hit.
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
    """m times: `slip_lost` against the slip, `normal_gained` along z."""
    slip = _slip(velocity)
    share = np.divide(slip_lost, slip, out=np.zeros_like(slip), where=slip > 0.0)
    change = np.stack((-share * velocity[..., 0], -share * velocity[..., 1], normal_gained), axis=-1)
    return _floats(mass)[..., None] * change
