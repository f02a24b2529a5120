"""Transducers: exact solutions of the high-pass pole."""

import numpy as np
import pytest
from daq_signals import OVERSAMPLED, RATE, Analytic, constant, tone
from hypothesis import given, settings
from hypothesis import strategies as st

from daq.chain.channel import ChannelState
from daq.chain.transducer import Transduced


def test_without_a_pole_volts_are_sensitivity_times_value() -> None:
    source = Analytic(constant(3.0), tone(2.0, 0.01))
    volts = Transduced(source, [ChannelState(0.5, None, 1.0), ChannelState(0.1, None, 1.0)]).volts(
        100
    )
    np.testing.assert_array_equal(volts[0], 1.5)
    np.testing.assert_array_equal(volts[1], 0.1 * Analytic(tone(2.0, 0.01)).read(100)[0])


@pytest.mark.parametrize("time_constant", [1e-5, 0.01, 1.6, 2000.0])
def test_a_step_decays_exponentially(time_constant: float) -> None:
    """Mean of e^(-t/tau) over each interval: exact for any step, so only rounding is left."""
    n, step = 5000, 1 / (OVERSAMPLED * time_constant)
    volts = Transduced(Analytic(constant(1.0)), [ChannelState(2.0, time_constant, 1.0)]).volts(n)[0]
    expected = 2.0 * np.exp(-step * np.arange(n)) * -np.expm1(-step) / step
    np.testing.assert_allclose(volts, expected, rtol=0, atol=2.0 * n * np.finfo(float).eps)


def test_a_sine_is_turned_by_the_poles_phase() -> None:
    """j w tau / (1 + j w tau), after the start has died out.

    Holding the input over an interval errs in the slow part by (w dt)^2 / 12 of 1 / (w tau): below
    1e-6 here.
    """
    frequency, time_constant = 20.0, 0.02
    omega = 2 * np.pi * frequency
    n = int(40 * OVERSAMPLED / frequency)
    volts = Transduced(
        Analytic(tone(1.0, frequency / RATE)), [ChannelState(1.0, time_constant, 1.0)]
    ).volts(n)[0]
    t = (np.arange(n) + 0.5) / OVERSAMPLED
    late = t > 1.0  # 50 time constants
    basis = np.stack([np.sin(omega * t[late]), np.cos(omega * t[late])], axis=1)
    s, c = np.linalg.lstsq(basis, volts[late], rcond=None)[0]
    pole = 1j * omega * time_constant
    assert complex(s, c) == pytest.approx(
        pole / (1 + pole) * np.sinc(frequency / OVERSAMPLED), abs=1e-6
    )


@settings(max_examples=25, deadline=None)
@given(cuts=st.lists(st.integers(1, 400), min_size=1, max_size=8))
def test_the_stream_does_not_depend_on_how_it_is_cut(cuts: list[int]) -> None:
    def made() -> Transduced:
        return Transduced(
            Analytic(tone(1.0, 0.013, 0.4), tone(1.0, 0.1)),
            [ChannelState(0.3, 0.001, 1.0), ChannelState(0.7, None, 1.0)],
        )

    cut = made()
    parts = [cut.volts(n).copy() for n in cuts]
    np.testing.assert_array_equal(np.concatenate(parts, axis=1), made().volts(sum(cuts)))


def test_the_source_is_not_changed() -> None:
    kept = np.ones((1, 50))

    class Kept:
        names = ("a",)
        rate = OVERSAMPLED

        def read(self, n: int) -> np.ndarray:
            return kept[:, :n]

    Transduced(Kept(), [ChannelState(3.0, 0.01, 1.0)]).volts(50)
    assert np.all(kept == 1.0)


def test_one_state_per_channel() -> None:
    with pytest.raises(ValueError, match="2 transducer states"):
        Transduced(Analytic(constant(0.0)), [ChannelState(1.0, None, 1.0)] * 2)
