"""References: known masses, a known dashpot, and what is wrong with the channels by name."""

import dataclasses
import math

import numpy as np
import pytest
from analytic_record import NOMINAL, OMEGA, Bench, condition, session

from analysis import read_session

LEVELS = (2.0, 3.0, 4.0)
BOX_LOSS, C = 5.0, 60.0  # N s/m
BENCH = Bench(channels=dict(NOMINAL), noise=(0.02, 5e-4), level_error=0.003, gains=(1.002, 0.999), samples=11 * 512)


def made(beds=("empty", "locked", "dashpot"), bench=BENCH, seed=1):
    table = [
        condition(
            f"{bed}{a:g}", bed=bed, bed_mass=38.1 if bed == "locked" else 0.0, acceleration_set=a, settle_cycles=2,
            record_cycles=8, dashpot_c=C if bed == "dashpot" else None,
        )
        for bed in beds
        for a in LEVELS
    ]  # fmt: skip
    return session(table, lambda entry, _r: BOX_LOSS + (entry["dashpot_c"] or 0.0), bench, np.random.default_rng(seed))


def by_name(report):
    return {row["reference"] + ", " + row["of"]: row for row in report["references"]}


def changed(record, change):
    """The record with (force, acceleration) of every run changed."""
    return dataclasses.replace(record, signals={name: change(*both) for name, both in record.signals.items()})


def test_known_masses_and_a_known_dashpot_are_recovered():
    report = read_session(made())
    rows = by_name(report)
    assert list(rows) == [
        "signs, all runs", "rigid mass, empty box", "rigid mass, bonded bed", f"dashpot, c = {C:g} N s/m",
    ]  # fmt: skip
    assert all(row["verdict"] == "holds" for row in rows.values())
    assert rows["rigid mass, bonded bed"]["expected"] == pytest.approx(11.92 + 38.1)
    expected = sum(math.pi * C * a**2 / OMEGA**3 for a in LEVELS) / 3
    # the expected W is taken at the measured levels: 0.1 % scale and 0.3 %/sqrt(12) level error, squared
    assert rows[f"dashpot, c = {C:g} N s/m"]["expected"] == pytest.approx(expected, rel=0.01)
    assert report["verdict"] == "passes"


def test_a_scale_beyond_its_certificate_is_found():
    """5 % in the force against U of about 1.7 %."""
    report = read_session(made(bench=dataclasses.replace(BENCH, gains=(1.05, 1.0))))
    assert {row["verdict"] for row in report["references"] if row["unit"]} == {"does not hold"}
    assert report["verdict"] == "fails"


def test_a_dashpot_without_an_empty_box_is_not_denied():
    """The box's own 5 N s/m of 65 cannot be told from a wrong coefficient."""
    rows = by_name(read_session(made(("dashpot",))))
    row = rows[f"dashpot, c = {C:g} N s/m"]
    assert row["verdict"] == "undecided"
    assert "no empty box" in row["why"]


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
    (signs,) = (row for row in report["references"] if row["reference"] == "signs")
    assert signs["verdict"] == "does not hold"
    assert words in signs["why"]
    assert report["verdict"] == "fails"
    assert any(words in reason for reason in report["reasons"])


def test_both_signs_reversed_change_nothing():
    report = read_session(changed(made(), lambda f, a: (-f, -a)))
    assert report["verdict"] == "passes"
