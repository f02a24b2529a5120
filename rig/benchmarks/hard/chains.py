"""Hard cases of files of grains: `rig.theory.chain`, hit by hit."""

from decimal import Decimal

import numpy as np

from daq.random_streams import stream
from rig.benchmarks.hard.case import Case, CaseOutcome, at_least, at_most, exactly, no_more
from rig.benchmarks.hard.exact import precise
from rig.kernels.chain import MOST_HITS, collide_file
from rig.theory.chain import (
    COLLAPSE,
    LONGEST_ROW,
    TooManyHits,
    chain_collision,
    row_restitution,
)

SEED = 2015


def collapse() -> CaseOutcome:
    """Files of 4 to 20 grains with n (1 - e) from 3 to 4, thrown onto a wall: infinitely many hits
    in finite time.
    """
    files = (
        (4, 0.2),
        (6, 0.4),
        (8, 0.5),
        (10, 0.6),
        (10, 0.69),
        (12, 0.7),
        (20, 0.8),
        (20, 0.84),
        (20, 0.85),
    )
    most, balance, least, flagged = 0, 0.0, 1.0, 0
    for n, e in files:
        after = chain_collision(np.ones(n), e, -1.0, restitution_wall=0.75)
        kinetic = 0.5 * float(np.sum(after.velocity**2))
        most = max(most, after.hits)
        balance = max(balance, abs(kinetic + after.loss + after.wall_loss - 0.5 * n) / (0.5 * n))
        least = min(least, (after.loss + after.wall_loss) / (0.5 * n))
        flagged += after.elastic_hits > 0
    without = chain_collision(np.ones(10), 0.6, -1.0, restitution_wall=0.75, contact_time=0.0).hits
    return CaseOutcome(
        measured=(
            at_most("energy that is neither left nor accounted for, as a fraction", balance, 1e-12),
            at_least(
                "fraction of the energy lost, least of the files (collapse loses all)", least, 0.9
            ),
            no_more("hits", most, 1e5),
            exactly("files that tell of elastic hits, of 9", flagged, 9.0),
            exactly(
                "plastic rows, e_row = 0, from n (1 - e) = 2.5 on, of 4",
                sum(row_restitution(n, 1 - COLLAPSE / n, 0.75) == 0.0 for n in (5, 25, 250, 10**6)),
                4.0,
            ),
        ),
        naive=(at_least("10 grains, e = .6, followed to 1e-12 of the speed: hits", without, 2e5),),
    )


def no_end() -> CaseOutcome:
    """Files that cannot be followed end in a named error: a collapse without contact time, a row
    too long and too elastic.
    """
    named = 0
    try:
        chain_collision(np.ones(24), 0.8, -1.0, restitution_wall=0.75, contact_time=0.0)
    except TooManyHits:
        named += 1
    for grains in (LONGEST_ROW + 1, 10**6):
        try:
            row_restitution(grains, 1.0 - 1.0 / grains, 0.75)
        except TooManyHits:
            named += 1
    return CaseOutcome(
        measured=(
            exactly(
                f"refused by name (TooManyHits after {MOST_HITS:.0e} hits or beforehand), of 3",
                named,
                3.0,
            ),
        )
    )


def rebound() -> CaseOutcome:
    """Rows that do not collapse: every hit of up to 1034 against forty digits."""
    worst, hits = 0.0, 0
    for n, e in ((2, 0.5), (10, 0.8), (16, 0.9), (24, 0.9), (40, 0.99)):
        exact, count = _decimal_rebound(n, Decimal(e), Decimal("0.75"))
        worst = max(worst, abs(row_restitution(n, e, 0.75) - float(exact)))
        hits = max(hits, count)
    density = []
    for n, e in ((100, 0.976), (100, 0.99), (200, 0.988), (200, 1.0)):
        _, _, count, _ = collide_file(
            np.ones(n), np.full(n - 1, e), True, 0.75, np.arange(1.0, n + 1.0), -np.ones(n), 0.0
        )
        density.append(count / n**2)
    return CaseOutcome(
        measured=(
            at_most("error of e_row, 40 digits", worst, 1e-12),
            no_more("hits over n², to 200 grains", max(density), 2.5),
            at_least("hits of the longest file followed in 40 digits", hits, 1000),
        )
    )


def extreme_chains() -> CaseOutcome:
    """150 random files: mass ratios to 1e6 between neighbours, e of each contact 0 to 1, with and
    without a wall.
    """
    rng = stream(SEED, "hard", "chains")
    energy, momentum, closing, most, given_up = 0.0, 0.0, 0.0, 0, 0
    for k in range(150):
        n = int(rng.integers(2, 31))
        mass = 10.0 ** rng.uniform(-3.0, 3.0, n)
        e = rng.choice([0.0, 1.0, rng.uniform()], n - 1)
        v = rng.standard_normal(n)
        walled = k % 2 == 0
        try:
            after = chain_collision(
                mass, e, v, 0.5 if walled else None, gaps=rng.uniform(0.5, 1.5, n)
            )
        except TooManyHits:
            given_up += 1
            continue
        before = 0.5 * float(np.sum(mass * v**2))
        left = 0.5 * float(np.sum(mass * after.velocity**2))
        energy = max(energy, abs(left + after.loss + after.wall_loss - before) / before)
        if not walled:
            momentum = max(
                momentum, abs(float(mass @ (after.velocity - v))) / float(mass @ np.abs(v))
            )
        closing = max(closing, float(-np.diff(after.velocity).min()) / np.abs(v).max())
        most = max(most, after.hits)
    cradle = chain_collision(np.ones(50), 1.0, np.eye(50)[0])
    passed = np.abs(cradle.velocity - np.eye(50)[-1]).max()
    return CaseOutcome(
        measured=(
            at_most("energy that does not balance, as a fraction", energy, 1e-11),
            at_most("momentum gained, as a fraction", momentum, 1e-12),
            at_most(
                "neighbours that still close on each other, over the first speed", closing, 1e-11
            ),
            no_more("hits", most, MOST_HITS),
            no_more("given up by name, of 150", given_up, 3.0),
            exactly(
                "Newton's cradle of 50: largest departure from handing the velocity on", passed, 0.0
            ),
        )
    )


def _decimal_rebound(n: int, e: Decimal, e0: Decimal) -> tuple[Decimal, int]:
    """Return (mean velocity of n equal grains that fly at -1 onto a wall, hits), event by event in
    forty digits.
    """
    with precise():
        x, v, hits = [Decimal(k + 1) for k in range(n)], [Decimal(-1)] * n, 0
        still = Decimal("1e-12")
        while True:
            waits = [(-x[0] / v[0], 0)] if v[0] < -still else []
            waits += [
                ((x[k] - x[k - 1]) / (v[k - 1] - v[k]), k)
                for k in range(1, n)
                if v[k - 1] - v[k] > still
            ]
            if not waits:
                return sum(v) / n, hits  # type: ignore[return-value]
            wait, k = min(waits)
            x = [a + b * max(wait, Decimal(0)) for a, b in zip(x, v, strict=True)]
            hits += 1
            if k == 0:
                v[0] = -e0 * v[0]
            else:
                mean, half = (v[k - 1] + v[k]) / 2, e * (v[k - 1] - v[k]) / 2
                v[k - 1], v[k] = mean - half, mean + half


CASES = (
    Case(
        "column collapse, n (1 - e) > pi",
        "infinitely many hits in finite time",
        "finite hits, all energy accounted for, the cut reported",
        collapse,
    ),
    Case(
        "files that cannot be followed",
        "an endless loop, or a number after the loop was cut",
        "a named error",
        no_end,
    ),
    Case(
        "rows that do not collapse",
        "hits that come in the wrong order, energy left in",
        "e_row to round-off",
        rebound,
    ),
    Case(
        "random files, mass ratio 1e6, e = 0 and 1",
        "anything",
        "energy and momentum balance, all apart at the end",
        extreme_chains,
    ),
)
