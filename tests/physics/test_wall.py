"""Wall law, eqs 13 to 19: the numbers of the errata, and the binary law with an infinite mass as
the check.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.theory.collision import Bodies, Contact, collide
from rig.theory.wall import (
    bounce,
    compression_impulse,
    compression_slip,
    impulse_ratio,
    position_after,
    recovery_impulse,
    slip_after,
    wall_restitution,
)

speed = st.floats(-10.0, 10.0)


def test_numbers_of_the_errata() -> None:
    """mu = 0.2, v_n = v_t = 1: 0.8 after compression; 0.66 after the hit at e0 = 0.7."""
    assert compression_slip(1.0, 1.0, 0.2) == pytest.approx(0.8)
    assert slip_after(1.0, 1.0, 0.2, 0.7) == pytest.approx(0.66)
    assert slip_after(1.0, 1.0, 0.2, 0.0) == compression_slip(
        1.0, 1.0, 0.2
    )  # no recovery, friction stays


@given(speed, speed, speed, st.floats(0, 2), st.floats(0, 1))
def test_it_is_the_binary_law_with_an_infinite_mass(
    x: float, y: float, z: float, mu: float, e0: float
) -> None:
    found = bounce([[x, y, z]], mu, e0)
    wall = Bodies([np.inf], [[0.0, 0.0, 0.0]])
    law = collide(Bodies([1.0], [[x, y, z]]), wall, [[0.0, 0.0, -1.0]], Contact(e0, mu))
    np.testing.assert_allclose(found, law.velocity1, atol=1e-13)
    assert (np.sum(found**2) <= (x**2 + y**2 + z**2) * (1 + 1e-12)).all()


@given(speed, speed, st.floats(-10.0, -1e-3), st.floats(0, 2), st.floats(0, 1))
def test_both_phases_add_to_one_hit(x: float, y: float, z: float, mu: float, e0: float) -> None:
    """Eqs 13 and 16: compression ends at rest along the normal; the rest is e0 of it; slip falls as
    eq 18 says.
    """
    v = np.array([x, y, z])
    compressed = v + compression_impulse(1.0, v, mu)
    assert compressed[2] == pytest.approx(0.0, abs=1e-14)
    assert np.hypot(*compressed[:2]) == pytest.approx(
        float(compression_slip(np.hypot(x, y), z, mu)), abs=1e-13
    )
    after = compressed + recovery_impulse(1.0, v, mu, e0)
    assert np.hypot(*after[:2]) == pytest.approx(
        float(slip_after(np.hypot(x, y), z, mu, e0)), abs=1e-13
    )
    assert float(wall_restitution(z, after[2], 0.0, 0.0)) == pytest.approx(e0, abs=1e-12)


def test_a_grain_that_departs_is_left_alone() -> None:
    assert bounce([1.0, 2.0, 3.0], 0.5, 0.5).tolist() == [1.0, 2.0, 3.0]


def test_friction_coefficient_of_a_hit() -> None:
    """Eq 15: mu where it slides, v_t/|v_n| where it sticks, 0 where nothing happens."""
    v = np.array([[3.0, 4.0, -10.0], [3.0, 4.0, -10.0], [1.0, 0.0, 1.0]])
    found = impulse_ratio(compression_impulse(1.0, v, [0.2, 2.0, 0.2]))
    np.testing.assert_allclose(found, [0.2, 0.5, 0.0], rtol=1e-14)


def test_restitution_in_a_moving_frame() -> None:
    """Eq 17: 1 and -0.7 m/s relative to the wall, whatever the wall's own velocity."""
    assert wall_restitution(3.0, 1.3, 2.0, 2.0) == pytest.approx(0.7)


def test_height_does_not_drift() -> None:
    """Eq 19: from z = 3 r down to the wall and back in equal times, a hundred times, without a
    radius added.
    """
    r, position = 0.002, np.array([[0.0, 0.0, 0.006]])
    for _ in range(100):
        down, up = np.array([[0.1, 0.0, -1.0]]), np.array([[0.1, 0.0, 1.0]])
        position = position_after(position, down, up, 0.008, [0.004], r)
    np.testing.assert_allclose(position, [[0.08, 0.0, 0.006]], rtol=1e-12)
