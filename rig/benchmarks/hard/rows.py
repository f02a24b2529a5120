"""Hard cases of one row of bed `layers`, event by event: `rig.kernels.rows.one_row` (m (A/w)^2 for
energies).
"""

import math
from decimal import Decimal

import numpy as np

from daq.random_streams import stream
from rig.benchmarks.hard import naive
from rig.benchmarks.hard.case import Case, CaseOutcome, at_least, at_most, exactly, no_more
from rig.benchmarks.hard.exact import PI, STEP, Flight, arcsine, bounces, precise
from rig.benchmarks.hard.sliders import (
    SINE,
    STUCK,
    Wave,
    block,
    closed_form,
    followed,
    one_row,
    steady,
)
from rig.kernels.rows.many_rows import steady_energy
from rig.kernels.rows.one_row import MAX_EVENTS
from rig.kernels.waveform import extrema, motion
from rig.theory.total import TooManyEvents, layers_total

SEED = 2015


def zeno() -> CaseOutcome:
    """Rows that bounce to rest on the wall they are pressed against: e = .25 to .9, clearances 1e-9
    to .1 X.
    """
    lost, phase, most = 0.0, 0.0, 0
    for clearance, e in (
        (0.1, 0.25),
        (0.1, 0.5),
        (0.01, 0.75),
        (1e-3, 0.75),
        (1e-3, 0.9),
        (1e-6, 0.5),
        (1e-9, 0.75),
    ):
        with precise():
            flight = Flight(Decimal(0), Decimal(0), Decimal(0), Decimal(0))
            hit = flight.first(
                lambda t, f=flight, p=Decimal(clearance): p - f.position(t),  # type: ignore[misc]
                STEP,
                PI,
            )
            assert hit is not None
            exact = bounces(
                hit + PI, flight.velocity(hit), Decimal(0), Decimal(e), Decimal("1e-18")
            )
        ends, happened = followed(one_row(0.0, clearance, e), 1)
        lost = max(lost, abs(ends[0].collision - 2.0 * float(exact.lost)))
        at_rest = happened[0].phase[happened[0].mode == 0][0]
        left = 2e-6 / ((1.0 - e) * math.sin(at_rest))
        phase = max(phase, abs(at_rest - float(exact.phase - PI)) / left)
        most = max(most, ends[0].events)
    return CaseOutcome(
        measured=(
            # A rebound below 1e-6 is cut off: 5e-13 of energy, and flights of 2e-6 e^k over the
            # push.
            at_most("error of the energy lost, 40 digits, units of m V²", lost, 2e-12),
            no_more("error of the phase of rest over 2e-6/((1 - e) push), 40 digits", phase, 1.0),
            no_more("events in a cycle", most, MAX_EVENTS),
        ),
        naive=(
            at_least(
                "1000 steps per cycle: depth inside the wall after 4 cycles, X",
                naive.pressed(0.5, 1000, 4),
                0.05,
            ),
        ),
    )


def take_off() -> CaseOutcome:
    """A gap that opens as t^3: 2000 rows, thrown twice a cycle, without a single impact caused by
    round-off.
    """
    rng = stream(SEED, "hard", "take-off")
    false, slides = 0, 0
    for band, clearance in zip(
        rng.uniform(0.0, 0.99, 2000), 10.0 ** rng.uniform(-2.0, 1.0, 2000), strict=True
    ):
        _, happened = followed(one_row(band, clearance, 0.0), 3)
        for events in happened:
            thrown = np.flatnonzero(events.mode[:-1] != 0)
            slides += thrown.size
            # The shortest slides: with band .99 stopped after 3 x (pi/2 - asin .99) = .4 rad;
            # across .01 X after (6 x .01)^(1/3) rad.
            false += int(np.sum(np.diff(events.phase)[thrown] < 0.05))
    return CaseOutcome(
        measured=(
            exactly("slides that end within 0.05 rad", false, 0.0),
            at_least("slides looked at", slides, 7000),
        ),
        naive=(
            at_least(
                "sign of the gap: fraction of the first 1e-5 rad in which it is closed again",
                naive.false_contacts(0.3, 10_001),
                0.05,
            ),
        ),
    )


def reversal() -> CaseOutcome:
    """A block on a rough floor near eta = .537, where it begins to stick, and near 1, where it
    ceases to slide.
    """
    near = [10.0**-k for k in range(1, 13)]
    etas = [
        STUCK,
        *(STUCK * (1 + d) for d in near),
        *(STUCK * (1 - d) for d in near),
        *(1 - d for d in near),
    ]
    absolute, relative = 0.0, 0.0
    for eta in etas:
        with precise():
            exact = float(block(Decimal(eta)))
        found, _ = steady(eta, 1e6, average=512)
        absolute = max(absolute, abs(found - exact))
        if exact > 1e-3:
            relative = max(relative, abs(found / exact - 1.0))
    above = max(steady(eta, 1e6)[0] for eta in (1.0, *(1 + d for d in near), 1.0 + 2.3e-16, 5.0))
    return CaseOutcome(
        measured=(
            at_most("relative error of W, 40 digits, W > 1e-3 m V²", relative, 1e-9),
            # Where W falls to 1e-30, the round-off of positions near 1 dominates.
            at_most("error of W, units of m V², 1 - eta down to 1e-12", absolute, 1e-9),
            exactly("W at and above eta = 1", above, 0.0),
        ),
        naive=(
            at_least(
                "steps with sign(z), 500 per cycle: W at eta = 1.05, which is 0",
                naive.friction_block(1.05, 500, 3),
                1e-3,
            ),
            at_least(
                "the same at eta = .537: relative error",
                abs(naive.friction_block(STUCK, 500, 20) / closed_form(STUCK) - 1.0),
                1e-4,
            ),
        ),
    )


def at_the_peak() -> CaseOutcome:
    """A threshold equal to the waveform's peak, one bit below and above it, pure and with
    harmonics; Gamma = 1.0001.
    """
    waves: tuple[Wave, ...] = (
        SINE,
        (np.array([1.0, 0.0, 0.2]), np.array([0.0, 0.0, -0.1])),
        (np.array([0.7, 0.3, -0.2, 0.05]), np.array([0.1, 0.0, 0.3, -0.02])),
    )
    at_peak, below, finite = 0.0, 0.0, 0
    for wave in waves:
        peak = max(abs(motion(t, *wave)[2]) for t in extrema(*wave))
        for e in (0.0, 0.5):
            at_peak = max(
                at_peak,
                steady(peak, 1.0, e, wave=wave)[0],
                steady(np.nextafter(peak, 9.0), 1.0, e, wave=wave)[0],
            )
            for step in range(1, 9):
                W, _ = steady(peak * (1 - 10.0 ** (-2 * step)), 1.0, e, wave=wave)
                finite += math.isfinite(W) and W >= 0.0
            below = max(below, steady(np.nextafter(peak, 0.0), 1.0, e, wave=wave)[0])
    band = 1 / 1.0001
    with precise():
        exact = float(block(Decimal(band)))
    found, _ = steady(band, 1e3)
    return CaseOutcome(
        measured=(
            exactly("W at the peak and above", at_peak, 0.0),
            at_most("W one bit below the peak", below, 1e-15),
            exactly("finite, not negative, of 48 thresholds below the peak", finite, 48.0),
            # W = 7e-8 there: the round-off of positions near 1, 2e-16, over a slip of 4e-8.
            at_most(
                "level 1.0001 of the threshold: relative error of W, 40 digits",
                abs(found / exact - 1.0),
                1e-7,
            ),
        )
    )


def vanishing_clearance() -> CaseOutcome:
    """Plays from .1 X down to 1e-16 X: W_f = 2 band clearance, and the energy of the hits, of order
    clearance^(4/3).
    """
    rubbed, collided, energy, clearance_of = 0.0, 0.0, 0.0, [10.0**-k for k in range(1, 17)]
    for band in (0.0, 0.1, 0.5, 0.9):
        for clearance in clearance_of:
            friction, collision, period = (
                float(x[0]) for x in steady_energy(one_row(band, clearance, 0.0), *SINE, 64)
            )
            assert period == 1
            with precise():
                start = arcsine(Decimal(band))
                flight = Flight(start, Decimal(0), Decimal(0), Decimal(band))
                step = STEP / 64
                hit = flight.first(
                    lambda t, f=flight, p=Decimal(clearance): p - f.position(t),  # type: ignore[misc]
                    step,
                    start + PI,
                )
                if hit is None or flight.velocity(hit) <= 0:
                    continue  # friction stops the row before the wall
                exact = float(flight.velocity(hit) ** 2)
            if band:
                rubbed = max(rubbed, abs(friction / (2.0 * band * clearance) - 1.0))
            collided = max(collided, abs(collision - exact))
            if clearance >= 1e-9:
                energy = max(
                    energy, abs((friction + collision) / (2.0 * band * clearance + exact) - 1.0)
                )
    refused = 0
    for clearance in (1e-6, 1e-9):
        try:
            layers_total(
                np.zeros(1),
                np.array([[clearance * 10.0 / (40.0 * np.pi) ** 2]]),
                1.0,
                1.0,
                10.0,
                20.0,
            )
        except TooManyEvents:
            refused += 1
    return CaseOutcome(
        measured=(
            at_most("relative error of W_f down to 1e-16 X", rubbed, 1e-14),
            at_most("error of W_c, units of m V², 40 digits", collided, 1e-14),
            # The gap is a difference of positions near 1: 2e-16 over a clearance of 1e-9 is 2e-7 of
            # the gap.
            at_most("relative error of W down to 1e-9 X", energy, 1e-6),
            exactly(
                "e = 1, mu = 0 in 1e-6 and 1e-9 X: refused by name (TooManyEvents), of 2",
                refused,
                2.0,
            ),
        )
    )


CASES = (
    Case(
        "Zeno chatter of a row",
        "an event loop that stalls, or steps through the wall",
        "finite events, energy to the cut-off, phase of rest",
        zeno,
    ),
    Case("take-off", "round-off of a gap that opens as t³ fakes impacts", "none", take_off),
    Case(
        "friction reversal, eta near .537 and 1",
        "sign chatter of the friction; W where nothing slides",
        "W to 1e-9; exactly 0 from eta = 1 on",
        reversal,
    ),
    Case(
        "threshold at the peak of the waveform; level 1.0001",
        "a slide where none is, a root lost",
        "0 at the peak, finite and small below, W of the least slide",
        at_the_peak,
    ),
    Case(
        "clearance to 0",
        "positions near 1 swallow the clearance; bouncing without end",
        "W_f exact, W_c to round-off; a named error for what cannot be followed",
        vanishing_clearance,
    ),
)
