"""The binary law over a million random pairs, its degenerate cases and its limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.theory.collision import (
    AfterCollision,
    Bodies,
    CollisionError,
    Contact,
    collide,
    in_contact,
    local_axes,
    moved,
    normals,
    pair_loss,
    reduced_mass,
    sign,
)

PAIRS = 500_000  # with and without spin: a million
X = np.array([[1.0, 0.0, 0.0]])
STILL = [[0.0, 0.0, 0.0]]


def random_pairs(
    rng: np.random.Generator, spin: bool
) -> tuple[Bodies, Bodies, np.ndarray, Contact]:
    """Mass ratio to 1e6, e 0..1, mu 0..2, b0 0..1; every tenth normal vertical, every tenth pair
    without slip.
    """
    m1 = np.exp(rng.uniform(-np.log(1e3), np.log(1e3), PAIRS))
    m2 = np.exp(rng.uniform(-np.log(1e3), np.log(1e3), PAIRS))
    n = normals(np.zeros((PAIRS, 3)), rng.standard_normal((PAIRS, 3)))
    n[::10] = [0.0, 0.0, 1.0]
    n[5::10] = [0.0, 0.0, -1.0]
    v1, v2 = rng.standard_normal((2, PAIRS, 3))
    e, mu, b0 = rng.uniform(0, 1, PAIRS), rng.uniform(0, 2, PAIRS), rng.uniform(0, 1, PAIRS)
    e[:1000], e[1000:2000], mu[2000:3000] = 0.0, 1.0, 0.0
    w1, w2 = rng.standard_normal((2, PAIRS, 3)) if spin else np.zeros((2, PAIRS, 3))
    v1[3::10] = v2[3::10] + rng.standard_normal((PAIRS // 10, 1)) * n[3::10]
    w1[3::10] = w2[3::10] = 0.0
    r1, r2 = rng.uniform(0.1, 2, (2, PAIRS))
    if spin:
        return Bodies(m1, v1, r1, w1), Bodies(m2, v2, r2, w2), n, Contact(e, mu, b0)
    return Bodies(m1, v1), Bodies(m2, v2), n, Contact(e, mu, b0)


def inertia(body: Bodies) -> np.ndarray:
    return 0.4 * np.asarray(body.mass) * np.asarray(body.radius) ** 2


def energy(first: Bodies, second: Bodies, after: AfterCollision | None = None) -> np.ndarray:
    v = (first.velocity, second.velocity) if after is None else (after.velocity1, after.velocity2)
    total = sum(
        0.5 * np.asarray(b.mass) * np.sum(np.square(u), axis=1)
        for b, u in zip((first, second), v, strict=True)
    )
    if first.spin is not None:
        s = (first.spin, second.spin) if after is None else (after.spin1, after.spin2)
        total = total + sum(
            0.5 * inertia(b) * np.sum(np.square(u), axis=1)
            for b, u in zip((first, second), s, strict=True)
        )
    return total


@pytest.mark.parametrize("spin", [False, True])
def test_a_million_random_pairs(spin: bool) -> None:
    first, second, n, contact = random_pairs(np.random.default_rng(11), spin)
    after = collide(first, second, n, contact)
    m1, m2 = (np.asarray(b.mass)[:, None] for b in (first, second))

    before = m1 * first.velocity + m2 * second.velocity
    scale = (m1 * np.abs(first.velocity) + m2 * np.abs(second.velocity)).sum(axis=1, keepdims=True)
    assert (np.abs(m1 * after.velocity1 + m2 * after.velocity2 - before) / scale).max() < 1e-12

    start, end = energy(first, second), energy(first, second, after)
    assert (after.loss >= 0.0).all()
    assert (end <= start * (1.0 + 1e-12)).all()
    # a sum of squares that cancel to the energy left: round-off is relative to what there was
    assert (np.abs(start - end - after.loss) / start).max() < 1e-12

    parting = np.einsum("pi,pi->p", after.velocity1 - after.velocity2, n)
    coming = np.einsum("pi,pi->p", np.subtract(first.velocity, second.velocity), n)
    hit = coming > 0.0
    # each velocity carries round-off of its own size
    np.testing.assert_allclose(
        parting[hit], (-np.asarray(contact.restitution) * coming)[hit], atol=1e-13 * 20
    )
    assert (after.velocity1[~hit] == np.asarray(first.velocity)[~hit]).all()
    assert (after.loss[~hit] == 0.0).all()


def test_angular_momentum_with_spin() -> None:
    """About the centre of body 1, for spheres that touch: (r1 + r2) n x m2 v2 + I1 w1 + I2 w2."""
    first, second, n, contact = random_pairs(np.random.default_rng(12), True)
    after = collide(first, second, n, contact)
    arm = (np.asarray(first.radius) + np.asarray(second.radius))[:, None] * n
    m2, I1, I2 = np.asarray(second.mass)[:, None], inertia(first)[:, None], inertia(second)[:, None]
    parts = (np.cross(arm, m2 * second.velocity), I1 * first.spin, I2 * second.spin)
    left = np.cross(arm, m2 * after.velocity2) + I1 * after.spin1 + I2 * after.spin2
    scale = sum(np.linalg.norm(part, axis=1, keepdims=True) for part in parts)
    impulse = np.linalg.norm(arm, axis=1, keepdims=True) * np.linalg.norm(
        after.impulse, axis=1, keepdims=True
    )
    assert (np.abs(left - sum(parts)) / (scale + impulse)).max() < 1e-12


def test_the_law_does_not_depend_on_the_frame() -> None:
    first, second, n, contact = random_pairs(np.random.default_rng(13), False)
    wind = np.array([3.0, -2.0, 1.0])
    here = collide(first, second, n, contact)
    there = collide(
        Bodies(first.mass, first.velocity + wind),
        Bodies(second.mass, second.velocity + wind),
        n,
        contact,
    )
    # velocities of size 4 differ by a few of their last bits, times 2 m_r
    tolerance = 1e-14 * (1.0 + reduced_mass(first.mass, second.mass))
    assert (np.abs(here.impulse - there.impulse) < 20 * tolerance[:, None]).all()


def test_unequal_masses_by_hand() -> None:
    """3 kg at 2 m/s onto 1 kg at rest, e = 0.5: m_r = 0.75, J = 2.25 N s, v = 1.25 and 2.25 m/s,
    loss 1.125 J.
    """
    after = collide(Bodies([3.0], 2.0 * X), Bodies([1.0], STILL), X, Contact(0.5))
    assert after.velocity1[0].tolist() == [1.25, 0.0, 0.0]
    assert after.velocity2[0].tolist() == [2.25, 0.0, 0.0]
    assert after.loss[0] == pair_loss(3.0, 1.0, 0.5, 2.0) == 1.125


def test_sliding_and_sticking_by_hand() -> None:
    """w = u = 1, equal unit masses, e = 1: J_n = 1; mu = 0.2: J_t = 0.2, loss 0.2 - 0.04; mu = 2:
    sticks, m_t/2.
    """
    hit = Bodies([1.0], [[1.0, 1.0, 0.0]])
    slide = collide(hit, Bodies([1.0], STILL), X, Contact(1.0, 0.2))
    assert slide.loss[0] == pytest.approx(0.2 - 0.04, rel=1e-14)
    stick = collide(hit, Bodies([1.0], STILL), X, Contact(1.0, 2.0))
    assert stick.loss[0] == pytest.approx(0.25, rel=1e-14)
    assert stick.velocity1[0, 1] == stick.velocity2[0, 1] == pytest.approx(0.5, rel=1e-14)


def test_a_rolling_start_leaves_five_sevenths() -> None:
    """A solid sphere onto a rough wall: its tangential speed floors at 5/7, with the spin of
    rolling.
    """
    after = collide(
        Bodies([1.0], [[1.0, 0.0, -1.0]], [0.5], STILL), Bodies([np.inf], STILL, [1.0], STILL),
        [[0.0, 0.0, -1.0]], Contact(0.7, 10.0),
    )  # fmt: skip
    assert after.velocity1[0, 0] == pytest.approx(5 / 7, rel=1e-14)
    assert after.spin1[0, 1] * 0.5 == pytest.approx(5 / 7, rel=1e-14)
    assert after.velocity2.tolist() == after.spin2.tolist() == STILL


def test_a_very_heavy_body_is_a_wall() -> None:
    light = Bodies([1.0], [[1.0, 0.3, 0.0]])
    wall = collide(light, Bodies([np.inf], STILL), X, Contact(0.6, 0.1))
    heavy = collide(light, Bodies([1e12], STILL), X, Contact(0.6, 0.1))
    np.testing.assert_allclose(heavy.velocity1, wall.velocity1, rtol=1e-11)
    assert reduced_mass(2.0, np.inf) == 2.0
    assert wall.velocity2.tolist() == STILL


def test_degenerate_pairs_are_left_alone() -> None:
    """Departing, sliding past, coincident centres, at rest."""
    v1 = np.array([[-1.0, 0, 0], [0.0, 1, 0], [1.0, 2, 3], [0.0, 0, 0]])
    n = np.array([[1.0, 0, 0], [1.0, 0, 0], [0.0, 0, 0], [1.0, 0, 0]])
    after = collide(
        Bodies(np.ones(4), v1), Bodies(np.ones(4), np.zeros((4, 3))), n, Contact(0.5, 0.5)
    )
    assert (after.velocity1 == v1).all()
    assert (after.impulse == 0.0).all()
    assert (after.loss == 0.0).all()


def test_coincident_centres_have_no_normal_and_near_ones_do() -> None:
    assert normals(STILL, STILL).tolist() == STILL
    np.testing.assert_allclose(
        normals(STILL, [[3e-300, 4e-300, 0.0]]), [[0.6, 0.8, 0.0]], rtol=1e-15
    )
    np.testing.assert_allclose(normals(STILL, [[3e200, 4e200, 0.0]]), [[0.6, 0.8, 0.0]], rtol=1e-15)


@pytest.mark.parametrize("speed", [0.0, 1e-300, 1e-160, 1e-20])
def test_vanishing_slip_gains_nothing(speed: float) -> None:
    """e = 0.9, mu = 0.3, where Coulomb's impulse in full would give 1.13 of the energy."""
    hit = Bodies([1.0], [[2.0, speed, 0.0]])
    after = collide(hit, Bodies([1.0], STILL), X, Contact(0.9, 0.3))
    assert abs(after.velocity1[0, 1]) <= speed
    assert energy(hit, Bodies([1.0], STILL), after)[0] == pytest.approx(2.0 - 0.19, rel=1e-14)


@pytest.mark.parametrize(("e", "kept"), [(0.0, 0.0), (1.0, 1.0)])
def test_restitution_limits(e: float, kept: float) -> None:
    """In the frame of the centre of mass: nothing is left at e = 0, all at e = 1."""
    first, second = Bodies([1.0], 3.0 * X), Bodies([3.0], -X)
    after = collide(first, second, X, Contact(e))
    assert energy(first, second, after)[0] == pytest.approx(kept * 6.0, abs=1e-15)


def test_bad_input_has_a_name() -> None:
    one = Bodies([1.0], X)
    still = Bodies([1.0], STILL)
    for first, second, n, contact in (
        (one, Bodies([0.0], STILL), X, Contact(0.5)),
        (Bodies([np.inf], X), Bodies([np.inf], STILL), X, Contact(0.5)),
        (one, still, 1.1 * X, Contact(0.5)),
        (one, still, X * np.nan, Contact(0.5)),
        (one, still, X, Contact(1.01)),
        (one, still, X, Contact(0.5, -0.1)),
        (one, still, X, Contact(0.5, 0.1, 1.5)),
        (Bodies([1.0], X + np.inf), still, X, Contact(0.5)),
        (Bodies([1.0], X, [1.0], STILL), still, X, Contact(0.5)),
        (Bodies([1.0], X, [0.0], STILL), Bodies([1.0], STILL, [1.0], STILL), X, Contact(0.5)),
        (Bodies([1.0], X, [1.0], X * np.nan), Bodies([1.0], STILL, [1.0], STILL), X, Contact(0.5)),
    ):
        with pytest.raises(CollisionError):
            collide(first, second, n, contact)
    walls = collide(Bodies([np.inf], STILL), Bodies([np.inf], STILL), X, Contact(0.5))
    assert walls.loss[0] == 0.0


@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: np.linalg.norm(n) > 1e-3))
def test_local_axes_are_orthonormal_and_right_handed(n: tuple[float, float, float]) -> None:
    axes = local_axes(normals(STILL, [n]))[0]
    np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-14)
    assert np.linalg.det(axes) == pytest.approx(1.0, abs=1e-14)


def test_local_axes_of_vertical_normals() -> None:
    for z in (1.0, -1.0):
        axes = local_axes([[0.0, 0.0, z]])[0]
        np.testing.assert_allclose(axes @ axes.T, np.eye(3), atol=1e-15)


def test_contact_condition_and_sign() -> None:
    """Eq 6 is strict; eq 9 has sgn(0) = 0."""
    found = in_contact(np.zeros((3, 3)), [[0.9, 0, 0], [1.0, 0, 0], [0, 0, 0]], 1.0, 1.0)
    assert found.tolist() == [True, False, True]
    assert sign([-2.0, 0.0, 3.0]).tolist() == [-1.0, 0.0, 1.0]


def test_position_after_a_step() -> None:
    """Eq 12: the mean of both velocities is right for a hit in mid-step, and only then."""
    x, v, V = np.zeros((2, 3)), np.tile(-X, (2, 1)), np.tile(0.5 * X, (2, 1))
    found = moved(x, v, V, 0.2, [0.1, 0.0])
    np.testing.assert_allclose(found[:, 0], [0.5 * (-1.0 + 0.5) * 0.2, 0.1], rtol=1e-15)
