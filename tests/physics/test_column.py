"""Prediction `column`: limits of the formula, its agreement with resolved grains, its table."""

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.theory.column import (
    ColumnBed,
    ColumnCoefficients,
    ColumnTotal,
    YieldProfile,
    column_total,
    outside,
    relative_uncertainty,
)
from rig.theory.column_table import (
    FrictionTable,
    OutsideTable,
    block_profile,
    column_coefficients,
    shipped,
)

GRAVITY = 9.80665
PRINTED = ColumnCoefficients(YieldProfile(0.37, 3.5, 0.15), 4.6)
BOX = ColumnBed(length=0.1, width=0.025, height=0.05, diameter=0.005, fill=0.85, mass=0.447252)
TABLE = Path(__file__).parents[1] / "data" / "engine_table.csv"


def case(row: dict[str, str]) -> tuple[ColumnBed, float, float]:
    """Return the bed of a row of the engine's table, its level (m/s^2) and frequency."""
    names = ("Lx", "Ly", "H", "d", "fill", "M")
    return ColumnBed(*(float(row[name]) for name in names)), float(row["a"]), float(row["f"])


def horizontal() -> list[dict[str, str]]:
    with TABLE.open(encoding="utf-8") as file:
        return [row for row in csv.DictReader(file) if row["axis"] == "0"]


def of_engine(row: dict[str, str]) -> ColumnTotal:
    bed, a, f = case(row)
    found = column_coefficients(float(row["mup"]), float(row["muw"]))
    return column_total(bed, found, a, f, GRAVITY)


def ratio(row: dict[str, str]) -> float:
    return float(of_engine(row).W_T) / float(row["W"])


def test_resolved_grains_at_0_7_g_and_above() -> None:
    """13 of 15 cases lie within 30 %; the others are the shallow fill at the two highest levels,
    where grains leave the bed and the formula knows no flight.
    """
    far = {
        (float(row["fill"]), float(row["a"])): ratio(row)
        for row in horizontal()
        if float(row["a"]) >= 7.0 and abs(ratio(row) - 1.0) > 0.3
    }
    assert sum(float(row["a"]) >= 7.0 for row in horizontal()) == 15
    assert far.keys() == {(0.3, 14.0), (0.3, 20.0)}
    assert max(far.values()) < 1.4


def test_resolved_grains_below_0_7_g() -> None:
    """All but one of 16 cases lie within a factor of 2; that one (2 m/s^2, fill 0.6) is 2.03 times
    too high, and the engine itself scatters by as much there.
    """
    found = [ratio(row) for row in horizontal() if float(row["a"]) < 7.0]
    assert len(found) == 16
    assert sum(0.5 <= one <= 2.0 for one in found) == 15
    assert max(found) < 2.1
    assert min(found) > 0.6


def test_in_phase_mass_of_resolved_grains() -> None:
    """grains.md: 0.02 to 0.07 as a root mean square, in units of M; 0.06 over these cases."""
    apart = [float(of_engine(row).in_phase_mass) / float(row["M"]) - float(row["meff"])
             for row in horizontal()]  # fmt: skip
    assert math.sqrt(np.mean(np.square(apart))) < 0.07


def test_the_stated_interval_holds_the_engine() -> None:
    """The 90 % interval of a stated case holds at least 90 % of the engine's: where the formula is
    stated at all.
    """
    inside = []
    for row in horizontal():
        bed, a, _ = case(row)
        level = a / GRAVITY
        if not outside(bed, float(of_engine(row).flow), level, float(row["muw"])):
            inside.append(abs(math.log(ratio(row))) <= 1.645 * relative_uncertainty(level))
    # 11 of the 15 cases at 7 m/s^2 and above (20 m/s^2 is 2.04 g), and 4 of the 5 at 5 (0.51 g):
    # the shallow one flows in less than a grain.
    assert len(inside) == 15
    assert sum(inside) >= 0.9 * len(inside)


@given(
    level=st.floats(1e-6, 1e3),
    fill=st.floats(0.05, 1.0),
    length=st.floats(0.01, 1.0),
    width=st.floats(0.01, 1.0),
    q=st.floats(1.0, 20.0),
)
def test_never_above_half_a_cycle_of_a_lagging_mass(
    level: float, fill: float, length: float, width: float, q: float
) -> None:
    """c sqrt(1 - c^2) is at most 1/2: W <= pi/2 M V^2; the in-phase mass lies between 0 and M."""
    bed = replace(BOX, fill=fill, length=length, width=width)
    found = column_total(bed, replace(PRINTED, q=q), level * GRAVITY, 20.0, GRAVITY)
    most = 0.5 * math.pi * bed.mass * (level * GRAVITY / (40.0 * math.pi)) ** 2
    assert 0.0 <= found.W_T <= most * (1 + 1e-12)
    assert 0.0 <= found.in_phase_mass <= bed.mass * (1 + 1e-12)
    assert found.amplitude.shape == (bed.layers,)
    # Thresholds rise with depth: no layer moves more with the box than one below it.
    assert (np.diff(found.amplitude) >= 0.0).all()


def test_limits_in_the_level() -> None:
    """W falls to 0 and the in-phase mass rises to M as the level falls; both are monotonic."""
    a = np.geomspace(1e-3, 1e3, 400)
    found = column_total(BOX, PRINTED, a, 20.0, GRAVITY)
    assert (np.diff(found.W_T) > 0.0).all()
    assert (np.diff(found.in_phase_mass) <= 0.0).all()
    assert found.in_phase_mass[0] == pytest.approx(BOX.mass, rel=1e-12)
    # x^-q of the top layer: W/(pi M V^2) = sqrt(2 x^-q/q)/N to leading order, 1e-8 and less here.
    V = a[0] / (40.0 * math.pi)
    x = 4 / math.pi * 0.37 * GRAVITY / a[0]
    top = math.sqrt(2.0 * x**-4.6 / 4.6) / BOX.layers
    assert top * 0.99 < found.W_T[0] / (math.pi * BOX.mass * V**2) < top * BOX.layers


def test_levels_of_any_shape_are_computed_one_by_one() -> None:
    a = np.array([[1.0, 5.0], [7.0, 20.0]])
    every = column_total(BOX, PRINTED, a, 20.0, GRAVITY)
    assert every.amplitude.shape == (2, 2, BOX.layers)
    for place in np.ndindex(a.shape):
        one = column_total(BOX, PRINTED, a[place], 20.0, GRAVITY)
        assert every.W_T[place] == one.W_T
        assert every.in_phase_mass[place] == one.in_phase_mass


@given(scale=st.floats(0.01, 100.0))
def test_similar_boxes_take_energy_in_proportion_to_mass_and_squared_velocity(
    scale: float,
) -> None:
    """All lengths times s: depths over L and B stay, so W/(M V^2) depends on a/g alone."""
    sizes = {name: getattr(BOX, name) * scale for name in ("length", "width", "height", "diameter")}
    large = column_total(replace(BOX, **sizes), PRINTED, 8.0, 20.0, GRAVITY)
    other = column_total(BOX, PRINTED, 8.0, 37.0, GRAVITY)
    small = column_total(BOX, PRINTED, 8.0, 20.0, GRAVITY)
    # Depths are products of three rounded factors; layers are counted, so a box just at x.5 layers
    # would jump (0.85 x 10 is 8.5: rounded to even).
    if large.amplitude.shape == small.amplitude.shape:
        assert pytest.approx(float(small.W_T), rel=1e-12) == large.W_T
    assert pytest.approx(float(small.W_T) * (20.0 / 37.0) ** 2, rel=1e-12) == other.W_T


def test_an_empty_box_takes_nothing() -> None:
    found = column_total(replace(BOX, fill=0.0, mass=0.0), PRINTED, 8.0, 20.0, GRAVITY)
    assert (found.W_T, found.in_phase_mass, found.amplitude.size) == (0.0, 0.0, 0)


@pytest.mark.parametrize(
    ("change", "level", "friction", "axis", "cavity", "word"),
    [
        ({}, 1.0, 0.45, "vertical", "box", "vertical"),
        ({}, 1.0, 0.45, "zero_gravity", "box", "zero_gravity"),
        ({}, 1.0, 0.0, "horizontal", "box", "frictionless"),
        ({}, 1.0, 0.45, "horizontal", "cylinder", "cylinder"),
        ({"fill": 0.29}, 1.0, 0.45, "horizontal", "box", "fill"),
        ({"fill": 0.96}, 1.0, 0.45, "horizontal", "box", "fill"),
        ({"diameter": 0.002}, 0.49, 0.45, "horizontal", "box", "level"),
        ({}, 2.01, 0.45, "horizontal", "box", "level"),
        ({"height": 0.2}, 0.69, 0.45, "horizontal", "box", "taller"),
        ({"diameter": 0.02}, 0.55, 0.45, "horizontal", "box", "shallower"),
    ],
)
def test_reasons_outside(
    change: dict[str, float], level: float, friction: float, axis: str, cavity: str, word: str
) -> None:
    bed = replace(BOX, **change)
    flow = float(column_total(bed, PRINTED, level * GRAVITY, 20.0, GRAVITY).flow)
    found = outside(bed, flow, level, friction, axis, cavity)
    assert len(found) == 1
    assert word in found[0]


@pytest.mark.parametrize("level", [0.5, 0.7, 2.0])
@pytest.mark.parametrize("fill", [0.3, 0.95])
def test_the_ends_of_the_ranges_are_inside(level: float, fill: float) -> None:
    """The smaller fill needs more layers to flow a grain deep at 0.5 g: grains of 2 mm."""
    bed = replace(BOX, fill=fill, diameter=0.002)
    flow = float(column_total(bed, PRINTED, level * GRAVITY, 20.0, GRAVITY).flow)
    assert outside(bed, flow, level * GRAVITY / GRAVITY, 0.45) == ()


def test_uncertainty_covers_nine_of_ten_within_the_stated_factor() -> None:
    for level, factor in ((0.3, 2.5), (0.499, 2.5), (0.5, 1.5), (0.699, 1.5), (0.7, 1.3), (2, 1.3)):
        u = relative_uncertainty(level)
        assert math.erf(math.log(factor) / u / math.sqrt(2)) == pytest.approx(0.9, abs=1e-4)
    # issue 14: U at most 40 % from 0.7 g to 2 g
    assert 2 * relative_uncertainty(0.7) < 0.4


def test_the_shipped_pair_and_its_bounds() -> None:
    """Exactly the printed numbers at the printed pair, a named reason anywhere else."""
    assert column_coefficients(0.25, 0.45) == PRINTED
    assert block_profile(0.25, 0.45) == YieldProfile(0.165, 1.64, 0.084)
    for pair, name in (((0.3, 0.45), "mu_p"), ((0.25, 0.4), "mu_w"), ((0.25, 0.0), "mu_w")):
        with pytest.raises(OutsideTable, match=name):
            column_coefficients(*pair)
    assert shipped("formula").values.shape == (1, 1, 4)


@given(p=st.floats(0.1, 0.5), w=st.floats(0.2, 0.6), k=st.tuples(*[st.floats(-5, 5)] * 4))
def test_interpolation_is_exact_for_what_is_bilinear(
    p: float, w: float, k: tuple[float, float, float, float]
) -> None:
    """k0 + k1 p + k2 w + k3 p w, on a grid that is not uniform and given in any order."""

    def value(mu_p: float, mu_w: float) -> float:
        return k[0] + k[1] * mu_p + k[2] * mu_w + k[3] * mu_p * mu_w

    pairs = [(mu_p, mu_w) for mu_w in (0.6, 0.2, 0.45) for mu_p in (0.25, 0.1, 0.5, 0.15)]
    table = FrictionTable.of([(*pair, *[value(*pair)] * 4) for pair in pairs])
    # Sums of 12 products of numbers up to 10.
    assert table.at(p, w) == pytest.approx(np.full(4, value(p, w)), abs=12 * 10 * 2**-50)
    with pytest.raises(OutsideTable, match=r"0\.1 to 0\.5"):
        table.at(0.51, w)


@pytest.mark.parametrize(
    "pairs",
    [
        [],
        [(0.1, 0.2), (0.1, 0.2)],
        [(0.1, 0.2), (0.1, 0.4), (0.3, 0.2)],
        [(0.1, 0.2), (0.1, 0.4), (0.3, 0.2), (0.3, 0.2)],
    ],
)
def test_a_table_with_holes_is_refused(pairs: list[tuple[float, float]]) -> None:
    with pytest.raises(ValueError, match="rectangular grid"):
        FrictionTable.of([(*pair, 1.0, 1.0, 1.0, 1.0) for pair in pairs])
