"""Eqs 1 to 5 against their differential equation, their limits and hand numbers."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rig.theory.friction import (
    friction_energy_per_slip,
    janssen_length,
    janssen_stress,
    layer_capacity,
    side_wall_capacity,
    slice_forces,
    slice_imbalance,
    slip_distance,
)

BOX = {"length": 0.15, "width": 0.15}
STEEL = {"bulk_density": 0.63 * 7900.0, "gravity": 9.80665}


def test_stress_solves_the_balance_of_a_slice() -> None:
    """Eq 1 as an ODE, integrated by another engine: L1 L2 dsigma = (rho g L1 L2 - 2 mu K sigma (L1
    + L2)) dh.
    """
    length, width, mu_k, weight = 0.15, 0.25, 0.45 * 0.7, 1650.0 * 9.80665

    def slope(_: float, sigma: np.ndarray) -> np.ndarray:
        return weight - 2.0 * mu_k * sigma * (length + width) / (length * width)

    depth = np.linspace(0.0, 1.5, 16)
    solved = solve_ivp(slope, (0.0, 1.5), [0.0], t_eval=depth, rtol=1e-11, atol=1e-9).y[0]
    found = janssen_stress(depth, 1650.0, 9.80665, janssen_length(length, width, 0.45, 0.7))
    np.testing.assert_allclose(found, solved, rtol=1e-8, atol=1e-6)


def test_numbers_of_the_errata() -> None:
    """1927 Pa in the tested box at 1.65 g/cm3; 4752 Pa is the 99 % depth of a box with L1
    L2/(L1+L2) = 0.18495 m.
    """
    saturation = janssen_length(0.15, 0.15, 0.45, 0.7)
    assert janssen_stress(100.0, 1650.0, 9.80665, saturation) == pytest.approx(1927.0, abs=1.0)
    side = 2 * 0.18495
    deep = janssen_length(side, side, 0.45, 0.7)
    # 4752 is 1650 x 9.81 x lambda: the paper's g has three digits, hence 1 Pa in 4752
    assert janssen_stress(100.0, 1650.0, 9.80665, deep) == pytest.approx(4752.0, abs=2.0)
    assert janssen_stress(1.35, 1650.0, 9.80665, deep) / (1650.0 * 9.80665 * deep) == pytest.approx(
        0.99, abs=1e-4
    )


def test_without_wall_friction_the_stress_is_hydrostatic() -> None:
    assert janssen_length(0.15, 0.15, 0.0, 0.7) == float("inf")
    assert janssen_stress(0.3, 1000.0, 9.81, float("inf")) == pytest.approx(
        1000.0 * 9.81 * 0.3, rel=1e-15
    )
    # lambda -> infinity approaches it: the next term is h/(2 lambda) relative
    assert janssen_stress(0.3, 1000.0, 9.81, 1e6) == pytest.approx(
        1000.0 * 9.81 * 0.3, rel=0.3 / 2e6 * 1.01
    )


def test_eq5_closed_form_and_its_value_for_steel() -> None:
    """Geometric sum C [N - p (1 - p^N)/(1 - p)], and the notes' 1.106 J at phi_b = 0.60."""
    d, layers, saturation = 0.004, 85, janssen_length(0.15, 0.15, 0.45, 0.7)
    found = friction_energy_per_slip(
        layers, d, 0.15, 0.15, 0.60 * 7900.0, 9.80665, 0.25, saturation
    )
    p = np.exp(-d / saturation)
    scale = 0.25 * 0.60 * 7900.0 * 9.80665 * saturation * 0.15**2 * slip_distance(d)
    assert found == pytest.approx(scale * (layers - p * (1 - p**layers) / (1 - p)), rel=1e-12)
    assert found == pytest.approx(1.106, abs=5e-4)


def test_layers_share_the_capacity_of_the_deepest_interface() -> None:
    """The f_i telescope: their sum is F_N; the top layer has nearly mu_p g, the deep ones little."""
    saturation = janssen_length(0.15, 0.15, 0.45, 0.7)
    capacity = layer_capacity(
        85, 0.004, 0.15, 0.15, **STEEL, grain_friction=0.25, saturation_length=saturation
    )
    deepest = 0.25 * 0.15**2 * janssen_stress(0.34, **STEEL, saturation_length=saturation)
    assert capacity.sum() == pytest.approx(float(deepest), rel=1e-12)
    threshold = capacity / (STEEL["bulk_density"] * 0.15**2 * 0.004)
    assert threshold[0] == pytest.approx(2.4, abs=0.05)  # model.md section 2, two digits
    assert threshold[-1] == pytest.approx(0.14, abs=0.005)
    assert (np.diff(threshold) < 0).all()


def test_side_walls_raise_the_thresholds_to_the_documented_band() -> None:
    """model.md section 2: with the friction of the two side walls thresholds would be 2.6 to 4.8
    m/s^2.
    """
    saturation = janssen_length(0.15, 0.15, 0.45, 0.7)
    layers, d = 85, 0.004
    mass = STEEL["bulk_density"] * 0.15**2 * d
    bare = layer_capacity(
        layers, d, 0.15, 0.15, **STEEL, grain_friction=0.25, saturation_length=saturation
    )
    sides = side_wall_capacity(layers, d, 0.15, **STEEL, wall_friction=0.45, janssen_ratio=0.7,
                               saturation_length=saturation)  # fmt: skip
    threshold = (bare + sides) / mass
    assert threshold.min() == pytest.approx(2.6, abs=0.15)
    assert threshold.max() == pytest.approx(4.8, abs=0.15)


@given(st.floats(1e-3, 1e-2), st.integers(1, 400), st.floats(0.1, 10.0))
def test_friction_energy_is_proportional_to_density(d: float, layers: int, factor: float) -> None:
    args = (layers, d, 0.15, 0.15)
    one = friction_energy_per_slip(*args, 1000.0, 9.8, 0.25, 0.12)
    assert friction_energy_per_slip(*args, 1000.0 * factor, 9.8, 0.25, 0.12) == pytest.approx(
        factor * one, rel=1e-13
    )


def test_forces_on_a_slice_by_hand() -> None:
    """Eq 2: sigma = 100 Pa, mu K = 0.5, 2 m x 3 m x 0.1 m of 10 kg/m3 at g = 10: F1 = 10, F2 = 15,
    G = 60 N.
    """
    forces = slice_forces(100.0, 5.0, 0.1, 2.0, 3.0, 10.0, 10.0, 0.5, 1.0)
    assert forces == pytest.approx((10.0, 15.0, 630.0, 600.0, 60.0))
    assert slice_imbalance(forces) == pytest.approx(20.0 + 30.0 + 30.0 - 60.0)


@given(st.floats(0.0, 2.0), st.floats(1e-6, 1e-4))
def test_eq3_balances_a_thin_slice(depth: float, thin: float) -> None:
    """Eq 1 at the mid stress: the imbalance over the weight falls as the square of the thickness
    over lambda.
    """
    saturation = janssen_length(0.15, 0.25, 0.45, 0.7)
    top, middle, bottom = janssen_stress(
        depth + thin * np.array([0.0, 0.5, 1.0]), 1650.0, 9.8, saturation
    )
    forces = slice_forces(middle, bottom - top, thin, 0.15, 0.25, 1650.0, 9.8, 0.45, 0.7)
    # round-off of the two stresses, 1e-16 sigma against the weight of the slice, dominates
    assert (
        abs(slice_imbalance(forces)) / forces.G
        < (thin / saturation) ** 2 + 1e-14 * saturation / thin
    )


def test_friction_coefficient_of_each_layer() -> None:
    """mu_pi of eq 5: a list of equal ones is one for all, and the work is linear in each."""
    args, rest = (3, 0.004, 0.15, 0.15, 1000.0, 9.8), 0.12
    one = friction_energy_per_slip(*args, 0.25, rest)
    assert friction_energy_per_slip(*args, [0.25] * 3, rest) == one
    parts = sum(friction_energy_per_slip(*args, list(row), rest) for row in 0.25 * np.eye(3))
    assert parts == pytest.approx(one, rel=1e-14)


def test_grain_size_drops_out_of_eq5_as_it_vanishes() -> None:
    """d -> 0: 0.1547 mu_p rho_b g lambda A (w H - lambda (1 - exp(-w H/lambda))), then a term in
    d/2.
    """
    saturation, depth = janssen_length(0.15, 0.15, 0.45, 0.7), 0.34
    scale = slip_distance(1.0) * 0.25 * 1000.0 * 9.8 * saturation * 0.15**2
    limit = scale * (depth - saturation * -np.expm1(-depth / saturation))
    for layers in (340, 34_000):
        found = friction_energy_per_slip(
            layers, depth / layers, 0.15, 0.15, 1000.0, 9.8, 0.25, saturation
        )
        assert found - limit == pytest.approx(
            scale * depth / layers / 2 * -np.expm1(-depth / saturation), rel=0.01
        )


def test_empty_and_full_box() -> None:
    """w -> 0: nothing. w = 1: all H/d layers, more than any lower fill (eq 5 rises throughout)."""
    found = [
        friction_energy_per_slip(n, 0.004, 0.15, 0.15, 1000.0, 9.8, 0.25, 0.12) for n in range(101)
    ]
    assert found[0] == 0.0
    assert (np.diff(found) > 0).all()
