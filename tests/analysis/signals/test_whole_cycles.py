"""Where whole cycles start, and how they are put on an integer grid."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from analysis.signals.cycles import SEGMENT_CYCLES, on_grid, whole_cycles


def test_exact_grid_starts_at_the_nearest_sample_after_settling_and_delay():
    window = whole_cycles(25640, 10240.0, 20.0, filter_delay=38.9375, settle=10, cycles=40)
    assert window.grid.exact
    assert (window.start, window.cycles) == (10 * 512 + 39, 40)
    assert window.sample_range() == (5159, 5159 + 40 * 512)


def test_as_many_cycles_as_fit():
    assert (
        whole_cycles(25600, 10240.0, 20.0, filter_delay=38.9375, settle=10, cycles=40).cycles == 39
    )
    assert whole_cycles(25600, 10240.0, 20.0).cycles == 50


@settings(deadline=None)
@given(
    frequency=st.floats(5.0, 100.0), settle=st.integers(0, 12), record=st.integers(1, 200),
    delay=st.floats(6.0, 60.0),
)  # fmt: skip
def test_a_record_of_the_campaign_s_length_holds_all_its_cycles(frequency, settle, record, delay):
    """ceil((settle + record) cycles + delay) + 1 samples: every wanted cycle is found, within the
    record.

    The delay (39 samples in the product) leaves room for the interpolation's neighbours.
    """
    rate = 25600.0
    samples = int(np.ceil((settle + record) * rate / frequency + delay)) + 1
    window = whole_cycles(
        samples, rate, frequency, filter_delay=delay, settle=settle, cycles=record
    )
    parts = window.segments()
    assert sum(part.cycles for part in parts) == record == window.cycles
    assert max(part.cycles for part in parts) <= SEGMENT_CYCLES
    for part in parts:
        first, last = part.sample_range()
        assert 0 <= first < last <= samples
        read = on_grid(np.zeros(last - first), first, part)
        assert read.size == part.cycles * part.grid.points
    # At most a few samples before the drive's own cycle start.
    assert -5 <= window.start - (settle * rate / frequency + delay) <= 2.5


@settings(deadline=None)
@given(frequency=st.floats(15.0, 60.0), degree=st.integers(0, 5))
def test_interpolation_is_exact_for_quintics(frequency, degree):
    """Six points carry any polynomial of degree 5; rounding is relative to its largest value."""
    samples = 1024
    x = np.arange(samples) / samples
    window = whole_cycles(samples, 10240.0, frequency)
    grid = window.grid
    at = (
        window.start + np.arange(window.cycles * grid.points) * grid.period / grid.points
    ) / samples
    assert on_grid(x**degree, 0, window) == pytest.approx(at**degree, abs=1e-12)


def test_interpolation_of_two_channels_is_that_of_each():
    rng = np.random.default_rng(1)
    both = rng.standard_normal((2, 4000))
    window = whole_cycles(4000, 10240.0, 23.0)
    together = on_grid(both, 0, window)
    assert np.array_equal(together[0], on_grid(both[0], 0, window))
    assert np.array_equal(together[1], on_grid(both[1], 0, window))


def test_segments_join_to_the_whole():
    rng = np.random.default_rng(2)
    samples = rng.standard_normal(100 * 500)
    window = whole_cycles(samples.size, 10240.0, 20.7)
    whole = on_grid(samples, 0, window)
    parts = []
    for part in window.segments():
        first, last = part.sample_range()
        parts.append(on_grid(samples[first:last], first, part))
    # Positions are counted from each part's own start: they differ by rounding, 1e-16 of 50000
    # samples.
    assert np.concatenate(parts) == pytest.approx(whole, abs=1e-9)
