"""The errata of the collision model: the local basis, and the impulses in it."""

import numpy as np
from numpy.typing import NDArray

from rig.theory import collision
from rig.theory.collision import Bodies, Contact
from rig.theory.paper import literal
from rig.theory.paper.erratum import Erratum
from rig.theory.paper.sentences import GRAIN

__all__ = ["Array", "basis_errata", "collision_errata", "random_hits"]

Array = NDArray[np.float64]


SAMPLE = 100_000
"""Random hits per fraction: its standard error is below 0.2 %."""

SEED = 2015


def random_hits(
    rng: np.random.Generator, hits: int, ratio: float, friction: float
) -> tuple[Array, ...]:
    """Return m1, m2, e, mu and velocities (l, m, n of 1, then of 2) of approaching pairs in local
    coordinates.

    m1 = 1 kg, m2/m1 log-uniform in [1/ratio, ratio], e uniform in [0, 1], mu uniform in [0,
    friction], velocities normal.
    """
    m2 = np.exp(rng.uniform(-np.log(ratio), np.log(ratio), hits))
    e, mu = rng.uniform(0.0, 1.0, hits), rng.uniform(0.0, friction, hits)
    v = rng.standard_normal((hits, 6))
    # Body 1 lies on the negative side: its normal velocity must be the larger one for an approach.
    v[:, 0], v[:, 3] = np.maximum(v[:, 0], v[:, 3]), np.minimum(v[:, 0], v[:, 3])
    return np.ones(hits), m2, e, mu, v


def basis_errata() -> tuple[Erratum, ...]:
    """Return the errata of the local basis of a contact."""
    rng = np.random.default_rng(SEED)
    n = collision.normals(np.zeros((SAMPLE, 3)), rng.standard_normal((SAMPLE, 3)))
    printed, right = (
        np.abs(_off_diagonal(axes(n))).max() for axes in (literal.local_axes, collision.local_axes)
    )
    up = np.array([[0.0, 0.0, 1.0]])
    vertical = [
        float(np.isfinite(axes(up)).mean()) for axes in (literal.local_axes, collision.local_axes)
    ]
    still = literal.collide([1.0], [1.0], 0.65, GRAIN, np.array([[1.0, 1.0, 0.0, -1.0, 0.0, 0.0]]))
    ours = collision.collide(
        Bodies([1.0], [[1.0, 1.0, 0.0]]),
        Bodies([1.0], [[-1.0, 0.0, 0.0]]),
        [[1.0, 0.0, 0.0]],
        Contact(0.65, GRAIN),
    )
    touching = collision.in_contact([[0.0, 0.0, 0.0]], [[0.9, 0.0, 0.0]], 1.0, 1.0)
    leaving = collision.collide(
        Bodies([1.0], [[-1.0, 0.0, 0.0]]),
        Bodies([1.0], [[1.0, 0.0, 0.0]]),
        [[1.0, 0.0, 0.0]],
        Contact(0.65),
    )
    return (
        Erratum(
            "6",
            "hits of an overlapping pair that departs",
            "overlap is a hit",
            "overlap and approach",
            float(touching[0]),
            float(leaving.impulse.any()),
            "",
            False,
        ),
        Erratum(
            "7",
            "largest |cos| between two local axes",
            "m = (-cos b, -cos a, 0)/s",
            "m normal to l",
            float(printed),
            float(right),
            "",
            False,
        ),
        Erratum(
            "7",
            "share of the axes defined for a vertical contact",
            "0/0",
            "branch-safe basis",
            vertical[0],
            vertical[1],
            "",
            False,
        ),
        Erratum(
            "9",
            "velocity that grain 1 gains along n, where nothing slips",
            "sgn(0) = 1",
            "sgn(0) = 0",
            float(still[0, 2]),
            float(ours.velocity1[0, 2]),
            "m/s",
            False,
            "m1 = m2, e = 0.65, mu = 0.25, w = 2 m/s",
        ),
    )


def collision_errata() -> tuple[Erratum, ...]:
    """Return the errata of the impulses between two grains."""
    rng = np.random.default_rng(SEED)
    narrow = random_hits(rng, SAMPLE, 1e3, 0.5)
    wide = random_hits(rng, SAMPLE, 1e6, 2.0)
    after = literal.collide(*narrow)
    ours = _corrected(narrow)
    A, _ = literal.matrices([1.0], [1e6], 0.65, 0.25, 0.25)
    capped = _uncapped_gain(0.9, 0.3)
    sampled = "m2/m1 1e-3 to 1e3 log-uniform, e 0 to 1, mu 0 to 0.5 uniform, velocities normal"
    return (
        Erratum(
            "8",
            "friction on the diagonal over mu J_n",
            "two independent lambda: a square",
            "one slip: a cone",
            2.0**0.5,
            1.0,
            "",
            False,
        ),
        Erratum(
            "10",
            "condition of A at m2/m1 = 1e6",
            "6 x 6 system",
            "explicit law, no system",
            float(np.linalg.cond(A[0])),
            None,
            "",
            False,
            "m1 = 1 kg",
        ),
        Erratum(
            "11, row 4 of B",
            "share of hits after which the pair still approaches",
            "[-e, 0, 0, e, 0, 0]",
            "[e, 0, 0, -e, 0, 0]",
            float(np.mean(after[:, 0] > after[:, 3])),
            float(np.mean(ours[:, 0] > ours[:, 3] + 1e-9)),
            "",
            False,
            sampled,
        ),
        Erratum(
            "11",
            "share of random hits that gain energy",
            "-lambda1 m1, -lambda2 m2",
            "+lambda m2, capped",
            _gaining(narrow, after),
            _gaining(narrow, ours),
            "",
            False,
            sampled,
        ),
        Erratum(
            "11",
            "the same, wide sample",
            "-lambda1 m1, -lambda2 m2",
            "+lambda m2, capped",
            _gaining(wide, literal.collide(*wide)),
            _gaining(wide, _corrected(wide)),
            "",
            False,
            "m2/m1 1e-6 to 1e6, mu 0 to 2",
        ),
        Erratum(
            "11",
            "energy after over before, slip near 0, |lambda| = mu",
            "not capped",
            "capped at sticking",
            capped[0],
            capped[1],
            "",
            False,
            "m1 = m2, e = 0.9, mu = 0.3, one tangent",
        ),
    )


def _off_diagonal(axes: Array) -> Array:
    """Return the cosines between the axes of each basis; 0 for an orthogonal one."""
    return np.asarray(np.einsum("pij,pkj->pik", axes, axes)[:, [0, 0, 1], [1, 2, 2]])


def _corrected(hits: tuple[Array, ...]) -> Array:
    m1, m2, e, mu, v = hits
    n = np.broadcast_to([1.0, 0.0, 0.0], (m1.size, 3))
    after = collision.collide(Bodies(m1, v[:, :3]), Bodies(m2, v[:, 3:]), n, Contact(e, mu))
    return np.concatenate((after.velocity1, after.velocity2), axis=1)


def _gaining(hits: tuple[Array, ...], after: Array) -> float:
    """Return the fraction of the hits whose kinetic energy grows."""
    m1, m2, _, _, v = hits
    before = literal.kinetic_energy(m1, m2, v)
    return float(np.mean(literal.kinetic_energy(m1, m2, after) > before * (1.0 + 1e-9)))


def _uncapped_gain(e: float, mu: float) -> tuple[float, float]:
    """Return energy after over before of equal masses with vanishing slip: Coulomb's impulse in
    full, and capped.
    """
    w, m_r = 2.0, 0.5
    before = 0.5 * m_r * w**2
    push = mu * m_r * (1.0 + e) * w
    return (e**2 * before + push**2 / (2.0 * m_r)) / before, e**2
