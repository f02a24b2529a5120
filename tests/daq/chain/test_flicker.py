"""1/f noise: through the sheet's spots, and of the size that is stated."""

import dataclasses
import math

import numpy as np
import pytest
from daq_signals import RATE, Analytic, constant

from daq.chain.channel import (
    SPOTS,
    Channel,
    ChannelState,
    TransducerSpec,
    channel_info,
    ideal_analyzer,
)
from daq.chain.frontend import BLOCK, FrontEnd
from daq.chain.noise import Flicker, sections

SHEET = tuple(9.80665e-6 * spot for spot in (39.0, 11.0, 3.4, 1.4))
SPEC = TransducerSpec(
    "352C33", "acceleration", "m/s^2", 0.0102, 490.0, None, 0.0, 1.5e-3, 1e4, 0.0, noise_spots=SHEET
)  # fmt: skip


def density(f: np.ndarray, spots: tuple[float, ...]) -> np.ndarray:
    """One-sided power density of sections and white floor."""
    power = sum(
        s / (1 + (f / corner) ** 2) for s, corner in zip(sections(spots), SPOTS, strict=False)
    )
    return np.asarray(power + spots[-1] ** 2)


def test_the_density_lies_on_the_spots() -> None:
    np.testing.assert_allclose(np.sqrt(density(np.array(SPOTS[:3]), SHEET)), SHEET[:3], rtol=1e-12)
    assert np.sqrt(density(np.array(SPOTS[3:]), SHEET))[0] == pytest.approx(SHEET[3], rel=0.05)


def test_between_the_spots_it_follows_the_straight_line() -> None:
    """Half a decibel about the line through the spots in log-log."""
    f = np.geomspace(1, 100, 50)
    line = np.exp(np.interp(np.log(f), np.log(SPOTS), np.log(SHEET)))
    assert np.abs(20 * np.log10(np.sqrt(density(f, SHEET)) / line)).max() < 0.8


def test_what_is_made_has_this_density() -> None:
    """Averages of periodograms in thirds of an octave, 64 segments of 1.6 s: each within 5 of its
    own deviations.
    """
    n, segments = 2**14, 64
    flicker = Flicker(SHEET, 1.0, RATE, np.random.default_rng(1))
    total = np.zeros(n // 2 + 1)
    window = np.hanning(n)
    for _ in range(segments):
        part = np.zeros(n)
        flicker.add(part)
        total += np.abs(np.fft.rfft(part * window)) ** 2
    found = total / segments * 2 / (RATE * (window**2).sum())
    f = np.fft.rfftfreq(n, 1 / RATE)
    expected = density(f, SHEET) - SHEET[-1] ** 2
    for low in 2.0 ** np.arange(
        2, 9, 1 / 3
    ):  # from 4 Hz: the window leaks below; to 0.05 of the rate: no aliasing
        band = (f >= low) & (f < low * 2 ** (1 / 3))
        independent = segments * band.sum() / 1.5  # the window's equivalent noise bandwidth
        assert found[band].sum() / expected[band].sum() == pytest.approx(
            1, abs=5 / math.sqrt(independent)
        )


def test_cutting_changes_the_draws_and_nothing_else_draws_them() -> None:
    """The front end works in blocks of one size: equal blocks, equal noise; without spots the
    stream is untouched.
    """
    channel = Channel("a", SPEC, 1.0, "", "+x")
    codes = []
    for _ in range(2):
        rng = np.random.default_rng(5)
        front = FrontEnd(
            ideal_analyzer(), [channel], [ChannelState(0.0102, None, 1.0)], RATE, [rng]
        )
        codes.append(front.convert(Analytic(constant(0.0)).volts(8 * BLOCK)))
    np.testing.assert_array_equal(codes[0], codes[1])


def test_the_channel_table_states_it() -> None:
    """K/f above every spot's excess: 39^2 x 1, 11^2 x 10, 3.4^2 x 100 less the floor: the first is
    the largest.
    """
    info = channel_info(Channel("a", SPEC, 1.0, "", "+x"), ideal_analyzer(), RATE, 0.0)
    assert info.flicker == pytest.approx(9.80665e-6 * math.sqrt(39**2 - 1.4**2), rel=1e-12)
    assert info.noise_rms == pytest.approx(SHEET[-1] * math.sqrt(RATE / 2), rel=1e-12)
    without = dataclasses.replace(SPEC, noise_spots=())
    assert (
        channel_info(Channel("a", without, 1.0, "", "+x"), ideal_analyzer(), RATE, 0.0).flicker
        == 0.0
    )


def test_spots_that_rise_are_refused() -> None:
    with pytest.raises(ValueError, match="falling sections"):
        sections((1.0, 5.0, 2.0, 1.0))
