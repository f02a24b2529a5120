"""What a record tells of its channels, on signals made here: found where it is, and not where there
is only scatter.
"""

import dataclasses

import numpy as np
import pytest
from analytic_record import NOMINAL, OMEGA

from analysis.signals.cycles import Grid, Window, clear_of
from analysis.signals.quality import STUCK, changes, doubts, features, longest_stuck

POINTS, CYCLES, SIGMA = 512, 40, 5e-4
CHANNEL = dataclasses.replace(NOMINAL["acceleration"], noise_rms=SIGMA)


def record(seed: int = 0, cycles: int = CYCLES) -> np.ndarray:
    """A sine of 3 m/s^2 with white noise, (cycles, POINTS)."""
    t = np.arange(cycles * POINTS) / POINTS
    noise = SIGMA * np.random.default_rng(seed).standard_normal(t.size)
    return (3.0 * np.sin(2 * np.pi * t) + noise).reshape(cycles, POINTS)


def found(x: np.ndarray, smooth: bool = True, settled: float = 20.0) -> tuple[str, ...]:
    part = features(x.ravel(), len(x), smooth, longest_stuck(x.ravel()))
    return doubts(CHANNEL, part, OMEGA, settled, smooth)


def test_a_healthy_record_raises_no_doubt() -> None:
    """300 records of 40 cycles; steps of 10 of their deviations, lone spikes five times the rest:
    never by chance.
    """
    assert all(found(record(seed)) == () for seed in range(300))


def test_alternation_of_a_bed_is_scatter_and_no_step() -> None:
    """Periods of 2 and 3 cycles, 5 % in size: neither a gain step nor anything else."""
    for period in (2, 3):
        x = record() * (1 + 0.05 * (np.arange(CYCLES) % period == 0))[:, None]
        assert found(x, smooth=False) == ()


@pytest.mark.parametrize("cycle", [5, 20, 34])
def test_each_change_by_its_name(cycle: int) -> None:
    late, whole = np.arange(CYCLES) >= cycle, record()
    turned = np.concatenate(
        [whole.ravel()[: cycle * POINTS], np.roll(whole.ravel(), 1)[cycle * POINTS :]]
    )
    slope = 0.1 * np.arange(CYCLES * POINTS).reshape(whole.shape) / whole.size
    louder = np.random.default_rng(1).standard_normal(whole.shape) * 5 * SIGMA * late[:, None]
    spike = np.zeros_like(whole)
    spike[cycle, 100] = 30 * SIGMA
    for name, x in (
        ("gain_step", whole * (1 + 0.01 * late)[:, None]),
        ("clock_slip", turned.reshape(whole.shape)),
        ("bias", whole + 0.1 * late[:, None]),
        ("drift", whole + slope),
        ("noisy", whole + louder),
        ("spike", whole + spike),
    ):
        assert found(x) == (name,)


def found_free(x: np.ndarray) -> tuple[str, ...]:
    return doubts(CHANNEL, features(x.ravel(), len(x), False, free=True), OMEGA, 20.0, False)


def test_a_free_motion_glides_and_is_knocked_at_without_a_fault() -> None:
    """Phase and size that relax over 2 to 12 cycles by 20 mrad and 2 %, and one cycle with ten
    times the impacts.
    """
    t = np.arange(CYCLES * POINTS).reshape(CYCLES, POINTS) / POINTS
    for tau in (2.0, 5.0, 12.0):
        left = 0.02 * np.exp(-t / tau)
        glides = (1 + left) * 3.0 * np.sin(2 * np.pi * t + left) + (
            record() - 3.0 * np.sin(2 * np.pi * t)
        )
        assert "clock_slip" in found(glides, smooth=False)
        assert found_free(glides) == ()
    x = record()
    x[20, 5::25] += 30 * SIGMA
    assert found(x, smooth=False) == ("noisy",)
    assert found_free(x) == ()


@pytest.mark.parametrize("cycle", [5, 20, 34])
def test_a_fault_of_a_free_motion_is_sudden_or_between_the_impacts(cycle: int) -> None:
    whole = record()
    whole[:, 5::25] += 30 * SIGMA * np.random.default_rng(2).standard_normal(whole[:, 5::25].shape)
    late = np.arange(CYCLES) >= cycle
    turned = np.concatenate(
        [whole.ravel()[: cycle * POINTS], np.roll(whole.ravel(), 1)[cycle * POINTS :]]
    )
    loud = (np.abs(np.arange(CYCLES) - cycle) < 4)[:, None]
    noise = np.random.default_rng(1).standard_normal(whole.shape) * 40 * SIGMA * loud
    assert found_free(whole * (1 + 0.01 * late)[:, None]) == ("gain_step",)
    assert found_free(turned.reshape(whole.shape)) == ("clock_slip",)
    assert found_free(whole + noise) == ("noisy",)
    assert found_free(whole) == ()


def test_what_is_less_than_the_limits_is_let_pass() -> None:
    late = (np.arange(CYCLES) >= 20)[:, None]
    assert found(record() * (1 + 0.004 * late)) == ()
    assert found(record() + 0.012 * late) == ()


def test_the_start_of_the_poles_is_no_drift() -> None:
    """A pole of 1.6 s that starts with the drive leaves e^(-t/tau)/(w tau) of the fundamental in
    the mean.
    """
    tau = CHANNEL.time_constant
    assert tau is not None
    t = np.arange(CYCLES * POINTS).reshape(CYCLES, POINTS) / POINTS / 20.0
    x = record() + 3.0 * np.exp(-(t + 0.5) / tau) / (OMEGA * tau)
    assert found(x, settled=0.5) == ()
    assert "drift" in found(
        record() + 10 * 3.0 * np.exp(-(t + 0.5) / tau) / (OMEGA * tau), settled=0.5
    )


def test_stuck_values_and_no_signal() -> None:
    x = record()
    x[10, 50 : 50 + STUCK] = x[10, 50]
    assert longest_stuck(x.ravel()) == STUCK
    assert "stuck" in found(x)
    assert "no_signal" in found(
        record() * 0 + SIGMA * np.random.default_rng(2).standard_normal((CYCLES, POINTS))
    )
    assert longest_stuck(np.repeat(np.arange(1000.0), 3)) == 3
    assert longest_stuck(np.zeros(100)) == 100


def test_a_clipping_sensor_is_told() -> None:
    clipping = dataclasses.replace(CHANNEL, clips_at=0.03, sensitivity=0.01)
    x = np.clip(record(), -2.99, 2.99)
    assert "sensor_clip" in doubts(clipping, features(x.ravel(), CYCLES, True), OMEGA, 20.0, True)


def test_changes_from_stretch_to_stretch() -> None:
    one, other = record(1, 64), record(2, 64)
    parts = [features(x.ravel(), 64, True) for x in (one, other, 1.01 * other, other + 0.1)]
    assert changes(CHANNEL, parts[0], parts[1], OMEGA, 20.0) == ()
    assert changes(CHANNEL, parts[0], parts[2], OMEGA, 20.0) == ("gain_step",)
    assert changes(CHANNEL, parts[0], parts[3], OMEGA, 20.0) == ("bias",)


def test_cycles_clear_of_bad_samples() -> None:
    window = Window(Grid(512.0, 512), 5159.0, 40)
    assert clear_of(window, []) == (window,)
    left = clear_of(window, [(5159 + 10 * 512 + 5, 5159 + 12 * 512)])
    assert [(w.start, w.cycles) for w in left] == [(5159.0, 10), (5159.0 + 12 * 512, 28)]
    assert clear_of(window, [(0, 10**6)]) == ()
    off_grid = Window(Grid(512.4, 514), 5159.3, 40)
    needed = [range(*w.sample_range()) for w in clear_of(off_grid, [(9000, 9010)])]
    assert all(9000 not in samples and 9009 not in samples for samples in needed)
    assert sum(w.cycles for w in clear_of(off_grid, [(9000, 9010)])) == 39
