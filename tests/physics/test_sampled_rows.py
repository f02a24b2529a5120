"""Rows in a box whose acceleration is given by samples, against the event-driven rows in
closed-form motion.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rig.beds.janssen_stack import nominal, stack
from rig.catalog.entries import Rig
from rig.kernels.rows.many_rows import steady_energy
from rig.kernels.rows.one_row import RowSet
from rig.kernels.rows.recorded_motion import sampled_energy
from rig.kernels.waveform import crossings, extrema
from rig.protocol.spec import Scene
from rig.theory.total import layers_total

OMEGA = 2 * np.pi * 20.0


def sampled(
    band: float,
    clearance: float,
    restitution: float,
    P: list[float],
    Q: list[float],
    per_cycle: int,
    cycles: int = 8,
) -> np.ndarray:
    """Friction and collision per cycle of one row, m^2/s^2; waveform a = -4 m/s^2 sum (P_h sin +
    Q_h cos).
    """
    phase = 2 * np.pi * np.arange(cycles * per_cycle) / per_cycle
    a = -4.0 * sum(
        p * np.sin(h * phase) + q * np.cos(h * phase)
        for h, (p, q) in enumerate(zip(P, Q, strict=True), 1)
    )
    step = 1 / (20.0 * per_cycle)
    return (
        np.array(
            sampled_energy(
                np.array([band]), np.array([clearance]), restitution, a, step, 72 * per_cycle
            )
        )
        / cycles
    )


def exact(
    band: float, clearance: float, restitution: float, P: list[float], Q: list[float]
) -> tuple[np.ndarray, int]:
    """The same by closed-form motion, and the row's period."""
    unit = (4.0 / OMEGA) ** 2
    bands, coefficients = np.array([band / 4.0]), (np.array(P), np.array(Q))
    tables = crossings(bands, *coefficients, extrema(*coefficients)).tables
    rows = RowSet(
        np.zeros(1, np.int64), np.array([clearance * OMEGA**2 / 4.0]), restitution, bands, tables
    )
    friction, collision, period = steady_energy(rows, *coefficients, 64)
    return unit * np.array([friction[0], collision[0]]), int(period[0])


@pytest.mark.parametrize(
    ("band", "clearance", "restitution", "P", "Q"),
    [
        (1.0, 1.0, 0.0, [1.0], [0.0]),  # never reaches a wall: sliding back and forth
        (0.5, 2e-4, 0.0, [1.0], [0.0]),  # plastic hits at both walls
        (0.8, 1e-4, 0.25, [1.0], [0.0]),  # rebounds
        (0.7, 2e-4, 0.0, [1.0, 0.2, 0.3], [0.0, 0.1, -0.2]),  # a distorted waveform
    ],
)
def test_it_tends_to_the_closed_form_motion_with_the_square_of_the_step(
    band: float, clearance: float, restitution: float, P: list[float], Q: list[float]
) -> None:
    """Straight lines between samples: error (w h)^2/12 of each harmonic, 1.3e-5 h^2 at 512 samples
    per cycle.
    """
    true, period = exact(band, clearance, restitution, P, Q)
    assert period in (1, 2, 4, 8)
    errors = [
        np.abs(sampled(band, clearance, restitution, P, Q, n) - true).max() / true.sum()
        for n in (128, 512)
    ]
    assert errors[1] < 3e-5 * len(P) ** 2
    assert errors[1] < errors[0] / 10  # 16 for second order; events do not fall on samples


@pytest.mark.parametrize("band", [4.0, 10.0])
def test_a_row_that_the_box_never_throws_loses_nothing(band: float) -> None:
    assert (sampled(band, 1e-3, 0.0, [1.0], [0.0], 256) == 0.0).all()


def test_no_clearance_means_no_loss() -> None:
    assert sampled(0.0, 0.0, 0.0, [1.0], [0.0], 256).sum() == 0.0


@given(
    band=st.floats(0.0, 3.9), clearance=st.floats(1e-6, 1e-2), restitution=st.floats(0.0, 1.0),
    harmonics=st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=12), noise=st.floats(0.0, 1.0),
    seed=st.integers(0, 2**32),
)  # fmt: skip
def test_losses_are_finite_and_within_the_hard_bounds(
    band: float,
    clearance: float,
    restitution: float,
    harmonics: list[float],
    noise: float,
    seed: int,
) -> None:
    """Any samples at all: losses are not negative, and friction at most band times the way at the
    largest speed that the box can have relative to a row, twice its own span of velocity (plus the
    drift that a row at e = 1 may keep)."""
    rng = np.random.default_rng(seed)
    n, cycles = 128, 6
    phase = 2 * np.pi * np.arange(cycles * n) / n
    a = sum(
        4 * c * np.sin(h * phase) for h, c in enumerate(harmonics, 1)
    ) + noise * rng.standard_normal(phase.size)
    a -= a.mean()
    friction, collision = sampled_energy(
        np.array([band]), np.array([clearance]), restitution, a, 1 / (20.0 * n), n
    )
    assert np.isfinite([friction, collision]).all()
    assert min(friction, collision) >= 0.0


def test_rows_add_up() -> None:
    band, clearance = np.array([0.5, 0.9, 2.0]), np.array([1e-4, 3e-4, 2e-4])
    a = -4.0 * np.sin(2 * np.pi * np.arange(1024) / 256)
    together = np.array(sampled_energy(band, clearance, 0.1, a, 1 / 5120, 512))
    single = [
        sampled_energy(band[k : k + 1], clearance[k : k + 1], 0.1, a, 1 / 5120, 512)
        for k in range(3)
    ]
    np.testing.assert_allclose(together, np.sum(single, axis=0), rtol=1e-13)


def test_a_whole_bed_takes_what_the_closed_tier_says(rig: Rig, steel: Scene) -> None:
    """680 rows, most of them periodic: those that have several orbits land on others when the
    motion changes in its fifth digit, and 40 cycles average the rest: within 1 % (0.04 to 0.65 %
    found at 1 to 6 m/s^2)."""
    bed = stack(steel, rig, nominal(steel, rig))
    for level in (2.0, 5.0):
        tier = layers_total(
            bed.threshold, bed.clearance, bed.row_mass, bed.restitution, level, 20.0
        )
        a = -level * np.sin(2 * np.pi * np.arange(40 * 256) / 256)
        band = np.repeat(bed.threshold, bed.clearance.shape[1])
        taken = sampled_energy(band, bed.clearance.ravel(), bed.restitution, a, 1 / 5120, 2560)
        assert bed.row_mass * sum(taken) / 40 == pytest.approx(tier.total, rel=0.01)
        assert bed.row_mass * taken[0] / 40 == pytest.approx(tier.friction, rel=0.01)
