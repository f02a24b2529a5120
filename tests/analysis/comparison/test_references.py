"""References: known masses, a known dashpot, and what is wrong with the channels by name."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from analytic_record import NOMINAL, OMEGA, Bench, condition, session

from analysis import read_session
from analysis.comparison.references import _bending

LEVELS = (2.0, 3.0, 4.0)
BOX_LOSS, C = 5.0, 60.0  # N s/m
BENCH = Bench(
    channels=dict(NOMINAL),
    noise=(0.02, 5e-4),
    level_error=0.003,
    gains=(1.002, 0.999),
    samples=11 * 512,
)


def made(beds=("empty", "locked", "dashpot"), bench=BENCH, seed=1):
    table = [
        condition(
            f"{bed}{a:g}",
            bed=bed,
            bed_mass=38.1 if bed == "locked" else 0.0,
            acceleration_set=a,
            settle_cycles=2,
            record_cycles=8,
            dashpot_c=C if bed == "dashpot" else None,
        )
        for bed in beds
        for a in LEVELS
    ]
    return session(
        table,
        lambda entry, _r: BOX_LOSS + (entry["dashpot_c"] or 0.0),
        bench,
        np.random.default_rng(seed),
    )


def by_name(report):
    return {row.reference + ", " + row.of: row for row in report.references}


def changed(record, change):
    """The record with (force, acceleration) of every run changed."""
    return dataclasses.replace(
        record, signals={name: change(*both) for name, both in record.signals.items()}
    )


def test_known_masses_and_a_known_dashpot_are_recovered():
    report = read_session(made())
    rows = by_name(report)
    assert list(rows) == [
        "signs, all runs",
        "rigid mass, empty box",
        "rigid mass, bonded bed",
        f"dashpot, c = {C:g} N s/m",
        "phase, rigid, 20 Hz",
    ]
    assert all(row.verdict == "holds" for row in rows.values())
    assert rows["rigid mass, bonded bed"].expected == pytest.approx(11.92 + 38.1)
    expected = sum(math.pi * C * a**2 / OMEGA**3 for a in LEVELS) / 3
    # the expected W is taken at the measured levels: 0.1 % scale and 0.3 %/sqrt(12) level error,
    # squared
    assert rows[f"dashpot, c = {C:g} N s/m"].expected == pytest.approx(expected, rel=0.01)
    assert report.verdict == "passes"


def test_a_scale_beyond_its_certificate_is_found():
    """5 % in the force against U of about 1.7 %; it is no angle."""
    report = read_session(made(bench=dataclasses.replace(BENCH, gains=(1.05, 1.0))))
    found = {row.reference: row.verdict for row in report.references if row.unit}
    assert found == {"rigid mass": "does not hold", "dashpot": "does not hold", "phase": "holds"}
    assert report.verdict == "fails"


@pytest.mark.parametrize("turn", [0.0, 5e-3, -5e-3])
def test_the_ledger_tells_the_angle_of_a_light_box(turn):
    """A box of 0.26 kg that loses 100 N s/m has eta = 3: 5 mrad are 0.16 % of its W, a tenth of U,
    and one run of each level leaves its null one degree of freedom. Beside a scale of 0.3 % the
    angle comes back within its U, of which the pole's 10 % make 1 mrad; where the null has the runs
    (four of each), it tells the same angle."""
    table = [
        condition(
            f"{bed}{a:g}",
            bed=bed,
            box_mass=0.24,
            bed_mass=0.14 if bed == "locked" else 0.0,
            acceleration_set=a,
            settle_cycles=2,
            record_cycles=8,
        )
        for bed in ("empty", "locked")
        for a in LEVELS
    ]
    for repeats in (1, 4):
        bench = dataclasses.replace(BENCH, turn=turn, repeats=repeats)
        report = read_session(session(table, lambda *_: 100.0, bench, np.random.default_rng(1)))
        (phase,) = (row for row in report.references if row.reference == "phase")
        # W = g (E cos d - R sin d), the acceleration's lead d
        assert phase.value == pytest.approx(turn, abs=phase.U)
        assert 0.9e-3 * 1.96 * 0.5 < phase.U < 3e-3
        assert all(abs(row.E_n_truth) < 1 for row in report.conditions)
        assert report.verdict == ("fails" if turn else "passes")
    (null,) = report.nulls
    assert abs(null.dphi - phase.value) < 2 * null.U_dphi


def test_one_condition_or_one_loss_factor_tells_no_angle():
    """Where W/R is the same in all conditions an angle looks like a scale: U is that of the scale
    over eta, 1.6 %/0.003 of a heavy box; one condition has no reference."""
    table = [condition(f"empty{a:g}", bed="empty", bed_mass=0.0, acceleration_set=a, settle_cycles=2, record_cycles=8)
             for a in LEVELS]  # fmt: skip
    for rows, found in ((table, 1), (table[:1], 0)):
        report = read_session(session(rows, lambda *_: 1500.0, BENCH, np.random.default_rng(1)))
        phases = [row for row in report.references if row.reference == "phase"]
        assert len(phases) == found
        assert all(row.U > 0.01 for row in phases)  # 1.6 % of eta = 1500/(w 11.92) = 1.0


def test_a_dashpot_without_an_empty_box_is_not_denied():
    """The box's own 5 N s/m of 65 cannot be told from a wrong coefficient."""
    rows = by_name(read_session(made(("dashpot",))))
    row = rows[f"dashpot, c = {C:g} N s/m"]
    assert row.verdict == "undecided"
    assert "no empty box" in row.why


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f, a: (a, f), "force and acceleration seem swapped"),
        (lambda f, a: (-a, f), "force and acceleration seem swapped"),
        (lambda f, a: (-f, a), "a sign is reversed: the apparent mass is negative"),
        (lambda f, a: (f, -a), "a sign is reversed: the apparent mass is negative"),
        (lambda f, a: (f[::-1], a[::-1]), "the dissipated energy is negative"),
    ],
)
def test_wrong_channels_are_named(change, words):
    """Time reversal turns the phase between force and acceleration about and nothing else."""
    report = read_session(changed(made(), change))
    (signs,) = (row for row in report.references if row.reference == "signs")
    assert signs.verdict == "does not hold"
    assert words in signs.why
    assert report.verdict == "fails"
    assert any(words in reason for reason in report.reasons)


def test_both_signs_reversed_change_nothing():
    report = read_session(changed(made(), lambda f, a: (-f, -a)))
    assert report.verdict == "passes"


@pytest.mark.parametrize("order", [2, 3, 4, 5])
def test_a_quadratic_loss_on_a_distorted_motion_looks_like_mass_by_no_more_than_is_budgeted(order):
    """F = v|v| of v = cos t + e cos(h t + p): at most 0.6 e of the fundamental is turned, whatever
    p, and by the third harmonic as much as that. Second order in e: 2 %."""
    e, t = 0.02, 2 * np.pi * np.arange(4096) / 4096
    worst = 0.0
    for p in np.linspace(0, 2 * np.pi, 24, endpoint=False):
        v = np.cos(t) + e * np.cos(order * t + p)
        F = v * np.abs(v)
        turned, along = np.mean(F * np.sin(t)), np.mean(F * np.cos(t))
        worst = max(worst, abs(turned / along))
    a = np.zeros(order, complex)
    a[0], a[-1] = 1.0, order * e
    run = SimpleNamespace(energy=SimpleNamespace(acceleration=a))
    assert worst <= 1.02 * _bending(run)
    assert _bending(run) == pytest.approx(0.6 * e)
    if order == 3:
        assert worst >= 0.98 * _bending(run)
