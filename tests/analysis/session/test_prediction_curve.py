"""Predicted energies between tabulated accelerations."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.session.prediction import Curve, middle
from analysis.session.prediction_entry import entries_of


@settings(deadline=None)
@given(n=st.floats(0.5, 5), scale=st.floats(1e-6, 1e3), at=st.floats(1.0, 10.0))
def test_a_power_law_is_reproduced_everywhere(n, scale, at):
    levels = (2.0, 3.0, 5.0)
    curve = Curve.of(levels, [scale * a**n for a in levels])
    assert curve(at) == pytest.approx(scale * at**n, rel=1e-9)
    assert curve.exponent(at) == pytest.approx(n, rel=1e-9)


def test_the_order_of_the_table_does_not_matter():
    assert Curve.of([3, 2, 5], [9, 4, 25]) == Curve.of([2, 3, 5], [4, 9, 25])


def test_zero_stays_zero():
    curve = Curve.of([2, 3, 4], [0, 0, 0.01])
    assert curve(1.0) == curve(2.5) == 0
    assert curve(3.5) == pytest.approx(0.005)
    assert curve(3.0) == 0
    assert curve.exponent(2.5) is None


def test_a_single_point_is_a_constant_without_exponent():
    curve = Curve.of([3.0], [0.01])
    assert curve(5.0) == 0.01
    assert curve.exponent(3.0) is None


def test_a_table_reaches_a_tenth_beyond_its_ends():
    curve = Curve.of([10.0, 20.0], [1.0, 8.0])
    assert [curve.reaches(a) for a in (8.9, 9.1, 15.0, 21.9, 22.1)] == [
        False,
        True,
        True,
        True,
        False,
    ]


@pytest.mark.parametrize(("levels", "values"), [([], []), ([1.0], [1.0, 2.0]), ([0.0], [1.0])])
def test_what_is_no_table_is_refused(levels, values):
    with pytest.raises(ValueError, match="prediction"):
        Curve.of(levels, values)


def test_a_laboratory_s_own_prediction_needs_two_lists_only():
    (entry,) = entries_of({"conditions": {"c": {"acceleration": [2, 4], "W_T": [1, 4]}}}).values()
    found = entry.curves()
    assert found.total(3.0) == pytest.approx(2.25)
    assert found.friction(3.0) == 0
    assert found.u_rel == 0
    assert entry.bound is None


def test_numbers_given_along_the_curve_are_taken_at_its_middle():
    assert middle((10, 30, 20), (2, 4, 3)) == 20
    assert middle(7, (2, 4, 3)) == 7
    assert middle(None, (2, 4, 3)) is None


def test_the_slope_is_that_of_all_points_nearby():
    """W rough from level to level: neighbours alone would be off by 0.005 sqrt(2)/0.02, seven
    points are by a fifth of it. Points beyond do not count."""
    levels = [3.0 * (1 + 0.01 * n) for n in range(-3, 4)]
    rough = [a**3 * (1 + 0.005 * (-1) ** n) for n, a in enumerate(levels)]
    assert Curve.of(levels, rough).exponent(3.0) == pytest.approx(3.0, abs=0.07)
    assert Curve.of([*levels, 3.5], [*rough, 100 * 3.5**3]).exponent(3.0) == pytest.approx(
        3.0, abs=0.07
    )
