"""Energies per cycle against exact signals: laws, signs, invariances."""

import numpy as np
import pytest
from analytic_record import FILTER_DELAY, OMEGA, RATE, dashpot_energy, drive_time, motion
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis import dissipated_energy
from analysis.energy.per_cycle import Total, window_energy

# The velocity rule is wrong by 11/720 (w dt)^4 = 3.5e-10 at 512 samples per cycle: the tolerance of
# smooth signals.
SMOOTH = 1e-9
CYCLES = 50
N = CYCLES * 512


def read(force: np.ndarray, acceleration: np.ndarray, **options):
    return dissipated_energy(force, acceleration, RATE, 20.0, **options)


def test_a_dashpot_gives_its_energy_and_a_positive_one():
    a, v = motion(drive_time(N, delay=0), 5.0)
    energy = read(30.0 * v, a)
    assert energy.cycles == CYCLES
    assert energy.W > 0
    assert pytest.approx(dashpot_energy(30.0, 5.0), rel=SMOOTH) == energy.W
    assert pytest.approx(energy.W, rel=SMOOTH) == energy.W_phasor
    assert energy.W_cycles == pytest.approx(np.full(CYCLES, energy.W), rel=1e-9)


def test_a_source_of_energy_is_negative():
    a, v = motion(drive_time(N, delay=0), 5.0)
    assert pytest.approx(-dashpot_energy(30.0, 5.0), rel=SMOOTH) == read(-30.0 * v, a).W


def test_dry_friction_gives_four_f_x():
    """W = 4 f X. The jumps of the square wave are sampled: each may be misplaced by half a step
    where v = 0, so the error is of order (w dt / 2)^2 of W per jump."""
    t = drive_time(N, delay=0.5)  # jumps midway between samples
    a, v = motion(t, 5.0)
    energy = read(40.0 * np.sign(v), a)
    expected = 4 * 40.0 * 5.0 / OMEGA**2
    assert pytest.approx(expected, rel=(OMEGA / RATE) ** 2) == energy.W


def test_mass_beside_a_dashpot_changes_the_apparent_mass_only():
    a, v = motion(drive_time(N, delay=0), 5.0)
    light, heavy = read(30 * v + 12.0 * a, a), read(30 * v + 12.5 * a, a)
    assert pytest.approx(light.W, rel=1e-9) == heavy.W
    assert light.M_eff == pytest.approx(12.0, rel=1e-12)
    assert heavy.M_eff == pytest.approx(12.5, rel=1e-12)
    assert light.eta == pytest.approx(30 / (12.0 * OMEGA), rel=SMOOTH)


def test_third_harmonic_in_both_channels_carries_its_own_energy():
    """W = sum over harmonics of pi c h w X_h^2, X_h = a_h / (h w)^2."""
    t = drive_time(N, delay=0)
    a1, v1 = motion(t, 5.0)
    a3, v3 = motion(t, 0.5, 60.0)
    energy = read(30 * (v1 + v3) + 12 * (a1 + a3), a1 + a3)
    # Work of the third harmonic per *drive* cycle: three of its own cycles.
    expected = dashpot_energy(30, 5.0) + 3 * dashpot_energy(30, 0.5, 60.0)
    third = (3 * OMEGA / RATE) ** 4 * 11 / 720
    assert pytest.approx(expected, rel=SMOOTH + third) == energy.W
    assert pytest.approx(expected, rel=1e-11) == energy.W_phasor
    assert abs(energy.acceleration[2]) == pytest.approx(0.5, rel=1e-12)
    assert energy.thd_force == pytest.approx(
        abs(12 + 30 / (3j * OMEGA)) * 0.5 / (abs(12 + 30 / (1j * OMEGA)) * 5)
    )


@settings(deadline=None)
@given(
    c=st.floats(0.1, 1e3), mass=st.floats(0.1, 100), a0=st.floats(0.1, 50), phase=st.floats(0, 6.3),
    offsets=st.tuples(st.floats(-10, 10), st.floats(-1, 1)),
)  # fmt: skip
def test_estimators_agree_whatever_the_phase_and_offset(c, mass, a0, phase, offsets):
    """Parseval: on whole cycles the three are one number. Rounding is relative to the force times
    velocity at clearance.
    """
    t = drive_time(8 * 512, delay=0) + phase / OMEGA
    a, v = motion(t, a0)
    energy = read(mass * a + c * v + offsets[0], a + offsets[1], box_mass=mass)
    in_clearance = np.pi * (mass + c / OMEGA) * a0**2 / OMEGA**2 + abs(offsets[0]) * a0 / OMEGA**2
    assert pytest.approx(dashpot_energy(c, a0), rel=SMOOTH, abs=1e-11 * in_clearance) == energy.W
    assert energy.W_phasor == pytest.approx(energy.W, rel=SMOOTH, abs=1e-11 * in_clearance)
    assert energy.W_eq25 == pytest.approx(energy.W, rel=SMOOTH, abs=1e-11 * in_clearance)
    assert abs(energy.W_kin) < 1e-11 * in_clearance


@settings(deadline=None)
@given(scale=st.floats(1e-3, 1e3))
def test_energy_scales_with_force_times_acceleration(scale):
    a, v = motion(drive_time(4 * 512, delay=0), 3.0)
    one = read(30 * v + 12 * a, a)
    assert pytest.approx(scale * one.W, rel=1e-9) == read(scale * (30 * v + 12 * a), a).W
    assert pytest.approx(scale * one.W, rel=1e-9) == read(30 * v + 12 * a, scale * a).W


def test_poles_are_undone_exactly():
    """A one-pole high pass turns a steady sine by atan(1/(w tau)): without correction W is far off,
    with it exact.
    """
    tau_f, tau_a = 2000.0, 1.6
    t = drive_time(N, delay=0)
    gain = [1j * OMEGA * tau / (1 + 1j * OMEGA * tau) for tau in (tau_f, tau_a)]
    turn = np.exp(1j * OMEGA * t)
    A, V = 5.0j, 5.0j / (1j * OMEGA)
    F = 38 * A + 30 * V
    force, acceleration = (gain[0] * F * turn).real, (gain[1] * A * turn).real
    raw = read(force, acceleration)
    mended = read(force, acceleration, time_constants=(tau_f, tau_a))
    expected = dashpot_energy(30, 5)
    bias = np.pi / OMEGA**2 * 38 * 25 * np.arctan(1 / (OMEGA * tau_a))
    assert raw.W - expected == pytest.approx(bias, rel=2e-3)  # the force's own pole is 1/1250 of it
    assert pytest.approx(expected, rel=SMOOTH, abs=1e-12) == mended.W
    # What the pole adds is 1/(w tau) = 1/200 of the signal, and integrated to 3.5e-10.
    assert mended.acceleration[0] == pytest.approx(A, rel=1e-11)
    assert mended.force[0] == pytest.approx(F, rel=1e-11)


def test_a_delay_between_the_channels_is_undone():
    late = 3.7e-5
    t = drive_time(N, delay=0)
    a, v = motion(t, 5.0)
    delayed, _ = motion(t - late, 5.0)
    force = 38 * a + 30 * v
    expected = dashpot_energy(30, 5)
    assert read(force, delayed).W - expected == pytest.approx(
        -np.pi / OMEGA**2 * 38 * 25 * np.sin(OMEGA * late), rel=1e-3
    )
    assert pytest.approx(expected, rel=SMOOTH) == read(force, delayed, delay=late).W


@pytest.mark.parametrize("frequency", [20.3, 19.97, 33.333, 9.1])
def test_any_number_of_samples_per_cycle(frequency):
    """Off the integer grid samples are interpolated; at 300 per cycle and more the error is below
    1e-9.
    """
    w = 2 * np.pi * frequency
    t = drive_time(N)
    a, v = motion(t, 5.0, frequency)
    energy = dissipated_energy(
        38 * a + 30 * v, a, RATE, frequency, filter_delay=FILTER_DELAY, settle=2
    )
    points = RATE / frequency
    assert (
        pytest.approx(dashpot_energy(30, 5, frequency), rel=(2 * np.pi / points) ** 4) == energy.W
    )
    assert energy.W_phasor == pytest.approx(energy.W, rel=1e-8)
    # The window starts at the drive's cycle start: a = -a0 sin(wt) has the phasor +j a0.
    assert energy.acceleration[0] == pytest.approx(5j, rel=1e-8)
    assert energy.M_eff == pytest.approx(38, rel=1e-9)
    assert energy.W_kin == pytest.approx(0, abs=1e-9)
    assert w * energy.eta == pytest.approx(30 / 38 * 1, rel=1e-6)


def test_long_records_are_read_in_parts_to_the_same_numbers():
    """Amplitude grows from cycle to cycle here, so that the parts differ."""
    t = drive_time(150 * 512, delay=0)
    a, v = motion(t, 5.0)
    growth = 1 + 0.002 * np.floor(t * 20.0 + 1e-9)
    whole = read(growth * (30 * v + 12 * a), a)
    parts = [
        read(growth[s] * (30 * v + 12 * a)[s], a[s])
        for s in np.split(np.arange(a.size), [64 * 512, 128 * 512])
    ]
    assert whole.cycles == 150
    assert pytest.approx(sum(p.W * p.cycles for p in parts) / 150, rel=1e-12) == whole.W
    assert pytest.approx(dashpot_energy(30, 5) * growth.mean(), rel=1e-8) == whole.W
    assert whole.force[0] == pytest.approx(
        sum(p.force[0] * p.cycles for p in parts) / 150, rel=1e-9
    )


def test_a_total_weights_with_cycles():
    a, v = motion(drive_time(12 * 512, delay=0), 5.0)
    cut = 4 * 512
    first = window_energy(30 * v[:cut], a[:cut], 4, 20.0)
    second = window_energy(60 * v[cut:], a[cut:], 8, 20.0)
    total = Total()
    for part in (first, second):
        total.add(part)
    both = total.energy()
    assert pytest.approx(dashpot_energy(50, 5), rel=SMOOTH) == both.W
    assert both.W_cycles.shape == (12,)


def test_what_cannot_be_read_is_named():
    a, v = motion(drive_time(1000, delay=0), 5.0)
    with pytest.raises(ValueError, match="equally long"):
        read(v[:-1], a)
    with pytest.raises(ValueError, match="finite"):
        read(np.where(np.arange(1000) == 5, np.nan, v), a)
    with pytest.raises(ValueError, match="no whole cycle"):
        read(v[:500], a[:500])
    with pytest.raises(ValueError, match="at least 4"):
        dissipated_energy(v, a, RATE, 3000.0)


def test_box_energy_counts_where_the_level_drifts():
    """v = .04 (1 + .1 t) cos(wt): of W_exc the box keeps what its speed grows from first to last
    cycle start.
    """
    t = drive_time(40 * 512, delay=0)
    a = 0.04 * (0.1 * np.cos(OMEGA * t) - (1 + 0.1 * t) * OMEGA * np.sin(OMEGA * t))
    energy = read(12 * a, a, box_mass=12.0)
    t_last = 39 / 20.0
    expected = 0.5 * 12 * 0.04**2 * ((1 + 0.1 * t_last) ** 2 - 1) / 39
    assert energy.W_kin == pytest.approx(expected, rel=1e-2)
    assert abs(energy.W_eq25) < 0.03 * energy.W_exc
