"""Eqs 20 to 23 and the whole collision of a row, against hand calculations and conservation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.theory.chain import (
    chain_velocities,
    first_grain_velocity,
    first_wave_loss,
    row_restitution,
    wall_loss,
)


def test_velocity_of_the_seventh_grain() -> None:
    """Erratum of the text: .0596, .1452, .3153, .6264 at e = .25, .45, .65, .85, not 6 % below e = .65."""
    found = [chain_velocities(np.ones(7), e, 1.0)[-1] for e in (0.25, 0.45, 0.65, 0.85)]
    np.testing.assert_allclose(found, [0.0596, 0.1452, 0.3153, 0.6264], atol=5e-5)


def test_unequal_masses_against_a_two_body_hand_calculation() -> None:
    """m = 1 kg at 2 m/s onto 3 kg at rest, e = 0.5: v2 = 0.75, v1 = -0.25, loss 2 - (0.03125 + 0.84375) J."""
    np.testing.assert_allclose(chain_velocities([1.0, 3.0], 0.5, 2.0), [2.0, 0.75], rtol=1e-15)
    assert first_wave_loss([1.0, 3.0], 0.5, 2.0) == pytest.approx(2.0 - 0.03125 - 0.84375, rel=1e-14)


@given(st.integers(2, 60), st.floats(0.0, 0.999))
def test_first_wave_of_equal_grains_has_its_closed_form(n: int, e: float) -> None:
    q = (1 + e) / 2
    exact = (1 + e) / (3 + e) * (1 - q ** (2 * (n - 1)))
    assert first_wave_loss(np.ones(n), e, 1.0) == pytest.approx(exact, rel=1e-10, abs=1e-15)


@given(st.integers(2, 30), st.floats(0.0, 1.0), st.floats(1e-3, 1e3))
def test_first_wave_never_loses_more_than_it_has(n: int, e: float, ratio: float) -> None:
    masses = np.where(np.arange(n) % 2, ratio, 1.0)
    assert 0.0 <= first_wave_loss(masses, e, 1.0) <= 0.5 * (1 + 1e-12)


def test_wall_laws() -> None:
    assert first_grain_velocity(0.2, 0.65) == pytest.approx(0.33)
    assert wall_loss(2.0, 0.5, 3.0) == pytest.approx(0.5 * 2.0 * 0.75 * 9.0)


def test_row_restitution_against_the_design_table() -> None:
    """model.md: .25, .076, .019, .001 at n = 10, 16, 21, 25 for e = .9, e0 = .75; 25 is already taken as plastic."""
    found = [row_restitution(n, 0.9, 0.75) for n in (10, 16, 21)]
    np.testing.assert_allclose(found, [0.25, 0.076, 0.019], rtol=0.025)  # the table has two digits
    assert row_restitution(25, 0.9, 0.75) == 0.0
    assert row_restitution(24, 0.9, 0.75) < 0.01


def test_row_restitution_of_two_grains_by_hand() -> None:
    """Grains fly at -1, hit at e0 = 0.5, meet at e = 0.5: v = (-1, -1) -> (.5, -1) -> (-.625, .125) -> (.3125, .125)
    -> the pair closes again: mean .21875, relative .1875 -> (.171875, .265625), separated."""
    assert row_restitution(2, 0.5, 0.5) == pytest.approx(0.21875, rel=1e-14)


def test_one_grain_and_elastic_limits() -> None:
    assert row_restitution(1, 0.9, 0.75) == 0.75
    assert row_restitution(8, 1.0, 1.0) == pytest.approx(1.0, rel=1e-12)


@given(st.integers(1, 40), st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_row_restitution_never_creates_momentum_or_energy(n: int, e: float, e0: float) -> None:
    """|mean| <= rms <= 1, and the row always leaves or stays; round-off only."""
    assert 0.0 <= row_restitution(n, e, e0) <= 1.0 + 1e-12
