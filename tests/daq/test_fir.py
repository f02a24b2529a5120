"""The anti-alias filter against scipy.signal, which the product does not use."""

import numpy as np
import pytest
from scipy import signal

from daq.fir import DELAY, STAGE1, STAGE2, Decimator


def whole_filter() -> np.ndarray:
    """Both stages as one filter at the oversampled rate (noble identity)."""
    spread = np.zeros(4 * (len(STAGE2) - 1) + 1)
    spread[::4] = STAGE2
    return np.convolve(STAGE1, spread)


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
    np.testing.assert_allclose(y, expected, rtol=0, atol=200 * 3 * np.finfo(float).eps * np.abs(x).max())
