"""Poles and delays are undone in whole records: against the exact response of each harmonic."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from analysis.signals.corrected_signal import CorrectedSignal

RATE, FREQUENCY, POINTS = 10240.0, 20.0, 512
OMEGA = 2 * np.pi * FREQUENCY
CYCLES, SETTLE = 10, 2
WINDOW = (SETTLE * POINTS, (SETTLE + CYCLES) * POINTS)
PARTS = ((1, 1.0, 0.3), (3, 0.2, 1.0), (25, 0.05, 2.0))  # harmonic, amplitude, phase


def all_pass(_h):
    return 1.0


def motion(t, response=all_pass):
    return sum((a * np.exp(1j * (h * OMEGA * t + p)) * response(h)).real for h, a, p in PARTS)


def corrected(values, poles=(), lag=0.0):
    return CorrectedSignal(lambda i, j: values[i:j], values.size, WINDOW, 1 / RATE, poles, lag)


TIMES = np.arange((SETTLE + CYCLES) * POINTS + 37) / RATE


@given(st.floats(-8.0, 8.0))
def test_a_delay_is_undone(samples):
    """The filter is flat to 1e-5 up to .45 of the rate (Kaiser, beta 10, 65 taps); the ends are
    extrapolated.
    """
    found = corrected(motion(TIMES - samples / RATE), lag=samples / RATE).samples()
    assert found[100:-100] == pytest.approx(motion(TIMES)[100:-100], abs=1e-5)


@given(st.floats(0.05, 100.0), st.floats(0.05, 100.0), st.floats(-10.0, 10.0))
def test_two_poles_are_undone_but_for_a_constant(first, second, offset):
    """The trapezoidal rule is off by (2 pi h / N)^2 / 12 of each correction 1 / (h w tau)."""
    poles = (first, second)

    def high_pass(h):
        return np.prod([1j * h * OMEGA * tau / (1 + 1j * h * OMEGA * tau) for tau in poles])

    found = corrected(motion(TIMES, high_pass) + offset, poles).samples()
    apart = (found - motion(TIMES))[slice(*WINDOW)]
    allowed = sum(
        a * (2 * np.pi * h / POINTS) ** 2 / 12 * sum(1 / (h * OMEGA * tau) for tau in poles)
        for h, a, _ in PARTS
    )
    assert np.abs(apart - apart.mean()).max() <= 2 * allowed + 1e-9 * (1 + abs(offset))


@given(st.integers(1, 3000))
def test_the_length_of_the_chunks_changes_nothing(length):
    signal = corrected(motion(TIMES) + 0.1, (0.5, 0.3), 0.3 / RATE)
    pieces = list(signal.chunks(length))
    assert all(piece.size == length for piece in pieces[:-1])
    # a running sum is cut at other places: round-off of a sum of 6000 terms
    assert np.concatenate(pieces) == pytest.approx(signal.samples(), abs=1e-11)


def test_nothing_to_undo_leaves_the_samples():
    values = motion(TIMES)
    assert (corrected(values).samples() == values).all()
