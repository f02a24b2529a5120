"""What a motion asks of the exciter, against its equations integrated forwards in time."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from rig.catalog.entries import Exciter
from rig.catalog.entries_by_name import exciter
from rig.drive.exciter_limits import Demand, demand
from rig.drive.waveform import Waveform

PER_CYCLE = 512
CYCLES = 3
MODELS = ("JZ-30", "2100E11")
Array = NDArray[np.float64]


def asked(model: Exciter, force: Array, motion: Waveform, band: float = 1e9) -> Demand:
    """Use of an exciter for a force given over one cycle, repeated."""
    return demand(model, np.tile(force, CYCLES), PER_CYCLE * motion.frequency, motion, band)


def phases() -> Array:
    return 2.0 * np.pi * np.arange(PER_CYCLE) / PER_CYCLE


def forwards(model: Exciter, mass: float, omega: float, voltage: float) -> dict[str, float]:
    """Amplitudes of exciter and a rigid load of `mass` (0: none) on the stinger, driven by voltage
    sin wt.

    Newton's law for armature, body and load and Kirchhoff's for the coil, integrated over one
    period by scipy; the periodic state is found by shooting, for the equations are linear. Nothing
    of this is in phasors.
    """
    m = model
    c_flexure = 2.0 * m.flexure_damping_ratio * np.sqrt(m.flexure_stiffness * m.moving_mass)
    c_mount = 2.0 * m.isolation_damping_ratio * np.sqrt(m.isolation_stiffness * m.body_mass)

    def rates(y: Array, e: float) -> Array:
        xa, va, xb, vb, i, x, v = y
        flexure = m.flexure_stiffness * (xa - xb) + c_flexure * (va - vb)
        mount = m.isolation_stiffness * xb + c_mount * vb
        pull = m.stinger_stiffness * (xa - x) + m.stinger_damping * (va - v) if mass else 0.0
        coil = m.force_constant * i
        return np.array(
            [
                va,
                (coil - flexure - pull) / m.moving_mass,
                vb,
                (flexure - mount - coil) / m.body_mass,
                (e - m.resistance * i - m.force_constant * (va - vb)) / m.inductance,
                v if mass else -x,  # without a load these two only have to settle at nothing
                pull / mass if mass else -v,
            ]
        )

    def over_a_period(start: Array, level: float) -> Array:
        def slope(t: float, y: Array) -> Array:
            return rates(y, level * np.sin(omega * t))

        times = np.append(phases(), 2.0 * np.pi) / omega
        # displacements are some 1e-5 m and more; LSODA for the short times of coil and stinger
        found = solve_ivp(slope, (0.0, times[-1]), start, "LSODA", times, rtol=1e-10, atol=1e-13)
        return found.y

    carried = np.stack([over_a_period(unit, 0.0)[:, -1] for unit in np.eye(7)], axis=1)
    gained = over_a_period(np.zeros(7), voltage)[:, -1]
    y = over_a_period(np.linalg.solve(np.eye(7) - carried, gained), voltage)[:, :-1]

    def amplitude(signal: Array) -> float:
        return float(2.0 * abs(np.fft.rfft(signal)[1]) / PER_CYCLE)

    return {
        "load": amplitude(y[5]),
        "armature": amplitude(y[0]),
        "current": amplitude(y[4]),
        "stroke": amplitude(y[0] - y[2]),
    }


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("frequency", [12.0, 20.0, 60.0])
@pytest.mark.parametrize("mass", [12.0, 57.0])
def test_the_voltage_asked_for_makes_the_motion(name: str, frequency: float, mass: float) -> None:
    """A locked bed is a rigid mass: fed the voltage that `demand` gives, the exciter shakes it at
    the set level.
    """
    model, motion = exciter(name), Waveform(frequency, 5.0)
    use = asked(model, -mass * motion.acceleration * np.sin(phases()), motion)
    found = forwards(model, mass, motion.omega, use.voltage * model.voltage_peak)
    # rtol 1e-10 of the integrator, a few hundred steps, times the condition of the shooting
    # (lightly damped mount)
    assert found["load"] == pytest.approx(motion.length_unit, rel=1e-6)
    assert found["current"] == pytest.approx(use.current * model.current_peak, rel=1e-6)
    assert found["stroke"] == pytest.approx(use.stroke * model.stroke, rel=1e-6)
    assert use.force * model.force_peak == pytest.approx(
        model.force_constant * found["current"], rel=1e-6
    )
    assert use.peak * model.force_peak == pytest.approx(mass * motion.acceleration, rel=1e-12)
    assert use.buckling * model.stinger_buckling == pytest.approx(
        mass * motion.acceleration, rel=1e-12
    )


@pytest.mark.parametrize("name", MODELS)
def test_without_a_load_the_armature_still_has_to_be_moved(name: str) -> None:
    model, motion = exciter(name), Waveform(20.0, 5.0)
    use = asked(model, np.zeros(PER_CYCLE), motion)
    found = forwards(model, 0.0, motion.omega, use.voltage * model.voltage_peak)
    assert found["armature"] == pytest.approx(motion.length_unit, rel=1e-6)
    assert found["current"] == pytest.approx(use.current * model.current_peak, rel=1e-6)
    assert found["stroke"] == pytest.approx(use.stroke * model.stroke, rel=1e-6)
    assert (use.peak, use.buckling) == (0.0, 0.0)


def test_heavy_body_and_no_springs_leave_newton_and_ohm() -> None:
    """Body at rest, no springs, no inductance: BL i = (M + m_a) a, e = R i + BL v in quadrature,
    stroke = a/w^2.
    """
    model = replace(
        exciter("JZ-30"),
        body_mass=1e15,
        flexure_stiffness=1e-9,
        flexure_damping_ratio=0.0,
        isolation_stiffness=1e-9,
        stinger_stiffness=1e15,
        inductance=0.0,
    )
    motion, mass = Waveform(20.0, 5.0), 12.0
    use = asked(model, -mass * motion.acceleration * np.sin(phases()), motion)
    thrust = (mass + model.moving_mass) * motion.acceleration
    voltage = np.hypot(
        model.resistance * thrust / model.force_constant,
        model.force_constant * motion.acceleration / motion.omega,
    )
    assert use.force == pytest.approx(thrust / model.force_peak, rel=1e-9)
    assert use.current == pytest.approx(
        thrust / model.force_constant / model.current_peak, rel=1e-9
    )
    assert use.voltage == pytest.approx(voltage / model.voltage_peak, rel=1e-9)
    assert use.stroke == pytest.approx(motion.length_unit / model.stroke, rel=1e-9)


@pytest.mark.parametrize("harmonics", [1, 7, 40])
def test_peak_of_an_impact_is_what_the_band_lets_through(harmonics: int) -> None:
    """One impulse J a cycle has every harmonic at 2 J f in phase: H of them add up to 2 H J f, less
    than the impact.
    """
    model, motion, height = exciter("JZ-30"), Waveform(20.0, 5.0), 4000.0
    force = np.zeros(PER_CYCLE)
    force[100] = height
    use = asked(model, force, motion, band=(harmonics + 0.5) * motion.frequency)
    assert use.peak == pytest.approx(
        2 * harmonics * height / PER_CYCLE / model.force_peak, rel=1e-12
    )
    assert use.buckling == pytest.approx(
        use.peak * model.force_peak / model.stinger_buckling, rel=1e-12
    )


def test_impacts_count_in_the_peak_only() -> None:
    """The other shares are rated on the fundamental: harmonics of the force do not move them."""
    model, motion = exciter("JZ-30"), Waveform(20.0, 5.0)
    sine = -12.0 * motion.acceleration * np.sin(phases())
    plain, rough = (
        asked(model, sine + spike * np.cos(9 * phases()), motion) for spike in (0.0, 30.0)
    )
    for name in ("force", "current", "voltage", "stroke"):
        assert getattr(rough, name) == pytest.approx(getattr(plain, name), rel=1e-12)
    assert rough.peak > plain.peak
