"""Hard cases of the collision law of a pair: `rig.theory.collision`, beside eq 11 as printed in the
paper.
"""

from fractions import Fraction
from itertools import product

import numpy as np
from numpy.typing import NDArray

from daq.random_streams import stream
from rig.benchmarks.hard.case import Case, CaseOutcome, at_least, at_most, exactly, no_more
from rig.theory import collision
from rig.theory.collision import Bodies, Contact, collide, local_axes, normals
from rig.theory.paper import literal
from rig.theory.paper.errata import random_hits

Array = NDArray[np.float64]

SEED = 2015
UNIT = np.eye(3)


def degenerate() -> CaseOutcome:
    """Vertical normals, coincident centres, no slip at all, a grazing pass."""
    vertical = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    axes = local_axes(vertical)
    here = np.zeros((1, 3))
    nowhere = normals(here, here)
    away = collide(Bodies(1.0, [[1.0, 2.0, 3.0]]), Bodies(2.0, here), nowhere, Contact(0.5, 0.3))
    straight = collide(
        Bodies(1.0, [[0.0, 0.0, 1.0]]), Bodies(1.0, here), vertical[:1], Contact(0.65, 0.25)
    )
    passing = collide(
        Bodies(1.0, [[0.0, 1.0, 0.0]]), Bodies(1.0, here), vertical[:1], Contact(0.65, 2.0)
    )
    printed_axes = literal.local_axes(vertical)
    printed = literal.collide(1.0, 1.0, 0.65, 0.25, np.array([[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]]))
    return CaseOutcome(
        measured=(
            at_most(
                "departure of the axes of a vertical normal from orthonormal",
                np.abs(axes @ np.swapaxes(axes, -1, -2) - UNIT).max(),
                1e-15,
            ),
            exactly("impulse between coincident centres", np.abs(away.impulse).max(), 0.0),
            exactly(
                "sideways velocity out of no slip", np.abs(straight.velocity1[0, :2]).max(), 0.0
            ),
            exactly(
                "impulse and loss of a grazing pass",
                np.abs(passing.impulse).max() + passing.loss.max(),
                0.0,
            ),
        ),
        naive=(
            exactly(
                "eq 7: axes that are not numbers, of 2",
                np.isnan(printed_axes).any((1, 2)).sum(),
                2.0,
            ),
            at_least(
                "eq 9: velocity made from no slip, m/s", np.abs(printed[0, [1, 2]]).max(), 0.04
            ),
        ),
    )


def mass_ratio() -> CaseOutcome:
    """m2/m1 from 1e-12 to 1e12 head on, against exact rational arithmetic; infinite mass as the
    limit.
    """
    worst, loss_error = 0.0, 0.0
    velocities, restitutions = (1.25, -0.75), (0.0, 0.25, 0.65, 1.0)
    for power, e in product(range(-12, 13, 2), restitutions):
        m2 = 10.0**power
        after = _head_on(1.0, m2, velocities, e)
        v1, v2, loss = _rational(Fraction(1), Fraction(m2), velocities, e)
        found = (after.velocity1[0, 0], after.velocity2[0, 0])
        worst = max(
            worst,
            *(float(abs(Fraction(a) - b)) / 2.0 for a, b in zip(found, (v1, v2), strict=True)),
        )
        if loss:
            loss_error = max(loss_error, float(abs(Fraction(after.loss[0]) / loss - 1)))
    infinite = _head_on(1.0, np.inf, velocities, 0.65)
    limit = velocities[1] - 0.65 * 2.0
    m1, mass2, restitution, _, _ = random_hits(stream(SEED, "hard", "ratio"), 1000, 1e6, 0.0)
    condition = float(np.linalg.cond(literal.matrices(m1, mass2, restitution, 0.0, 0.0)[0]).max())
    return CaseOutcome(
        measured=(
            at_most(
                "error of the velocities over the closing speed, exact fractions", worst, 1e-15
            ),
            at_most("relative error of the loss, exact fractions", loss_error, 1e-15),
            at_most(
                "velocity off an infinite mass, the wall's law",
                abs(infinite.velocity1[0, 0] - limit),
                1e-15,
            ),
            exactly(
                "velocity of the infinite mass changed by",
                infinite.velocity2[0, 0] - velocities[1],
                0.0,
            ),
        ),
        naive=(
            at_least("eq 10: condition number of the 6 x 6 system, ratios to 1e6", condition, 1e6),
        ),
    )


def limits_of_coefficients() -> CaseOutcome:
    """e in {0, 1}, mu in {0, .25, 1, 10, 1e6}, stick, slide, spin or not: energy is never created,
    slip never reversed.
    """
    rng = stream(SEED, "hard", "limits")
    count = 4000
    gained, turned, parted = -np.inf, 0.0, 0.0
    for e, mu, b0, spins in product(
        (0.0, 1.0), (0.0, 0.25, 1.0, 10.0, 1e6), (0.0, 1.0), (False, True)
    ):
        one, two, normal = _random_pairs(rng, count, spins)
        after = collide(one, two, normal, Contact(e, mu, b0))
        before = _energy(one, one.velocity, one.spin) + _energy(two, two.velocity, two.spin)
        later = _energy(one, after.velocity1, after.spin1) + _energy(
            two, after.velocity2, after.spin2
        )
        gained = max(gained, float(((later - before) / before).max()))
        closing = np.einsum("ij,ij->i", np.asarray(one.velocity) - two.velocity, normal)
        leaving = np.einsum("ij,ij->i", after.velocity1 - after.velocity2, normal)
        hit = closing > 0.0
        parted = max(
            parted, float((np.abs(leaving + e * closing)[hit] / np.abs(closing)[hit].max()).max())
        )
        if not spins and b0 == 0.0:
            slip = (np.asarray(one.velocity) - two.velocity) - closing[:, None] * normal
            kept = (after.velocity1 - after.velocity2) - leaving[:, None] * normal
            turned = max(
                turned,
                float(
                    (-np.einsum("ij,ij->i", slip, kept) / np.einsum("ij,ij->i", slip, slip)).max()
                ),
            )
    m1, m2, e_any, mu_any, v = random_hits(stream(SEED, "hard", "printed"), 20_000, 1e3, 2.0)
    printed = literal.collide(m1, m2, e_any, mu_any, v)
    ratio = literal.kinetic_energy(m1, m2, printed) / literal.kinetic_energy(m1, m2, v)
    return CaseOutcome(
        measured=(
            at_most("energy gained, as a fraction, 160 000 hits", gained, 1e-13),
            at_most("approach after the hit beyond -e times that before", parted, 1e-13),
            at_most("slip turned against itself, as a fraction", turned, 1e-13),
        ),
        naive=(
            at_least(
                "eq 11: fraction of hits that gain energy", float((ratio > 1.0 + 1e-12).mean()), 0.5
            ),
            at_least("eq 11: energy after over before, worst", float(ratio.max()), 1e2),
        ),
    )


def elastic_gas() -> CaseOutcome:
    """A million hits with e = 1 and mu = 0 among 1000 grains of unequal mass; the same with
    friction and e < 1.
    """
    rng = stream(SEED, "hard", "gas")
    grains, rounds = 1000, 2000
    mass = np.exp(rng.uniform(-3.0, 3.0, grains))
    start = rng.standard_normal((grains, 3))
    drift, momentum, loss = [], [], 0.0
    for contact in (Contact(1.0), Contact(0.9, 0.25)):
        v, lost = start.copy(), 0.0
        order = np.random.Generator(np.random.SFC64(SEED))
        for _ in range(rounds):
            i, j = order.permutation(grains).reshape(2, -1)
            n = order.standard_normal((grains // 2, 3))
            n /= np.linalg.norm(n, axis=1, keepdims=True)
            n *= np.sign(np.einsum("ij,ij->i", v[i] - v[j], n))[:, None]
            after = collide(Bodies(mass[i], v[i]), Bodies(mass[j], v[j]), n, contact)
            v[i], v[j] = after.velocity1, after.velocity2
            lost += float(after.loss.sum())
        energies = [0.5 * float(np.sum(mass[:, None] * w**2)) for w in (start, v)]
        drift.append(abs(energies[1] + lost - energies[0]) / energies[0])
        momentum.append(float(np.abs(mass @ (v - start)).max() / np.sum(mass)))
        loss = lost / energies[0]
    return CaseOutcome(
        measured=(
            # Every hit rounds to 1e-16 of the pair's energy; a million at random: 1e3 x 1e-16/1e3
            # grains.
            at_most("drift of the energy after 1e6 elastic hits", drift[0], 1e-12),
            at_most("drift of energy + losses after 1e6 hits, e = .9, mu = .25", drift[1], 1e-12),
            at_most("drift of the momentum, m/s of the whole gas", max(momentum), 1e-13),
            no_more("fraction of the energy lost with e = .9", loss, 1.0),
        )
    )


def moving_wall() -> CaseOutcome:
    """A grain struck by a moving wall: the loss is defined in the wall's frame, the work is impulse
    times wall velocity.
    """
    rng = stream(SEED, "hard", "wall")
    count = 2000
    speed = rng.uniform(-3.0, 3.0, count)
    e = rng.uniform(0.0, 1.0, count)
    v = rng.standard_normal((count, 3))
    wall = np.zeros((count, 3))
    wall[:, 0] = speed
    after = collide(
        Bodies(1.0, v), Bodies(np.inf, wall), np.tile(UNIT[0], (count, 1)), Contact(e, 0.3)
    )
    gain = 0.5 * np.sum(after.velocity1**2 - v**2, axis=1)
    work = -np.einsum("ij,ij->i", after.impulse, wall)
    hit = after.impulse[:, 0] > 0.0
    return CaseOutcome(
        measured=(
            at_most(
                "work of the wall less gain and loss, J of 1 kg",
                np.abs(work - gain - after.loss).max(),
                1e-13,
            ),
            at_most("most negative loss, J", -after.loss.min(), 0.0),
        ),
        naive=(
            at_least(
                "fraction of hits whose loss is negative in the laboratory's frame",
                float((gain[hit] > 0).mean()),
                0.2,
            ),
        ),
    )


def _head_on(m1: float, m2: float, v: tuple[float, float], e: float) -> collision.AfterCollision:
    first, second = Bodies(m1, [[v[0], 0.0, 0.0]]), Bodies(m2, [[v[1], 0.0, 0.0]])
    return collide(first, second, UNIT[:1], Contact(e))


def _rational(
    m1: Fraction, m2: Fraction, v: tuple[float, float], e: float
) -> tuple[Fraction, Fraction, Fraction]:
    """Return the velocities after a head-on hit and the energy lost, exactly, from momentum,
    restitution and energies.
    """
    a, b, q = Fraction(v[0]), Fraction(v[1]), Fraction(e)
    mean = (m1 * a + m2 * b) / (m1 + m2)
    after = mean - m2 / (m1 + m2) * q * (a - b), mean + m1 / (m1 + m2) * q * (a - b)
    loss = (m1 * (a**2 - after[0] ** 2) + m2 * (b**2 - after[1] ** 2)) / 2
    return *after, loss


def _random_pairs(
    rng: np.random.Generator, count: int, spins: bool
) -> tuple[Bodies, Bodies, Array]:
    normal = rng.standard_normal((count, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    normal[: count // 10] = UNIT[2]
    sides = []
    for _ in range(2):
        mass = 10.0 ** rng.uniform(-3.0, 3.0, count)
        velocity, spin = rng.standard_normal((2, count, 3))
        radius = rng.uniform(0.1, 2.0, count)
        sides.append(Bodies(mass, velocity, radius, spin) if spins else Bodies(mass, velocity))
    return sides[0], sides[1], normal


def _energy(body: Bodies, velocity: object, spin: object) -> Array:
    """Return the translational and rotational energy of each body."""
    mass = np.asarray(body.mass)
    energy = 0.5 * mass * np.sum(np.square(velocity), axis=1)  # type: ignore[call-overload]
    if body.radius is not None:
        energy = energy + 0.2 * mass * np.square(body.radius) * np.sum(np.square(spin), axis=1)  # type: ignore[call-overload]
    return np.asarray(energy)


CASES = (
    Case(
        "vertical normals, coincident centres, no slip",
        "0/0 in the axes; a velocity out of sgn(0)",
        "a defined result, nothing out of nothing",
        degenerate,
    ),
    Case(
        "mass ratio 1e-12 to 1e12, infinite mass",
        "an ill-conditioned system; digits lost in differences",
        "the exact law to round-off",
        mass_ratio,
    ),
    Case(
        "e = 0, e = 1, mu = 0, mu > 1",
        "friction that drives the slip on and makes energy",
        "no energy made; e and Coulomb's law kept, capped where the slip stops",
        limits_of_coefficients,
    ),
    Case(
        "a million hits",
        "energy that leaks or grows hit by hit",
        "energy and losses add up over all of them",
        elastic_gas,
    ),
    Case(
        "moving wall",
        "a loss taken in the wrong frame has the wrong sign",
        "loss in the wall's frame, never negative; work = gain + loss",
        moving_wall,
    ),
)
