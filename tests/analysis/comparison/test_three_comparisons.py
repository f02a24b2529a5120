"""Chain, prediction and model: three comparisons, each with its own uncertainty."""

import numpy as np
import pytest
from analytic_record import Bench, condition, dashpot_energy, prediction_for, session

from analysis import read_session


def made(model=None, excess=1.07, off=()):
    """Three levels, a bed that takes 7 % more than predicted, ideal instruments. off: conditions
    whose table is made for twice their level."""
    table = [
        condition(f"c{i}", acceleration_set=a, record_cycles=4)
        for i, a in enumerate((2.0, 3.0, 4.0))
    ]
    prediction = prediction_for(table, lambda _entry, a: dashpot_energy(200.0, a))
    for entry in prediction["conditions"].values() if model is not None else ():
        entry["model"] = list(model)
    for name in off:
        entry = prediction["conditions"][name]
        entry["acceleration"] = [2 * a for a in entry["acceleration"]]
    bench, rng = Bench(repeats=2, samples=16 * 512), np.random.default_rng(2)
    return read_session(
        session(table, lambda *_: 200.0 * excess, bench, rng, prediction=prediction)
    )


def test_seven_per_cent_is_told_by_the_prediction_and_not_by_the_model():
    """W_T open by half: the interval is that of the draws' quantiles, and E_n the 7 % over its half
    width.
    """
    model = np.linspace(0.5, 1.5, 201)
    report = made(model)
    found = {row.comparison: row for row in report.comparisons}
    assert [(name, row.n, row.within) for name, row in found.items()] == [
        ("chain", 3, 3), ("prediction", 3, 0), ("model", 3, 3),
    ]  # fmt: skip
    assert "7 % cannot test this model without measured friction" in found["model"].why
    row = report.conditions[0]
    assert (row.W_T_low / row.W_T, row.W_T_high / row.W_T) == pytest.approx((0.525, 1.475))
    # U of the difference, 3e-4 of W_T, adds in quadrature: 2e-7 of the half width
    assert row.E_n_model == pytest.approx(0.07 / 0.475, rel=1e-4)


def test_a_model_that_is_known_to_a_per_cent_is_tested():
    report = made(np.linspace(0.99, 1.01, 101))
    found = report.comparisons[2]
    assert (found.n, found.within) == (3, 0)
    assert "cannot" not in found.why


def test_a_record_of_the_model_itself_does_not_test_it():
    report = made()
    assert report.comparisons[2].n == 0
    assert report.comparisons[2].why.startswith("not made")
    assert all(row.E_n_model is None for row in report.conditions)


def test_a_level_far_from_those_predicted_has_no_W_T_and_the_verdict_says_why():
    report, whole = made(off=("c1",), model=[0.9, 1.1]), made(model=[0.9, 1.1])
    row = report.conditions[1]
    names = ("W_T", "U_W_T", "W_f", "bound", "exponent", "offset", "E_n", "W_T_low", "E_n_model")
    assert {name: getattr(row, name) for name in names} == dict.fromkeys(names)
    assert row.W_exp == whole.conditions[1].W_exp
    assert report.conditions[0].W_T == whole.conditions[0].W_T
    assert report.agreement.n == 2
    said = "No W_T is stated for c1: the level reached is over 10 % from those predicted."
    assert said in report.reasons
    assert not any("No W_T" in reason for reason in whole.reasons)
