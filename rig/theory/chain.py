"""A chain of grains struck by a wall: eqs 17 and 20 to 23, first wave and complete collision."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rig.kernels.chain import MOST_HITS, collide_file, rebound
from rig.theory.collision import pair_loss

Array = NDArray[np.float64]

COLLAPSE = 2.5
"""Value of n (1 - e) from which a row of n grains is treated as plastic; the number of hits
diverges near pi.

The neglected rebound, for n from 3 to 119: at most 0.0003 for walls of restitution 0 and 0.3,
0.0013 for 0.75, 0.0053 for 0.85, 0.0132 for 1 (0.0134 for n = 500).
"""

CONTACT_SHARE = 1e-6
"""Default contact duration, as a fraction of the time in which the fastest grain crosses the
smallest gap.

Hits that follow sooner are elastic, which ends a collapse after 10^2 to 10^6 hits. Chains that do
not collapse are unaffected. In those that do, the value decides which grain flies off last and at
what speed: 0.9 to 1 of the energy is lost, without a trend over fractions from 1e-3 to 1e-12,
whereas the same chain followed down to `AT_REST` loses all of it.
"""


LONGEST_ROW = 2000
"""Largest number of grains in a row whose rebound is computed: up to 1.8 n^2 hits, each moving n
grains.
"""


class TooManyHits(ArithmeticError):
    """A chain of grains that has not separated after 10^7 hits, or is too long to be followed."""


@dataclass(frozen=True, eq=False)
class Collided:
    """A chain of grains after its last hit.

    velocity : m/s, shape (grains,)
    loss : between grains, J; wall_loss : at the wall, J
    hits : number of hits of both kinds
    elastic_hits : hits made elastic by the contact duration; 0 if nothing collapsed
    """

    velocity: Array
    loss: float
    wall_loss: float
    hits: int
    elastic_hits: int


def first_grain_velocity(
    wall_velocity: float,
    restitution_wall: float,
    wall_velocity_after: float | None = None,
    grain_velocity: float = 0.0,
) -> float:
    """Return the velocity of a grain struck by the wall, m/s: V2 + e0 (V1 - v0) (eq 22).

    V1 and V2 are the velocities of the wall before and after. A heavy wall keeps its velocity
    (default), which gives (1 + e0) V for a grain at rest. Eq 22 is right as printed, e0 V1 + V2 for
    v0 = 0, with e0 from eq 17 corrected; with eq 17 as printed, e0 = -1, it would be V2 - V1.
    """
    after = wall_velocity if wall_velocity_after is None else wall_velocity_after
    return after + restitution_wall * (wall_velocity - grain_velocity)


def struck_velocity(mass1: float, mass2: float, restitution: float, velocity: float) -> float:
    """Return the velocity that a grain at rest receives, m/s: m1 (1 + e) v1/(m1 + m2) (eq 20, right
    as printed).
    """
    return mass1 * (1.0 + restitution) * velocity / (mass1 + mass2)


def striker_velocity(mass1: float, mass2: float, restitution: float, velocity: float) -> float:
    """Return the velocity that the striking grain keeps, m/s: (m1 - e m2) v1/(m1 + m2). Not in the
    paper; eq 23 needs it.
    """
    return (mass1 - restitution * mass2) * velocity / (mass1 + mass2)


def chain_velocities(masses: ArrayLike, restitution: ArrayLike, first_velocity: float) -> Array:
    """Return the velocity that each grain of a resting chain receives from its predecessor, m/s,
    shape (n,) (eqs 21, 22).

    masses : kg, shape (n,)
    restitution : of the contacts, shape (n - 1,) or ()
    first_velocity : v1 of eq 21, or for eq 22 e0 V1 + V2 by `first_grain_velocity`

    Right as printed, for the first wave through grains at rest.
    """
    m = np.asarray(masses, dtype=np.float64)
    # Velocity ratio of each pair, eq 20; its running product is eq 21.
    gain = m[:-1] * (1.0 + np.asarray(restitution, dtype=np.float64)) / (m[:-1] + m[1:])
    return first_velocity * np.concatenate(([1.0], np.cumprod(gain)))


def first_wave_loss(masses: ArrayLike, restitution: ArrayLike, first_velocity: float) -> float:
    """Return the energy lost in the first wave along a resting chain, J (eq 23 over pairs: sum of
    m_r (1 - e^2) w^2 / 2).

    Arguments as for `chain_velocities`. For n equal grains: m v1^2 (1 + e)/(3 + e) (1 -
    q^(2(n-1))), q = (1 + e)/2.
    """
    m = np.asarray(masses, dtype=np.float64)
    # Each grain strikes a resting neighbour: its velocity is the approach speed.
    approach = chain_velocities(m, restitution, first_velocity)[:-1]
    return float(np.sum(pair_loss(m[:-1], m[1:], restitution, approach)))


def wall_loss(mass: float, restitution_wall: float, wall_velocity: float) -> float:
    """Return the energy lost between a heavy wall and a resting mass, J: m (1 - e0^2) V^2 / 2 in
    the wall frame (eq 23).
    """
    return 0.5 * mass * (1.0 - restitution_wall**2) * wall_velocity**2


def chain_collision(
    masses: ArrayLike,
    restitution: ArrayLike,
    velocities: ArrayLike,
    restitution_wall: float | None = None,
    gaps: ArrayLike = 1.0,
    contact_time: float | None = None,
) -> Collided:
    """Return the complete collision of a chain of grains, hit by hit until separation (eqs 17, 20
    to 23, all waves).

    masses : kg, shape (n,)
    restitution : of the contacts, shape (n - 1,) or ()
    velocities : m/s, shape (n,), positive away from the wall
    restitution_wall : of a wall at rest before the first grain; None for no wall
    gaps : m, before each grain (the first: to the wall), shape (n,) or (). Hard points have no
        other length, so only the ratios of the gaps matter
    contact_time : s, see `CONTACT_SHARE`; 0 for none

    Eq 23 is applied to every pair that hits. Raises TooManyHits (a collapse without contact time).
    """
    m = np.ascontiguousarray(masses, dtype=np.float64)
    v = np.array(np.broadcast_to(np.asarray(velocities, dtype=np.float64), m.shape))
    gap = np.broadcast_to(np.asarray(gaps, dtype=np.float64), m.shape)
    e = np.array(np.broadcast_to(np.asarray(restitution, dtype=np.float64), (m.size - 1,)))
    fastest = float(np.abs(v).max())
    # Scaled by the shortest possible time to a hit.
    if contact_time is None:
        contact_time = CONTACT_SHARE * float(gap.min()) / fastest if fastest > 0.0 else 0.0
    walled = restitution_wall is not None
    inside, at_wall, hits, elastic = collide_file(
        m,
        e,
        walled,
        restitution_wall if restitution_wall is not None else 1.0,
        np.cumsum(gap),
        v,
        contact_time,
    )
    if hits >= MOST_HITS:
        raise TooManyHits(
            f"{m.size} grains have not come apart after {hits} hits: give a longer contact_time"
        )
    return Collided(v, float(inside), float(at_wall), int(hits), int(elastic))


def grains_in_row(length: float, diameter: float) -> int:
    """Return the number of grains side by side in a length, floor(L1/d), robust to rounding of an
    integer quotient.
    """
    # 0.3/0.1 is 2.9999999999999996: without the margin a grain would be missing.
    return int(length / diameter * (1.0 + 1e-9))


@lru_cache(maxsize=256)
def row_restitution(grains: int, restitution: float, restitution_wall: float) -> float:
    """Return the rebound of the centre of mass of a row of equal grains thrown together onto a
    wall, in [0, 1].

    All hits until separation, event by event, with equal (vanishing) initial gaps. A row whose n (1
    - e) reaches `COLLAPSE` is plastic: 0. Raises TooManyHits for a row that is not plastic and
    longer than `LONGEST_ROW`.
    """
    if grains <= 1:
        return restitution_wall
    # The margin keeps n (1 - e) = 2.5 plastic whatever the rounding of 1 - e.
    if grains * (1.0 - restitution) >= COLLAPSE * (1.0 - 1e-12):
        return 0.0
    if grains > LONGEST_ROW:
        raise TooManyHits(f"{grains} grains in a row, restitution {restitution:g}")
    return float(rebound(grains, restitution, restitution_wall))
