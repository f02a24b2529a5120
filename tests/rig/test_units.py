"""Quantities: text with a unit to SI numbers and back."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.units import (
    UNITS,
    Quantity,
    UnitError,
    format_quantity,
    parse_quantity,
    suggest_unit,
    unit_of,
)


@pytest.mark.parametrize(
    ("text", "dimension", "value"),
    [
        ("150 mm", "length", 0.15),
        ("150mm", "length", 0.15),
        ("  4 um ", "length", 4e-6),
        ("7 cm", "length", 0.07),
        ("20 g", "mass", 0.02),
        ("3 us", "time", 3e-6),
        ("10.24 kHz", "frequency", 10240.0),
        ("300 mN", "force", 0.3),
        ("25 mV", "voltage", 0.025),
        ("4 mA", "current", 0.004),
        ("1 g", "acceleration", 9.80665),
        ("5 m/s^2", "acceleration", 5.0),
        ("-5e-1 m/s2", "acceleration", -0.5),
        ("50 N s/m", "damping", 50.0),
        ("50 N*s/m", "damping", 50.0),
        ("85 %", "number", 0.85),
        ("85%", "number", 0.85),
        (".5", "number", 0.5),
        ("40 cycles", "cycles", 40.0),
        ("7.9 g/cm^3", "density", 7900.0),
        ("18.4 g/cm3", "density", 18400.0),
        ("200 GPa", "pressure", 2e11),
        ("180 deg", "angle", math.pi),
        ("2.248 mV/N", "force sensitivity", 0.002248),
    ],
)
def test_known_texts(text: str, dimension: str, value: float) -> None:
    assert parse_quantity(text, dimension) == value


@pytest.mark.parametrize(
    ("text", "dimension"),
    [
        ("150", "length"),
        ("150 kg", "length"),
        ("150 M", "length"),
        ("", "length"),
        ("mm", "length"),
        ("1 2 mm", "length"),
        ("1,5 mm", "length"),
        ("0x10 mm", "length"),
        ("1_000 mm", "length"),
        ("nan m", "length"),
        ("inf m", "length"),
        ("1e999 m", "length"),
        ("1e999999999999999999999 mm", "length"),
        ("1e-999999999999999999999 foot", "length"),
        ("١٢ mm", "length"),  # digits, but not ASCII ones
        ("1" * 1000 + " m", "length"),
        ("40", "cycles"),
        ("1 %", "length"),
    ],
)
def test_what_is_no_quantity_names_the_units(text: str, dimension: str) -> None:
    with pytest.raises(UnitError, match=r"units|finite"):
        parse_quantity(text, dimension)


@given(
    value=st.floats(allow_nan=False, allow_infinity=False), dimension=st.sampled_from(sorted(UNITS))
)
def test_format_then_parse_is_identity(value: float, dimension: str) -> None:
    assert parse_quantity(format_quantity(value, dimension), dimension) == value


@given(value=st.integers(-(10**9), 10**9), power=st.integers(-6, 3))
def test_scaled_units_are_correctly_rounded(value: int, power: int) -> None:
    """A number of millimetres is the double nearest to its decimal: not the product of two doubles."""
    assert parse_quantity(f"{value}e{power} mm", "length") == float(f"{value}e{power - 3}")


def test_the_first_unit_of_each_dimension_is_the_si_one() -> None:
    assert all(next(iter(units.values())) == 1 for units in UNITS.values())
    assert unit_of("density") == "kg/m^3"


def test_hints_name_the_unit_that_would_fit() -> None:
    assert suggest_unit(150, Quantity("length", 0, 20)) == "150 is 150 m; did you mean 150 mm?"
    assert suggest_unit(85, Quantity("number", 0, 1)) == "did you mean 85 %?"
    assert suggest_unit(-1, Quantity("number", 0, 1)) == ""
    assert (
        suggest_unit(1.2, Quantity("number", 0, 1)) == ""
    )  # a restitution of 1.2 is not one of 1.2 %
    assert suggest_unit(math.inf, Quantity("length", 0, 20)) == ""


def test_ranges_in_words() -> None:
    assert (
        str(Quantity("length", 0, 20, above=True))
        == "above 0 m, at most 20 m (units m, mm, cm, um)"
    )
    assert str(Quantity()) == "a number (a plain number or %)"
    closed, opened = Quantity("number", 0, 1), Quantity("number", 0, 1, above=True)
    assert closed.holds(0)
    assert closed.holds(1)
    assert not opened.holds(0)
    assert not closed.holds(math.nan)
