"""The emulated analyzer: what is particular to it beside the conformance suite."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from daq_signals import RATE, Analytic, constant, front_end, tone
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from daq.chain.acquisition import Emulated
from daq.chain.block import Block, Flag
from daq.chain.channel import Channel, ChannelState, ideal_transducer
from daq.chain.conditioning import conditioned
from daq.chain.fir import STAGE1, STAGE2
from daq.chain.frontend import BLOCK, block_size
from daq.chain.source import AnalogSource, PhysicalSource


def filtered(volts: np.ndarray) -> np.ndarray:
    """Volts at the output rate by scipy's convolution."""
    spread = np.zeros(4 * (len(STAGE2) - 1) + 1)
    spread[::4] = STAGE2
    return signal.upfirdn(np.convolve(STAGE1, spread), volts, 1, 8)[: len(volts) // 8]


@settings(max_examples=15, deadline=None)
@given(amplitude=st.floats(8.0, 14.0), frequency=st.floats(0.001, 0.1), size=st.integers(16, 400))
def test_overload_bits_stand_exactly_where_the_range_is_exceeded(
    amplitude: float, frequency: float, size: int
) -> None:
    volts = filtered(Analytic(tone(amplitude, frequency)).read(8 * BLOCK)[0])
    acquisition = Emulated(Analytic(tone(amplitude, frequency)), front_end())
    lsb = 10.0 / 2**23
    for start in range(0, BLOCK - size, size):
        part = volts[start : start + size]
        block = acquisition.read(size)
        assert block.start == start
        assert bool(block.flags[0] & Flag.OVERLOAD_HI) == bool((part > 10.0 - 1.5 * lsb).any())
        assert bool(block.flags[0] & Flag.OVERLOAD_LO) == bool((part < -10.0 + 0.5 * lsb).any())
        assert block.clipped[0] == np.count_nonzero(
            (part > 10.0 - 1.5 * lsb) | (part < -10.0 + 0.5 * lsb)
        )


def test_the_overload_of_one_channel_is_its_own() -> None:
    block = Emulated(Analytic(constant(11.0), constant(9.0)), front_end(2)).read(200)
    assert [bool(flags & Flag.OVERLOAD_HI) for flags in block.flags] == [True, False]
    assert block.clipped[1] == 0


def test_the_source_must_fit_the_front_end() -> None:
    with pytest.raises(ValueError, match="channels"):
        Emulated(Analytic(constant(0.0)), front_end(2))
    with pytest.raises(ValueError, match="expected 8 x"):
        Emulated(Analytic(constant(0.0), rate=RATE), front_end())


def test_the_source_may_run_on_the_analyzers_actual_clock() -> None:
    acquisition = Emulated(Analytic(constant(0.0), rate=8 * RATE * (1 + 50e-6)), front_end())
    assert acquisition.rate == RATE  # what the analyzer believes


def test_the_waists_are_protocols() -> None:
    source = Analytic(constant(0.0))
    assert isinstance(source, PhysicalSource)
    assert isinstance(source, AnalogSource)


@given(samples=st.integers(1, 10**6))
def test_internal_blocks_are_full_but_for_less_than_one_sample_each(samples: int) -> None:
    size = block_size(samples)
    blocks = -(-samples // size)
    assert size <= BLOCK
    assert blocks == -(-samples // BLOCK)
    assert 0 <= blocks * size - samples < blocks


def test_a_source_is_read_no_further_than_needed() -> None:
    source = Analytic(tone(1.0, 0.01))
    acquisition = Emulated(source, front_end(samples=25639))
    for size in (5159, 20480):
        acquisition.read(size)
    assert source.taken <= 8 * (25639 + 6)
    whole = Emulated(Analytic(tone(1.0, 0.01)), front_end()).read(25639)
    np.testing.assert_array_equal(
        Emulated(Analytic(tone(1.0, 0.01)), front_end(samples=25639)).read(25639).codes, whole.codes
    )


def pulses(volts: float, every: int) -> Callable[[np.ndarray], np.ndarray]:
    """One interval at a voltage in every `every`, zero in the others: an impact."""
    return lambda index: np.where(index % every == 3, volts, 0.0)


@settings(max_examples=10, deadline=None)
@given(size=st.integers(1, 3000))
def test_a_sensor_that_clips_is_flagged_though_no_code_shows_it(size: int) -> None:
    """20 V for an eighth of a sample, every 800th sample: the filter leaves less than an eighth of
    the sensor's 5 V.
    """
    spec = replace(ideal_transducer("force"), clips_at=5.0)
    channel = Channel("a", spec, 10.0, "", "+x", coupling="IEPE")
    states = [ChannelState(1.0, None, 1.0)]

    def blocks() -> list[Block]:
        source = conditioned(Analytic(pulses(20.0, 6400)), [channel], states)
        acquisition = Emulated(source, front_end())
        return [acquisition.read(size) for _ in range(6000 // size)]

    found = blocks()
    assert max(np.abs(block.codes).max() for block in found) * 10.0 / 2**23 < 1.2 * 5.0 / 8
    for block in (
        found
    ):  # the pulse of sample 800 k is in the middle of what the filter delays by 39 samples
        inside = sum(block.start <= 800 * k + 39 < block.start + size for k in range(9))
        assert block.clipped[0] == inside
        assert bool(block.flags[0] & Flag.SENSOR_CLIP) == (inside > 0)
        assert not block.flags[0] & (Flag.OVERLOAD_HI | Flag.OVERLOAD_LO)


def test_a_clipped_pulse_is_where_the_codes_have_it() -> None:
    source = conditioned(
        Analytic(pulses(20.0, 6400)),
        [
            Channel(
                "a",
                replace(ideal_transducer("force"), clips_at=5.0),
                10.0,
                "",
                "+x",
                coupling="IEPE",
            )
        ],
        [ChannelState(1.0, None, 1.0)],
    )
    acquisition = Emulated(source, front_end())
    acquisition.read(700)
    block = acquisition.read(200)
    assert abs(int(np.argmax(block.codes[0])) + block.start - 839) <= 1


def test_a_sensor_without_a_limit_costs_and_says_nothing() -> None:
    block = Emulated(Analytic(constant(9.0)), front_end()).read(200)
    assert block.clipped[0] == 0
    assert not block.flags[0] & Flag.SENSOR_CLIP
