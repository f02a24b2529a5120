"""Collision of two bodies: eqs 6 to 12 and the pair form of eq 23, for many pairs at once.

One explicit law replaces the printed 6 x 6 system (`rig.theory.paper.literal`). Vectors have shape
(pairs, 3), scalars (pairs,) or (). A body of infinite mass is a wall. Loss and impulses are
independent of the frame.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

UNIT = 1e-9
"""Largest deviation of the length of a normal from 1."""

ROLLING = 2.0 / 7.0
"""Ratio of tangential to normal reduced mass of solid spheres: 1/m_t = 1/m_r (1 + r^2 m/I), I = 2/5
m r^2.
"""


class CollisionError(ArithmeticError):
    """A pair for which the law has no answer; the message names the quantity."""


@dataclass(frozen=True, eq=False)
class Bodies:
    """One side of every pair.

    mass : kg, shape (pairs,), infinite for a wall
    velocity : m/s, shape (pairs, 3)
    radius, spin : m, shape (pairs,), and rad/s, shape (pairs, 3): both or neither (a point cannot
        rotate)
    """

    mass: ArrayLike
    velocity: ArrayLike
    radius: ArrayLike | None = None
    spin: ArrayLike | None = None


@dataclass(frozen=True, eq=False)
class Contact:
    """Coefficients of a contact, shapes (pairs,) or ().

    restitution : e in [0, 1]
    friction : mu >= 0
    tangential_restitution : b0 in [0, 1], 0 sticks
    """

    restitution: ArrayLike
    friction: ArrayLike = 0.0
    tangential_restitution: ArrayLike = 0.0


@dataclass(frozen=True, eq=False)
class AfterCollision:
    """State after the hit.

    velocity1, velocity2 : m/s
    spin1, spin2 : rad/s; None for points
    impulse : on body 2, N s
    loss : energy lost, J
    """

    velocity1: Array
    velocity2: Array
    spin1: Array | None
    spin2: Array | None
    impulse: Array
    loss: Array


def in_contact(
    position1: ArrayLike, position2: ArrayLike, diameter1: ArrayLike, diameter2: ArrayLike
) -> Mask:
    """Return whether two spheres overlap: distance of the centres below (d1 + d2)/2, all in m (eq
    6).

    Erratum: overlap is not sufficient for a hit. `collide` requires approach as well; otherwise one
    overlap is hit again and again.
    """
    apart = np.linalg.norm(_floats(position2) - _floats(position1), axis=-1)
    return np.asarray(apart < 0.5 * (_floats(diameter1) + _floats(diameter2)))


def normals(position1: ArrayLike, position2: ArrayLike) -> Array:
    """Return the unit vectors from centre 1 to centre 2, the l axis of eq 7, shape (pairs, 3).

    Coincident centres have no direction: they get the zero vector, for which `collide` does
    nothing.
    """
    apart = _floats(position2) - _floats(position1)
    # Scaled by the largest component first, so that the squares cannot over- or underflow.
    scale = np.abs(apart).max(axis=-1, keepdims=True)
    scaled = np.divide(apart, scale, out=np.zeros_like(apart), where=scale > 0.0)
    length = np.linalg.norm(scaled, axis=-1, keepdims=True)
    return np.asarray(np.divide(scaled, length, out=np.zeros_like(scaled), where=length > 0.0))


def local_axes(normal: ArrayLike) -> Array:
    """Return right-handed orthonormal axes l, m, n of a contact as rows, shape (pairs, 3, 3) (eq 7
    corrected).

    Erratum: the printed m axis has the wrong sign on its y term, so that l.m = -2 cos a cos b/s,
    and both tangents are 0/0 for a vertical normal. This is the branch-safe basis of Duff et al.,
    J. Comp. Graph. Tech. 6 (2017). `collide` does not need it.
    """
    l_axis = _floats(normal)
    x, y, z = l_axis[..., 0], l_axis[..., 1], l_axis[..., 2]
    # Never divides by less than 1: sign + z has the magnitude 1 + |z|.
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    m_axis = np.stack((1.0 + sign * x * x * a, sign * b, -sign * x), axis=-1)
    n_axis = np.stack((b, sign + y * y * a, -y), axis=-1)
    return np.stack((l_axis, m_axis, n_axis), axis=-2)


def sign(value: ArrayLike) -> Array:
    """Return the sign with sgn(0) = 0 (eq 9 corrected).

    Erratum: as printed, sgn(0) is both +1 and -1, so that zero slip causes slip.
    """
    return np.sign(_floats(value))


def reduced_mass(mass1: ArrayLike, mass2: ArrayLike) -> Array:
    """Return m1 m2/(m1 + m2), kg, without loss of digits at any ratio.

    If one mass is infinite, it is the other mass; if both are, infinity.
    """
    compliance = np.asarray(1.0 / _floats(mass1) + 1.0 / _floats(mass2))
    return np.asarray(
        np.divide(1.0, compliance, out=np.full(compliance.shape, np.inf), where=compliance > 0.0)
    )


def pair_loss(
    mass1: ArrayLike, mass2: ArrayLike, restitution: ArrayLike, approach: ArrayLike
) -> Array:
    """Return the energy that a pair loses along its normal, J: m_r (1 - e^2) w^2/2 at approach
    speed w (eq 23, one pair).

    Erratum: eq 23 sums the energy drop of every single grain and so counts energy passed to the
    next grain as lost.
    """
    e = _floats(restitution)
    # (1 - e)(1 + e) keeps the digits that 1 - e^2 loses for e near 1.
    return 0.5 * reduced_mass(mass1, mass2) * (1.0 - e) * (1.0 + e) * _floats(approach) ** 2


def collide(first: Bodies, second: Bodies, normal: ArrayLike, contact: Contact) -> AfterCollision:
    """Return the state after the hit of every pair (eqs 8, 10, 11 corrected).

    normal : unit vector from body 1 to body 2, shape (pairs, 3); zero (see `normals`) for a pair
        that must not hit

    J_n = m_r (1 + e) w for approach speed w = (v1 - v2).n > 0, and against the slip u of the
    contact point J_t = min(mu J_n, m_t (1 + b0) |u|), with m_t = 2/7 m_r for solid spheres with
    spin, m_r for points. Loss m_r (1 - e^2) w^2/2 + J_t |u| - J_t^2/(2 m_t), never negative. A pair
    that does not approach is left unchanged.

    Errata of eq 11: row 4 of B must read [e, 0, 0, -e, 0, 0] (as printed the pair still approaches
    after the hit); rows 5 and 6 must have +lambda m2 in both matrices (as printed friction
    accelerates the slip); and |lambda| must be limited to the value that stops the slip, or energy
    is created.

    Raises CollisionError for a mass that is not positive, two walls that approach, coefficients out
    of range, a normal whose length is neither 1 nor 0, a sphere without radius or spin, or NaN.
    """
    n = _floats(normal)
    m1, m2 = _floats(first.mass), _floats(second.mass)
    v1, v2 = _floats(first.velocity), _floats(second.velocity)
    e, mu, b0 = (
        _floats(contact.restitution),
        _floats(contact.friction),
        _floats(contact.tangential_restitution),
    )
    _check(n, m1, m2, v1, v2, e, mu, b0)
    spinning = _turning(first, second)

    relative = v1 - v2
    approach = _dot(relative, n)
    # Erratum of eq 6: only pairs that approach hit.
    hit = approach > 0.0
    w = np.where(hit, approach, 0.0)
    if np.any(hit & np.isinf(m1) & np.isinf(m2)):
        raise CollisionError(
            "two bodies of infinite mass approach each other: no impulse can part them"
        )
    m_r = np.where(hit, reduced_mass(m1, m2), 0.0)
    J_n = m_r * (1.0 + e) * w

    # Tangential part of the relative velocity at the contact point.
    slip = relative - approach[..., None] * n
    if spinning is not None:
        (r1, spin1), (r2, spin2) = spinning
        slip = slip + np.cross(r1[..., None] * spin1 + r2[..., None] * spin2, n)
    # Surface velocity of a spinning sphere at the contact: spin x r n on body 1, the opposite on 2.
    drag, rubbed = _friction(slip, mu * J_n, m_r if spinning is None else ROLLING * m_r, b0)
    impulse = J_n[..., None] * n + drag[..., None] * slip
    turned1 = turned2 = None
    if spinning is not None:
        # The impulse acts at r n from centre 1 and -r n from centre 2; I = 2/5 m r^2.
        torque = np.cross(n, impulse)
        turned1 = spin1 - _over(torque, 0.4 * m1 * r1)
        turned2 = spin2 - _over(torque, 0.4 * m2 * r2)
    return AfterCollision(
        velocity1=v1 - _over(impulse, m1),
        velocity2=v2 + _over(impulse, m2),
        spin1=turned1,
        spin2=turned2,
        impulse=impulse,
        loss=0.5 * m_r * (1.0 - e) * (1.0 + e) * w**2 + rubbed,
    )


def moved(
    position: ArrayLike, before: ArrayLike, after: ArrayLike, step: float, hit_at: ArrayLike
) -> Array:
    """Return the position after a time step with a hit at `hit_at` (s after its start), m (eq 12
    corrected).

    Erratum: the printed mean of both velocities holds for a hit in mid-step only; its error is up
    to |V - v| step/2.
    """
    at = _floats(hit_at)[..., None]
    return _floats(position) + _floats(before) * at + _floats(after) * (step - at)


def _floats(value: ArrayLike) -> Array:
    return np.asarray(value, dtype=np.float64)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("...i,...i->...", a, b))


def _over(vector: Array, number: Array) -> Array:
    """Return vector / number; 0 where the number is infinite."""
    return vector * (1.0 / number)[..., None]


def _friction(slip: Array, most: Array, m_t: Array, b0: Array) -> tuple[Array, Array]:
    """Return the tangential impulse divided by the slip (kg), with an impulse of at most `most` (N
    s), and the loss (J).

    Dividing by the slip needs no direction, so that zero slip is no special case.
    """
    speed = np.linalg.norm(slip, axis=-1)
    sliding = np.divide(most, speed, out=np.full(speed.shape, np.inf), where=speed > 0.0)
    drag = np.minimum(sliding, m_t * (1.0 + b0))
    # Loss J_t |u| - J_t^2/(2 m_t) = drag u^2 (1 - drag/(2 m_t)) with J_t = drag u.
    share = np.divide(drag, 2.0 * m_t, out=np.zeros_like(drag), where=m_t > 0.0)
    return drag, drag * speed**2 * (1.0 - share)


def _turning(
    first: Bodies, second: Bodies
) -> tuple[tuple[Array, Array], tuple[Array, Array]] | None:
    """Return radius and spin of both sides; None for points."""
    given = (first.radius, first.spin, second.radius, second.spin)
    if all(value is None for value in given):
        return None
    if any(value is None for value in given):
        raise CollisionError("radius and spin must be given for both bodies, or for none")
    r1, s1, r2, s2 = (np.asarray(value, dtype=np.float64) for value in given)
    if not (
        (r1 > 0.0).all() and (r2 > 0.0).all() and np.isfinite(r1).all() and np.isfinite(r2).all()
    ):
        raise CollisionError("radius must be positive and finite (a flat wall: any radius, spin 0)")
    if not (np.isfinite(s1).all() and np.isfinite(s2).all()):
        raise CollisionError("spin must be finite")
    return (r1, s1), (r2, s2)


def _check(
    n: Array, m1: Array, m2: Array, v1: Array, v2: Array, e: Array, mu: Array, b0: Array
) -> None:
    """Raise CollisionError for the first quantity out of its range. NaN fails every comparison."""
    length = np.linalg.norm(n, axis=-1)
    allowed = (
        (
            "normal must have length 1, or 0 for no contact",
            (np.abs(length - 1.0) <= UNIT) | (length == 0.0),
        ),
        ("mass must be positive", (m1 > 0.0) & (m2 > 0.0)),
        ("velocity must be finite", np.isfinite(v1) & np.isfinite(v2)),
        ("restitution must lie in [0, 1]", (e >= 0.0) & (e <= 1.0)),
        ("friction must be 0 or more, and finite", (mu >= 0.0) & np.isfinite(mu)),
        ("tangential restitution must lie in [0, 1]", (b0 >= 0.0) & (b0 <= 1.0)),
    )
    for message, holds in allowed:
        if not np.all(holds):
            raise CollisionError(message)
