"""The front end by pushing signals through it."""

import dataclasses

import numpy as np
import pytest
from daq_signals import RATE, Analytic, channels, constant, front_end, tone
from hypothesis import given, settings
from hypothesis import strategies as st

from daq.chain.channel import AnalyzerSpec, Channel, ChannelState, TransducerSpec, ideal_analyzer
from daq.chain.frontend import BLOCK, FILTER_DELAY, FrontEnd, NotFinite, noise_volts

FULL = 2**23
SETTLED = 78  # 2 x 39 samples
LSB = 10.0 / FULL


def pushed(source: Analytic, front: FrontEnd, blocks: int = 1) -> np.ndarray:
    return np.concatenate([front.convert(source.volts(8 * BLOCK)) for _ in range(blocks)], axis=1)


def fitted(codes: np.ndarray, frequency: float) -> complex:
    """Complex amplitude of sin(2 pi frequency n + phase) in settled codes, least squares."""
    n = np.arange(SETTLED, codes.size)
    basis = np.stack([np.sin(2 * np.pi * frequency * n), np.cos(2 * np.pi * frequency * n)], axis=1)
    s, c = np.linalg.lstsq(basis, codes[SETTLED:].astype(float), rcond=None)[0]
    return complex(s, c)


@settings(max_examples=25, deadline=None)
@given(frequency=st.floats(0.55, 4.0))
def test_tones_beyond_the_stop_band_edge_vanish(frequency: float) -> None:
    codes = pushed(
        Analytic(lambda j: 9.0 * np.sin(2 * np.pi * frequency / 8 * (j + 0.5))), front_end()
    )
    assert (
        np.abs(codes[0, SETTLED:]).max() <= 9.0 / LSB * 1e-5 + 0.5
    )  # 100 dB, and half a code of rounding


@settings(max_examples=25, deadline=None)
@given(frequency=st.floats(0.001, 0.45), phase=st.floats(0, 6.28))
def test_tones_in_the_pass_band_keep_their_size_and_their_time(
    frequency: float, phase: float
) -> None:
    """Sample n shows the drive at (n - FILTER_DELAY) / rate."""
    found = fitted(pushed(Analytic(tone(9.0, frequency, phase)), front_end())[0], frequency)
    expected = (
        9.0
        / LSB
        * np.sinc(frequency / 8)
        * np.exp(1j * (phase - 2 * np.pi * frequency * FILTER_DELAY))
    )
    ratio = found / expected
    assert abs(20 * np.log10(abs(ratio))) < 1.1e-4
    assert abs(np.angle(ratio)) / (2 * np.pi * frequency) < 1e-4  # samples


def test_a_constant_comes_out_exactly() -> None:
    for volts, code in (
        (0.0, 0),
        (5.0, FULL // 2),
        (-10.0, -FULL),
        (LSB * 3.4, 3),
        (-LSB * 3.6, -4),
    ):
        codes = pushed(Analytic(constant(volts)), front_end())
        assert np.all(codes[0, SETTLED:] == code)


def test_a_clean_sine_has_the_signal_to_noise_ratio_of_24_bits() -> None:
    """Rounding noise is 1/12 code^2. The estimate from N samples scatters by about 1/sqrt(N): 5 of
    that is 0.3 dB.
    """
    frequency = 0.5 * (np.sqrt(5) - 1) / 10
    codes = pushed(Analytic(tone(9.99, frequency)), front_end(), 2)[0]
    found = fitted(codes, frequency)
    n = np.arange(SETTLED, codes.size)
    rest = codes[SETTLED:] - (found * np.exp(2j * np.pi * frequency * n)).imag
    assert 10 * np.log10(abs(found) ** 2 / 2 / rest.var()) == pytest.approx(
        6.02 * 24 + 1.76, abs=0.3
    )


def test_the_actual_gain_scales_the_codes() -> None:
    codes = pushed(Analytic(constant(5.0)), front_end(gain=1.003))
    assert np.all(codes[0, SETTLED:] == round(FULL / 2 * 1.003))


def test_noise_has_its_size_is_white_and_differs_between_channels() -> None:
    analyzer = dataclasses.replace(ideal_analyzer(), noise_rms=50e-6)
    codes = pushed(Analytic(constant(0.0), constant(0.0)), front_end(2, analyzer), 4) * LSB
    n = codes.shape[1]
    expected = np.hypot(50e-6 * np.sqrt(RATE / 51200), LSB / np.sqrt(12))
    assert codes.std(axis=1) == pytest.approx(expected, rel=5 / np.sqrt(2 * n))
    assert np.abs(codes.mean(axis=1)).max() < 5 * expected / np.sqrt(n)
    for lag in (1, 2, 7):
        assert np.abs(
            (codes[:, lag:] * codes[:, :-lag]).mean(axis=1)
        ).max() < 5 * expected**2 / np.sqrt(n)
    assert abs((codes[0] * codes[1]).mean()) < 5 * expected**2 / np.sqrt(n)


def test_transducer_and_analyzer_noise_add_in_quadrature_in_the_recorded_band() -> None:
    """0.02 N over 10 kHz is 0.02 sqrt(.512) N in 5.12 kHz; 50 uV at 10 V and 51.2 kS/s is 5 uV sqrt(.2) at 1 V."""
    spec = TransducerSpec("208C03", "force", "N", 2.248e-3, 2200.0, None, 0.0, 0.02, 1e4, 0.01)
    sensor = 0.02 * np.sqrt(0.512) * 2.25e-3 * 1.001
    analyzer = 5e-6 * np.sqrt(0.2)
    found = noise_volts(
        Channel("force", spec, 1.0, "", "+x"),
        AnalyzerSpec("INV-3118", (RATE,)),
        ChannelState(2.25e-3, None, 1.001),
        RATE,
    )
    assert found == pytest.approx(np.hypot(sensor, analyzer), rel=1e-12)


def test_a_channel_without_noise_draws_nothing() -> None:
    rng = np.random.default_rng(1)
    front = FrontEnd(ideal_analyzer(), channels(1), [ChannelState(1.0, None, 1.0)], RATE, [rng])
    pushed(Analytic(constant(1.0)), front)
    assert rng.standard_normal() == np.random.default_rng(1).standard_normal()


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_source_that_is_not_finite_is_an_error(value: float) -> None:
    with pytest.raises(NotFinite, match="channel a"):
        pushed(Analytic(lambda j: np.where(j == 100, value, 0.0)), front_end())


def test_another_oversampling_is_refused() -> None:
    with pytest.raises(ValueError, match="oversamples 8 times"):
        front_end(analyzer=dataclasses.replace(ideal_analyzer(), oversampling=4))
