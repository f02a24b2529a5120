"""Hard cases of the orbits of rows: the quantity averaged, and the length of the average.

Kernel: `rig.kernels.rows.many_rows`; energies in m (A/w)^2.
"""

import math
from decimal import Decimal

import numpy as np

from daq.random_streams import stream
from rig.benchmarks.hard.case import Case, CaseOutcome, at_least, at_most, exactly, no_more
from rig.benchmarks.hard.exact import plastic_row, precise
from rig.benchmarks.hard.sliders import closed_form, followed, one_row, steady
from rig.kernels.rows.many_rows import LONGEST_SPAN
from rig.kernels.rows.one_row import MAX_EVENTS
from rig.kernels.waveform import extrema, motion

SEED = 2015


def wide_clearance() -> CaseOutcome:
    """Rows that take many cycles to cross: no wall within one average, little or no friction."""
    worst, refused = 0.0, 0
    naive_zero = _cut_short(0.0, 1000.0)
    for band in (0.0, 1e-4, 1e-3):
        clearances = np.geomspace(30.0, 400.0, 30)
        short = sum(steady(band, clearance, average=64)[0] for clearance in clearances)
        long = sum(steady(band, clearance, average=4096)[0] for clearance in clearances)
        worst = max(worst, abs(short / long - 1.0))
    block, _ = steady(0.01, 1e9)
    for band, clearance in ((0.0, 405.0), (0.0, 1e9), (1e-4, 1e9), (0.0, 1e300)):
        refused += steady(band, clearance)[1] == -2
    return CaseOutcome(
        measured=(
            # 30 rows without a period, 16 crossings each, whose energies scatter by a half:
            # 0.5/sqrt(16 x 30), 2 sigma.
            at_most(
                "relative error of W of 30 rows, 30 to 400 X, against 4096 cycles", worst, 0.05
            ),
            at_most(
                "block of eta = .01, no wall in reach: relative error of W, closed form",
                abs(block / closed_form(0.01) - 1.0),
                1e-4,
            ),
            exactly(
                f"rows that take more than {LONGEST_SPAN} cycles to cross, refused, of 4",
                refused,
                4.0,
            ),
        ),
        naive=(
            exactly(
                "64 cycles after 64: W of a frictionless row in 1000 X (right: .0056)",
                naive_zero,
                0.0,
            ),
        ),
    )


def elastic() -> CaseOutcome:
    """e = 1 without friction: no losses, while the box may give and take energy; 10^4 cycles."""
    closure, lost, fastest = 0.0, 0.0, 0.0
    for clearance in (0.5, 1.0, 3.0, 10.0):
        ends, _ = followed(one_row(0.0, clearance, 1.0), 10_000)
        kinetic = 0.5 * np.concatenate(([1.0], [1.0 + end.z for end in ends])) ** 2
        work = np.array([end.work for end in ends])
        closure = max(closure, float(abs(work.sum() - (kinetic[-1] - kinetic[0]))))
        lost = max(lost, float(sum(end.collision + end.friction for end in ends)))
        fastest = max(fastest, float(np.sqrt(2.0 * kinetic).max()))
        if len(ends) < 10_000:
            closure = math.nan
    return CaseOutcome(
        measured=(
            at_most("work of the box less kinetic energy after 10^4 cycles, m V²", closure, 1e-9),
            # Rebounds below 1e-6 are cut off, which loses 5e-13 each.
            at_most("energy lost, m V²", lost, 1e-9),
            no_more("fastest row, in V", fastest, 100.0),
        )
    )


def subharmonic() -> CaseOutcome:
    """Rows with periods 2, 3 and more: W over whole periods, against event-by-event motion in 40
    digits.
    """
    band, found = 0.02, dict[int, float]()
    for clearance in np.linspace(3.2, 9.0, 60):
        _, period = steady(band, float(clearance))
        if period > 1:
            found.setdefault(period, float(clearance))
    worst, single = 0.0, 0.0
    for period, clearance in sorted(found.items())[:3]:
        W, _ = steady(band, clearance)
        with precise():
            cycles = plastic_row(Decimal(band), Decimal(clearance), 16 + period)
        exact = float(sum(cycles[-period:])) / period
        worst = max(worst, abs(W / exact - 1.0))
        single = max(single, max(abs(float(lost) / exact - 1.0) for lost in cycles[-period:]))
    return CaseOutcome(
        measured=(
            at_least("different periods above 1 among 60 clearances", len(found), 3.0),
            at_most("relative error of W over whole periods, 40 digits", worst, 1e-9),
        ),
        naive=(at_least("W of a single cycle: relative error, worst", single, 0.2),),
    )


def touching() -> CaseOutcome:
    """A threshold equal to an extremum of a waveform with up to four harmonics, and up to 3 bits
    beside it: 1000 rows.
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
        ends, _ = followed(one_row(band, float(rng.choice([1e3, 1.0, 0.01])), 0.5, wave), 10, wave)
        state = np.array([(e.z, e.work, e.friction, e.collision) for e in ends])
        kinetic = 0.5 * (motion(0.0, *wave)[1] + np.concatenate(([0.0], state[:, 0]))) ** 2
        closure = max(
            closure, float(np.abs(state[:, 1] - state[:, 2] - state[:, 3] - np.diff(kinetic)).max())
        )
        most = max(most, float(state[:, 2:].sum(axis=1).max()))
    return CaseOutcome(
        measured=(
            at_most("energy that does not close in a cycle, m V²", closure, 1e-12),
            no_more("energy lost in a cycle, m V²", most, 20.0),
        )
    )


def neighbourhood() -> CaseOutcome:
    """3000 random rows, 20 cycles each: bands to 1, clearances 1e-8 to 1e3 X, e to .95, one to four
    harmonics.
    """
    rng = stream(SEED, "hard", "rows")
    gone, outside, negative, closure, most, refused = 0, 0.0, 0.0, 0.0, 0, 0
    for _ in range(3000):
        size = int(rng.integers(1, 5))
        wave = (
            np.concatenate(([1.0], 0.3 * rng.standard_normal(size - 1))),
            0.3 * rng.standard_normal(size),
        )
        clearance = 10.0 ** rng.uniform(-8.0, 3.0)
        band = rng.uniform(0.0, 1.0) if rng.random() < 0.7 else 10.0 ** rng.uniform(-9.0, 0.0)
        rows = one_row(band, clearance, rng.uniform(0.0, 0.95) if rng.random() < 0.7 else 0.0, wave)
        ends, _ = followed(rows, 20, wave)
        refused += len(ends) < 20
        if not ends:
            continue
        state = np.array([(e.u, e.z, e.work, e.friction, e.collision, e.events) for e in ends])
        gone += not np.isfinite(state).all()
        outside = max(outside, float(-state[:, 0].min()), float(state[:, 0].max() - clearance))
        negative = max(negative, float(-state[:, 3:5].min()))
        start = motion(0.0, *wave)[1]
        kinetic = 0.5 * (start + np.concatenate(([0.0], state[:, 1]))) ** 2
        closure = max(
            closure, float(np.abs(state[:, 2] - state[:, 3] - state[:, 4] - np.diff(kinetic)).max())
        )
        most = max(most, int(state[:, 5].max()))
    return CaseOutcome(
        measured=(
            exactly("rows with a value that is not finite", gone, 0.0),
            exactly("position outside the clearance, in X", max(outside, 0.0), 0.0),
            at_most("most negative loss, m V²", negative, 0.0),
            at_most("energy that does not close in a cycle, m V²", closure, 1e-10),
            no_more("events in a cycle", most, MAX_EVENTS),
            no_more("rows refused for their events, of 3000", refused, 60.0),
        )
    )


def _cut_short(band: float, clearance: float) -> float:
    """Return W from 64 cycles after 64 of settling, whatever the clearance."""
    ends, _ = followed(one_row(band, clearance, 0.0), 128)
    return float(np.mean([end.friction + end.collision for end in ends[64:]]))


CASES = (
    Case(
        "clearance of 1000 amplitudes, little friction",
        "the average ends before the row has crossed: W = 0",
        "W, or a named error",
        wide_clearance,
    ),
    Case(
        "e = 1, mu = 0 in a box",
        "energy out of nothing, or cut away",
        "work = kinetic energy, cycle by cycle",
        elastic,
    ),
    Case(
        "subharmonic rows",
        "W of one cycle for W",
        "the period is reported, W is the mean over whole periods",
        subharmonic,
    ),
    Case(
        "a threshold that an extremum just touches",
        "a region of no width taken for a half cycle: the row runs away",
        "energy closes",
        touching,
    ),
    Case(
        "3000 random rows",
        "anything",
        "finite, inside the clearance, no negative loss, closed, bounded events",
        neighbourhood,
    ),
)
