"""Data sheets, certified and actual states."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from daq.chain.channel import (
    AnalyzerSpec,
    Channel,
    NoSuchRate,
    TransducerSpec,
    certified_state,
    channel_info,
    draw_clock_error,
    draw_state,
    ideal_analyzer,
    ideal_transducer,
)

INV = AnalyzerSpec("INV-3118", (102400.0, *(51200.0 / n for n in range(1, 32))))
SPEC = TransducerSpec("352C33", "acceleration", "m/s^2", 0.0102, 490.0, 1.6, 0.1, 1.5e-3, 1e4, 0.01)
CHANNEL = Channel("acceleration", SPEC, 1.0, "A1", "+x")


def test_the_rate_for_20_Hz_is_the_paper_setting() -> None:
    assert INV.rate_for(20.0, 500) == 10240.0
    assert INV.rate_for(20.0, 512) == 10240.0


@given(frequency=st.floats(0.1, 200.0), samples=st.floats(10, 2000))
def test_the_rate_is_the_slowest_that_is_fast_enough(frequency: float, samples: float) -> None:
    enough = [rate for rate in INV.rates if rate >= frequency * samples * (1 - 1e-12)]
    if enough:
        assert INV.rate_for(frequency, samples) == min(enough)
    else:
        with pytest.raises(NoSuchRate, match="INV-3118"):
            INV.rate_for(frequency, samples)


def test_actual_states_scatter_as_certified() -> None:
    """Means and spreads of N draws within 5 of their own standard errors."""
    n = 4000
    states = [draw_state(CHANNEL, INV, np.random.default_rng(i)) for i in range(n)]
    sensitivity = np.array([s.sensitivity for s in states]) / SPEC.sensitivity - 1
    pole = np.log([s.time_constant for s in states]) - math.log(1.6)
    gain = np.array([s.gain for s in states]) - 1
    for values, sigma in ((sensitivity, 0.005), (pole, 0.1), (gain, 0.003 / math.sqrt(3))):
        assert abs(values.mean()) < 5 * sigma / math.sqrt(n)
        assert values.std() == pytest.approx(sigma, rel=5 / math.sqrt(2 * n))
    assert np.abs(gain).max() <= 0.003


def test_leaving_the_pole_out_changes_no_other_draw() -> None:
    without = dataclasses.replace(CHANNEL, transducer=dataclasses.replace(SPEC, time_constant=None))
    a, b = (draw_state(channel, INV, np.random.default_rng(3)) for channel in (CHANNEL, without))
    assert b.time_constant is None
    assert (a.sensitivity, a.gain) == (b.sensitivity, b.gain)


@pytest.mark.parametrize("quantity", ["force", "acceleration"])
def test_ideal_instruments_are_what_their_certificate_says(quantity: str) -> None:
    channel = Channel(quantity, ideal_transducer(quantity), 10.0, "", "+x")  # type: ignore[arg-type]
    assert draw_state(channel, ideal_analyzer(), np.random.default_rng(1)) == certified_state(
        channel
    )
    assert draw_clock_error(ideal_analyzer(), np.random.default_rng(1)) == 0.0
    assert channel_info(channel, ideal_analyzer(), 10240.0, 39.0).noise_rms == 0.0


def test_clock_errors_are_rectangular() -> None:
    errors = np.array([draw_clock_error(INV, np.random.default_rng(i)) for i in range(2000)])
    assert np.abs(errors).max() <= 50e-6
    assert errors.std() == pytest.approx(50e-6 / math.sqrt(3), rel=5 / math.sqrt(2 * 2000))


def test_noise_scales_with_band_and_range() -> None:
    assert INV.noise_in_band(10.0, 51200.0) == pytest.approx(50e-6)
    assert INV.noise_in_band(1.0, 51200.0 / 4) == pytest.approx(2.5e-6)
    assert SPEC.noise_in_band(20000.0) == pytest.approx(1.5e-3)
    assert SPEC.noise_in_band(5000.0) == pytest.approx(0.75e-3)
    assert SPEC.noise_in_band(102400.0) == pytest.approx(1.5e-3)  # all of it, no more


def test_the_channel_table_holds_certified_values() -> None:
    info = channel_info(CHANNEL, INV, 10240.0, 38.9375)
    assert (info.sensitivity, info.time_constant, info.calibration_U) == (0.0102, 1.6, 0.01)
    assert info.scale == 1.0 / 2**23
    assert info.pole_Hz == pytest.approx(0.0995, abs=1e-4)
    expected = np.hypot(1.5e-3 * math.sqrt(0.512), 5e-6 * math.sqrt(0.2) / 0.0102)
    assert info.noise_rms == pytest.approx(expected, rel=1e-12)


def test_specs_can_be_keys_and_compared() -> None:
    assert hash(SPEC) == hash(dataclasses.replace(SPEC, statuses={"sensitivity": "recalled"}))
    assert dataclasses.replace(SPEC, statuses={"sensitivity": "recalled"}) != SPEC
