"""The anti-alias filter against scipy.signal, which the product does not use."""

import numpy as np
import pytest
from scipy import signal

from daq.chain.fir import (
    DELAY,
    STAGE1,
    STAGE1_ATTENUATION,
    STAGE1_CUTOFF,
    STAGE2,
    Decimator,
    shifted_lowpass,
)


def whole_filter(skew: float = 0.0) -> np.ndarray:
    """Both stages as one filter at the oversampled rate (noble identity)."""
    spread = np.zeros(4 * (len(STAGE2) - 1) + 1)
    spread[::4] = STAGE2
    stage1 = (
        shifted_lowpass(len(STAGE1), STAGE1_CUTOFF, STAGE1_ATTENUATION, skew) if skew else STAGE1
    )
    return np.convolve(stage1, spread)


def test_pass_band_and_stop_band() -> None:
    f, h = signal.freqz(whole_filter(), worN=2**17, fs=8.0)  # in units of the output rate
    decibels = 20 * np.log10(np.maximum(np.abs(h), 1e-15))
    assert np.abs(decibels[f <= 0.45]).max() <= 1e-4
    assert decibels[f >= 0.55].max() < -100


def test_gain_at_zero_frequency_is_one_to_rounding() -> None:
    for stage in (STAGE1, STAGE2):
        assert abs(stage.sum() - 1) <= 2 * np.finfo(float).eps


def test_the_delay_is_a_whole_number_of_output_samples() -> None:
    h = whole_filter()
    assert DELAY == 39.0
    assert (len(h) - 1) / 2 / 8 == DELAY
    np.testing.assert_allclose(h, h[::-1], rtol=1e-12, atol=1e-18)  # linear phase


def test_stage_2_is_a_half_band_filter() -> None:
    assert STAGE2[71] == 0.5
    assert np.all(STAGE2[1:71:2] == 0.0)
    assert np.all(STAGE2[73::2] == 0.0)


@pytest.mark.parametrize("outputs", [80, 512, 700])
def test_a_stream_of_blocks_equals_one_convolution(outputs: int) -> None:
    x = np.random.default_rng(1).standard_normal(4 * 8 * outputs)
    decimator = Decimator(outputs)
    y = np.concatenate([decimator.push(part).copy() for part in np.split(x, 4)])
    expected = signal.upfirdn(whole_filter(), x, 1, 8)[: len(y)]
    # rounding: some 200 terms whose absolute weights sum to less than 3
    np.testing.assert_allclose(
        y, expected, rtol=0, atol=200 * 3 * np.finfo(float).eps * np.abs(x).max()
    )


@pytest.mark.parametrize("skew", [0.0, 0.0114, -0.114, 0.5])
def test_a_skewed_channel_has_the_same_filter_later(skew: float) -> None:
    """0.114 intervals are 0.05 deg/kHz at the fastest rate. Bands as without; delay DELAY + skew/8 to 1e-5 sample."""
    h = whole_filter(skew)
    f, response = signal.freqz(h, worN=2**15, fs=8.0)
    decibels = 20 * np.log10(np.maximum(np.abs(response), 1e-15))
    assert np.abs(decibels[f <= 0.45]).max() <= 1e-4
    assert decibels[f >= 0.55].max() < -100
    assert h.sum() == pytest.approx(1.0, abs=1e-15)
    band = (f > 0) & (f <= 0.45)
    left = response[band] * np.exp(2j * np.pi * f[band] * (DELAY + skew / 8))
    assert np.abs(np.angle(left) / (2 * np.pi * f[band])).max() < 1e-5


@pytest.mark.parametrize("outputs", [80, 700])
def test_a_skewed_stream_of_blocks_equals_one_convolution(outputs: int) -> None:
    x = np.random.default_rng(1).standard_normal(4 * 8 * outputs)
    decimator = Decimator(outputs, 0.07)
    y = np.concatenate([decimator.push(part).copy() for part in np.split(x, 4)])
    expected = signal.upfirdn(whole_filter(0.07), x, 1, 8)[: len(y)]
    np.testing.assert_allclose(
        y, expected, rtol=0, atol=200 * 3 * np.finfo(float).eps * np.abs(x).max()
    )


def test_a_skew_of_more_than_half_an_interval_is_refused() -> None:
    with pytest.raises(ValueError, match="half an interval"):
        Decimator(80, 0.6)
