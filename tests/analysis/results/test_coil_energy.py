"""Energy from the coil's current, against a forward solution of the exciter's equations of motion."""

from dataclasses import replace

import numpy as np
import pytest
from analytic_record import Facts

from analysis.energy.energy_and_phasors import Energy
from analysis.results.coil_current import PARTS, coil_estimates, coil_force, coil_of
from analysis.session.exciter import SessionExciter
from analysis.uncertainty.budget import certificate_lines

EXCITER = SessionExciter(
    force_constant=12.0,
    moving_mass=0.5,
    flexure_stiffness=9500.0,
    flexure_damping_ratio=0.07,
    body_mass=28.0,
    isolation_stiffness=27600.0,
    isolation_damping_ratio=0.1,
    stinger_stiffness=9.7e6,
    stinger_damping=20.0,
    force_constant_U=0.01,
    parts_U=0.1,
    band=350.0,
)
FREQUENCY, HARMONICS = 20.0, 12
SHUNT = Facts("current", "A", calibration_U=0.005, gain_tolerance=0.003, noise_rms=1e-3)


def driven(mass: float, damping: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Phasors of current, gauge force and acceleration of a box of `mass` with a dashpot, coil
    force 100/h^2 N.

    Newton's law for armature, body and box as one matrix of dynamic stiffness, solved at each
    harmonic.
    """
    e = EXCITER
    current, force, acceleration = (np.zeros(HARMONICS, complex) for _ in range(3))
    c_f = 2 * e.flexure_damping_ratio * np.sqrt(e.flexure_stiffness * e.moving_mass)
    c_m = 2 * e.isolation_damping_ratio * np.sqrt(e.isolation_stiffness * e.body_mass)
    for h in range(1, HARMONICS + 1):
        s = 2j * np.pi * FREQUENCY * h
        flexure, mount = e.flexure_stiffness + s * c_f, e.isolation_stiffness + s * c_m
        stinger = e.stinger_stiffness + s * e.stinger_damping
        stiffness = np.array([
            [e.moving_mass * s**2 + flexure + stinger, -flexure, -stinger],
            [-flexure, e.body_mass * s**2 + flexure + mount, 0.0],
            [-stinger, 0.0, mass * s**2 + damping * s + stinger],
        ])  # fmt: skip
        thrust = 100.0 / h**2 * np.exp(1j * h)
        x = np.linalg.solve(stiffness, np.array([thrust, -thrust, 0.0]))
        current[h - 1] = thrust / e.force_constant
        force[h - 1] = stinger * (x[0] - x[2])
        acceleration[h - 1] = s**2 * x[2]
    return current, force, acceleration


def energy_of(force: np.ndarray, acceleration: np.ndarray) -> Energy:
    omega = 2 * np.pi * FREQUENCY * np.arange(1, HARMONICS + 1)
    W = -0.5 / FREQUENCY * float(((force * acceleration.conj()).imag / omega).sum())
    return Energy(FREQUENCY, 40, W, np.full(40, W), W, 0.0, W, force, acceleration)


@pytest.mark.parametrize(("mass", "damping"), [(12.0, 0.0), (12.0, 80.0), (50.0, 900.0)])
def test_the_current_tells_the_force_at_the_gauge(mass: float, damping: float) -> None:
    current, force, acceleration = driven(mass, damping)
    found = coil_force(current, acceleration, FREQUENCY, EXCITER)
    np.testing.assert_allclose(found, force, rtol=1e-9, atol=1e-9 * np.abs(force).max())
    W = sum(
        h
        * np.pi
        * damping
        * (2 * np.pi * FREQUENCY * h)
        * abs(a / (2 * np.pi * FREQUENCY * h) ** 2) ** 2
        for h, a in enumerate(acceleration, 1)
    )
    coil = coil_of(current, energy_of(force, acceleration), SHUNT, EXCITER, 20480)
    # round-off of a force that is mostly inertia
    found_W = coil.W
    assert found_W == pytest.approx(
        W, rel=1e-9, abs=1e-12 * energy_of(force, acceleration).reactive
    )


def test_its_uncertainty_is_what_scattered_parts_give() -> None:
    """Monte Carlo: every part and the force constant drawn, the same current and acceleration read
    with nominal values.

    3000 draws state a standard deviation within 1/sqrt(6000) = 1.3 %; a linear budget of 5 % parts
    is off by terms of second order, some per cent.
    """
    current, force, acceleration = driven(12.0, 80.0)
    energy = energy_of(force, acceleration)
    coil = coil_of(current, energy, Facts("current", "A"), EXCITER, 20480)
    stated = np.sqrt(sum(line.part**2 for line in coil.lines))
    rng = np.random.default_rng(1)
    found = []
    for _ in range(3000):
        drawn = {
            name: getattr(EXCITER, name) * (1 + 0.05 * rng.standard_normal()) for name in PARTS
        }
        drawn["force_constant"] = 12.0 * (1 + 0.005 * rng.standard_normal())
        found.append(
            energy_of(
                coil_force(current, acceleration, FREQUENCY, replace(EXCITER, **drawn)),
                acceleration,
            ).W
        )
    assert np.std(found) == pytest.approx(stated, rel=0.06)


def test_the_accelerometer_moves_both_estimates_alike() -> None:
    """An error of its scale or angle is in W_coil's U and not in that of the difference to W_exp."""
    current, force, acceleration = driven(12.0, 80.0)
    energy = energy_of(force, acceleration)
    gauge, ideal = Facts("force", "N", calibration_U=0.01), Facts("acceleration", "m/s^2")
    poor = Facts(
        "acceleration", "m/s^2", calibration_U=0.05, time_constant=1.6, time_constant_spread=0.2
    )
    coil = coil_of(current, energy, SHUNT, EXCITER, 20480)
    lines = [
        certificate_lines(gauge, channel, FREQUENCY, energy.W, energy.reactive)
        for channel in (ideal, poor)
    ]
    good, bad = (coil_estimates([energy] * 4, [coil] * 4, budget, 1e-9) for budget in lines)
    assert bad[0].U > 2 * good[0].U
    assert bad[1].U == good[1].U
    assert good[1].value == pytest.approx(0.0, abs=1e-9 * energy.W)


def test_harmonics_above_the_band_are_left_out_and_stated() -> None:
    current, force, acceleration = driven(12.0, 80.0)
    energy = energy_of(force, acceleration)
    coil = coil_of(current, energy, SHUNT, replace(EXCITER, band=70.0), 20480)
    above = next(line for line in coil.lines if line.source == "above the coil's band")
    missing = energy.W - coil.W
    assert missing == pytest.approx(np.sqrt(3) * above.u, rel=1e-6)
    assert above.u > 0
