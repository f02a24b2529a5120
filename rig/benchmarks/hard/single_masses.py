"""Hard cases of bed `single_mass`: `rig.kernels.single_mass.many_cycles`.

Units of the waveform: m (A/w)^2 for energies, A/g for levels.
"""

import math
from dataclasses import replace
from decimal import Decimal
from itertools import product

import numpy as np
from numpy.typing import NDArray

from daq.random_streams import stream
from rig.benchmarks.hard import naive
from rig.benchmarks.hard.case import Case, CaseOutcome, at_least, at_most, exactly, no_more
from rig.benchmarks.hard.exact import (
    PI,
    STEP,
    Flight,
    bounces,
    cosine_and_sine,
    precise,
    root,
    single_mass_on_floor,
)
from rig.benchmarks.hard.sliders import STUCK, block
from rig.kernels.single_mass.many_cycles import MassCycles, MeanCycle, run, steady
from rig.kernels.single_mass.one_cycle import MAX_EVENTS, State, world
from rig.kernels.waveform import extrema, motion
from rig.theory.single_mass import MassInGap, single_mass_total
from rig.theory.total import TooManyEvents

Array = NDArray[np.float64]

SEED = 2015
SINE = (np.ones(1), np.zeros(1))
REST = State(0, 0.0, 0.0)
INF = math.inf


def settled(
    weight: float, lid: float = INF, e: float = 0.0, band: float = 0.0, low: float = 0.0
) -> MeanCycle:
    """Return the mean cycle of a single mass that starts at rest on the floor."""
    return steady(REST, *world(weight, band, low, lid, e, *SINE), *SINE)


def lost(found: MeanCycle) -> float:
    """Return W per cycle."""
    return found.friction + found.collision


def followed(
    weight: float, cycles: int, lid: float = INF, e: float = 0.0, start: State = REST
) -> MassCycles:
    """Follow a single mass cycle by cycle."""
    return run(start, *world(weight, 0.0, 0.0, lid, e, *SINE), *SINE, cycles)


def barely() -> CaseOutcome:
    """Gamma = 1, a little below and above it."""
    worst = 0.0
    for level in (1.0001, 1.001, 1.01, 1.1):
        weight = 1.0 / level
        with precise():
            exact = single_mass_on_floor(Decimal(weight), 1, Decimal(0), Decimal(0)).lost[0]
        worst = max(worst, abs(lost(settled(weight)) / float(exact) - 1.0))
    finite = [
        lost(settled(1.0 / level)) for level in (1.0, *(1.0 + 10.0**-k for k in range(5, 16)))
    ]
    below = max(
        lost(settled(1.0 / level)) for level in (0.1, 0.9, 0.999999, float(np.nextafter(1.0, 0.0)))
    )
    coarse = naive.single_mass(1.01, 1000, 3) / lost(settled(1.0 / 1.01)) - 1.0
    return CaseOutcome(
        measured=(
            at_most("relative error of W, 1.0001 to 1.1, 40 digits", worst, 1e-9),
            exactly("W below Gamma = 1", below, 0.0),
            at_most("W at Gamma = 1 + 1e-5 to 1 + 1e-15 and 1, m V²", max(finite), 1e-12),
            exactly(
                "of these not finite or negative", sum(not 0.0 <= w < INF for w in finite), 0.0
            ),
        ),
        naive=(
            at_least("1000 steps per cycle, Gamma = 1.01: relative error of W", abs(coarse), 0.05),
        ),
    )


def grazing() -> CaseOutcome:
    """Both edges of the first locking band: landing as the floor begins to push off; the orbit that
    doubles.
    """
    low, high = math.sqrt(1.0 + math.pi**2), math.sqrt(4.0 + math.pi**2)
    single, period, slow, reported = 0.0, 0, 0.0, 0.0
    for d in (-1e-2, -1e-6, -1e-9, -1e-12, 0.0, 1e-12, 1e-9, 1e-6, 1e-2):
        weight = 1.0 / (low + d)
        found = settled(weight)
        if d > 0.0:
            exact = 2.0 * math.pi**2 * weight**2
        else:
            with precise():
                exact = float(
                    single_mass_on_floor(Decimal(weight), 2, Decimal(0), Decimal(0)).lost[1]
                )
        single = max(single, abs(lost(found) / exact - 1.0))
        period += found.period != 1
    for d in (-1e-2, -1e-3, -1e-6, -1e-12, 0.0):
        found = settled(1.0 / (high + d))
        error = abs(lost(found) * (high + d) ** 2 / (2.0 * math.pi**2) - 1.0)
        slow = max(slow, error if found.period == 0 else 0.0)
        reported = max(reported, error if found.period == 1 else 0.0)
    beyond = settled(1.0 / (high + 1e-2)).period
    return CaseOutcome(
        measured=(
            at_most("about 3.2969: relative error of W, closed form and 40 digits", single, 1e-9),
            exactly("orbits there whose period is not 1, of 9", period, 0.0),
            at_most(
                "below 3.7242, period 1 reported: relative error of W, closed form", reported, 1e-9
            ),
            # At the edge itself the orbit is approached as a power of n: no period is found, and
            # the result states that.
            at_most("at 3.7242, no period reported: relative error of W", slow, 1e-4),
            exactly("period at 3.7242 + .01", beyond, 2.0),
        )
    )


def subharmonic() -> CaseOutcome:
    """Periods of 2 to 18 cycles: one period in 40 digits from the computed state returns to it."""
    back, energy, single, periods = 0.0, 0.0, 0.0, set()
    for level in (4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 20.0):
        weight = 1.0 / level
        found = settled(weight)
        periods.add(found.period)
        _, q, u = followed(weight, 2048).state[-1]
        with precise():
            after = single_mass_on_floor(Decimal(weight), found.period, Decimal(q), Decimal(u))
            total = sum(after.lost, Decimal(0)) / found.period
        back = max(back, abs(float(after.u) - q), abs(float(after.z) - u))
        energy = max(energy, abs(lost(found) / float(total) - 1.0))
        single = max(single, *(abs(float(x / total) - 1.0) for x in after.lost))
    return CaseOutcome(
        measured=(
            at_least("different periods above 1", len(periods - {1}), 4.0),
            at_most("state after one period less the state before, 40 digits", back, 1e-9),
            at_most("relative error of W over whole periods, 40 digits", energy, 1e-9),
        ),
        naive=(at_least("W of a single cycle: relative error, worst", single, 1.0),),
    )


def zeno() -> CaseOutcome:
    """A single mass dropped onto a floor below Gamma = 1, e = .1 to .9: all bounces until rest."""
    energy, most = 0.0, 0
    for e, weight, height in product((0.1, 0.5, 0.9), (1.05, 4.0), (0.01, 2.0)):
        with precise():
            flight = Flight(Decimal(0), Decimal(height), Decimal(0), Decimal(weight))
            hit = flight.first(flight.position, STEP, 100 * PI)
            assert hit is not None
            exact = bounces(
                hit, -flight.velocity(hit), Decimal(weight), Decimal(e), Decimal("1e-15")
            )
        cycles = followed(weight, 64, e=e, start=State(1, height, 0.0))
        energy = max(energy, abs(float(cycles.energy[:, 2].sum()) / float(exact.lost) - 1.0))
        energy = max(energy, abs(cycles.state[-1, 0]))
        most = max(most, int(cycles.counts[:, 0].max()))
    never = followed(1.5, 2000, e=1.0, start=State(1, 2.0, 0.0))
    return CaseOutcome(
        measured=(
            at_most("relative error of the energy lost until rest, 40 digits", energy, 1e-9),
            no_more("events in a cycle", most, MAX_EVENTS),
            exactly("e = 1: energy lost in 2000 cycles", float(never.energy[:, 2].sum()), 0.0),
            no_more("e = 1: events in a cycle", int(never.counts[:, 0].max()), MAX_EVENTS),
        )
    )


def gaps() -> CaseOutcome:
    """A lid just touched, just missed, or directly on the single mass; no weight and gaps from pi
    down to 1e-15.
    """
    weight = 1.0 / 2.5
    free = settled(weight)
    flight = followed(weight, 8)
    apex = _apex(weight)
    missed = abs(lost(settled(weight, apex * (1.0 + 1e-12))) / lost(free) - 1.0)
    touched = abs(lost(settled(weight, apex * (1.0 - 1e-12))) / lost(free) - 1.0)
    still = sum(lost(settled(w, 0.0, e)) for w in (0.0, weight) for e in (0.0, 0.5, 1.0))
    worst = 0.0
    for gap in (math.pi, 3.0, 1.0, *(10.0**-k for k in range(1, 16))):
        with precise():
            length = Decimal(gap)
            t = root(
                lambda t, g=length: t - cosine_and_sine(t)[1] - g,  # type: ignore[misc]
                Decimal("1e-8"),
                PI + Decimal("1e-9"),
            )
            exact = float((1 - cosine_and_sine(t)[0]) ** 2)
        worst = max(worst, abs(lost(settled(0.0, gap)) / exact - 1.0))
    assert len(flight.state) == 8
    return CaseOutcome(
        measured=(
            at_most("lid at 1 + 1e-12 of the apex: relative change of W", missed, 1e-12),
            # A lid at 1 - d of the apex is hit at sqrt(2 g d h), which is 1e-6 of the speed.
            at_most("lid at 1 - 1e-12 of the apex: relative change of W", touched, 1e-4),
            exactly("W without a gap", still, 0.0),
            at_most("no weight, gaps pi to 1e-15: relative error of W, 40 digits", worst, 1e-9),
        )
    )


def reversal() -> CaseOutcome:
    """A block on a rough floor without walls: the same law as for rows in another kernel."""
    near = [10.0**-k for k in range(1, 13)]
    relative, absolute = 0.0, 0.0
    for eta in (
        STUCK,
        *(STUCK * (1 + d) for d in near),
        *(STUCK * (1 - d) for d in near),
        *(1 - d for d in near),
    ):
        with precise():
            exact = float(block(Decimal(eta)))
        found = lost(settled(0.0, INF, band=eta, low=-INF))
        absolute = max(absolute, abs(found - exact))
        relative = max(relative, abs(found / exact - 1.0) if exact > 1e-12 else 0.0)
    above = sum(
        lost(settled(0.0, INF, band=eta, low=-INF)) for eta in (1.0, *(1 + d for d in near), 5.0)
    )
    return CaseOutcome(
        measured=(
            at_most("relative error of W, 40 digits, W > 1e-12 m V²", relative, 1e-9),
            at_most("error of W, units of m V², 1 - eta down to 1e-12", absolute, 1e-12),
            at_most("W at and above eta = 1", above, 1e-30),
        )
    )


def touching() -> CaseOutcome:
    """Friction equal to an extremum of a waveform with up to four harmonics, and 1 to 3 bits beside
    it: 1000 single masses.
    """
    rng = stream(SEED, "hard", "touching")
    closure, most = 0.0, 0.0
    for k in range(1000):
        size = int(rng.integers(1, 5))
        wave = (
            np.concatenate(([1.0], 0.3 * rng.standard_normal(size - 1))),
            0.3 * rng.standard_normal(size),
        )
        band = float(rng.choice([abs(motion(t, *wave)[2]) for t in extrema(*wave)]))
        for _ in range(rng.integers(0, 4)):
            band = float(np.nextafter(band, 9.0 if k % 2 else 0.0))
        gap = float(rng.choice([INF, 1.0, 0.01]))
        found = run(REST, *world(0.0, band, 0.0 if gap < INF else -INF, gap, 0.5, *wave), *wave, 10)
        first = 0.5 * motion(0.0, *wave)[1] ** 2
        left = found.energy[:, :3] @ [1.0, -1.0, -1.0] - np.diff(found.energy[:, 3], prepend=first)
        closure = max(closure, float(np.abs(left).max()))
        most = max(most, float(found.energy[:, 1:3].sum(axis=1).max()))
    return CaseOutcome(
        measured=(
            at_most("energy that does not close in a cycle, m V²", closure, 1e-12),
            no_more("energy lost in a cycle, m V²", most, 20.0),
        )
    )


def ceiling() -> CaseOutcome:
    """No lid: the mean force is m g and the box moves at V at most, so that W <= m g V/f for any
    orbit.
    """
    over, reached = -INF, 0.0
    for e in (0.0, 0.3, 0.6, 0.9):
        for level in np.geomspace(1.001, 50.0, 120):
            found = steady(REST, *world(1.0 / level, 0.0, 0.0, INF, e, *SINE), *SINE, 256, 512)
            ratio = lost(found) * level / (2.0 * math.pi)
            over, reached = max(over, ratio - 1.0), max(reached, ratio)
    return CaseOutcome(
        measured=(
            at_most("W beyond m g V/f, as a fraction, 480 single masses", over, 0.0),
            at_least("of it reached", reached, 0.99),
        )
    )


def too_often() -> CaseOutcome:
    """e near 1 in a tiny gap: a named error before it takes long."""
    named, single_mass = 0, MassInGap(1.0, 0.0, 1e-15, 0.0, 0.0, 1.0, 0.0, 0.0)
    for e, gap in ((1.0, 1e-15), (0.9999, 1e-15), (1.0, 1e-12)):
        try:
            single_mass_total(replace(single_mass, high=gap, restitution=e), 5.0, 20.0)
        except TooManyEvents:
            named += 1
    return CaseOutcome(measured=(exactly("refused by name (TooManyEvents), of 3", named, 3.0),))


def neighbourhood() -> CaseOutcome:
    """500 random single masses, 10 cycles each: weight, friction or neither, gaps 1e-2 to 1e3, e 0
    to 1, starts in the air.
    """
    rng = stream(SEED, "hard", "slugs")  # the first name: the same drawn cases
    gone, outside, negative, closure, most, refused = 0, 0.0, 0.0, 0.0, 0, 0
    for _ in range(500):
        size = int(rng.integers(1, 5))
        wave = (
            np.concatenate(([1.0], 0.3 * rng.standard_normal(size - 1))),
            0.3 * rng.standard_normal(size),
        )
        kind = rng.integers(3)
        weight = 10.0 ** rng.uniform(-2.0, 0.3) if kind == 0 else 0.0
        band = rng.uniform(0.0, 1.2) if kind == 1 else 0.0
        gap = 10.0 ** rng.uniform(-2.0, 3.0) if rng.random() < 0.8 else INF
        e = float(rng.choice([0.0, 1.0, rng.uniform()]))
        q = rng.uniform(0.0, min(gap, 10.0))
        start = State(0, q, 0.0) if band else State(1, q, float(rng.standard_normal()))
        found = run(
            start,
            *world(weight, band, 0.0 if weight or gap < INF else -INF, gap, e, *wave),
            *wave,
            10,
        )
        if (found.counts[:, 0] < 0).any():
            refused += 1
            continue
        gone += not (np.isfinite(found.state).all() and np.isfinite(found.energy).all())
        if gap < INF:
            outside = max(
                outside, float(-found.state[:, 1].min()), float(found.state[:, 1].max() - gap)
            )
        negative = max(negative, float(-found.energy[:, 1:3].min()))
        first = 0.5 * (motion(0.0, *wave)[1] + start.u) ** 2 + weight * start.q
        left = found.energy[:, :3] @ [1.0, -1.0, -1.0] - np.diff(found.energy[:, 3], prepend=first)
        closure = max(closure, float(np.abs(left).max() / max(1.0, np.abs(found.energy).max())))
        most = max(most, int(found.counts[:, 0].max()))
    return CaseOutcome(
        measured=(
            exactly("single masses with a value that is not finite", gone, 0.0),
            exactly("position outside the gap", max(outside, 0.0), 0.0),
            at_most("most negative loss, m V²", negative, 0.0),
            at_most(
                "energy that does not close in a cycle, as a fraction of the largest", closure, 1e-9
            ),
            no_more("events in a cycle", most, MAX_EVENTS),
            no_more("single masses refused for their events, of 500", refused, 0.0),
        )
    )


def _apex(weight: float) -> float:
    """Return the largest height of the plastic single mass's flight over the floor, 40 digits."""
    with precise():
        c = Decimal(weight)
        start = root(lambda t: cosine_and_sine(t)[1] - c, Decimal(0), PI / 2)
        flight = Flight(start, Decimal(0), Decimal(0), c)
        low = PI - start
        top = flight.first(
            lambda t: flight.velocity(t) if t > low else Decimal(1), STEP, start + 2 * PI
        )
        assert top is not None
        return float(flight.position(top))


CASES = (
    Case(
        "single mass at Gamma = 1.0001",
        "a flight shorter than a step; W below the round-off of F v",
        "W to 1e-9, 0 below 1",
        barely,
    ),
    Case(
        "grazing take-off at 3.2969 and 3.7242",
        "the wrong root, the wrong period",
        "W continuous, period reported",
        grazing,
    ),
    Case(
        "subharmonic single masses",
        "W of one cycle for W",
        "period reported, W over whole periods",
        subharmonic,
    ),
    Case(
        "Zeno chatter of a single mass",
        "bounces without end",
        "all the energy, finite events",
        zeno,
    ),
    Case(
        "lid just touched, gap to 0",
        "a root lost or doubled; cancellation in a gap of 1e-15",
        "W continuous; exact for any gap",
        gaps,
    ),
    Case("rough floor, eta near .537 and 1", "sign chatter of the friction", "W to 1e-9", reversal),
    Case(
        "friction that an extremum just touches",
        "a region of no width taken for a half cycle: the single mass runs away",
        "energy closes",
        touching,
    ),
    Case("ceiling m g V/f", "energy from nothing", "never above, and nearly reached", ceiling),
    Case("e near 1 in a tiny gap", "hours of bounces", "a named error", too_often),
    Case(
        "500 random single masses",
        "anything",
        "finite, inside the gap, no negative loss, closed, bounded events",
        neighbourhood,
    ),
)
