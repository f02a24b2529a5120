"""What volts go through before the filter: each stage against its closed form, and nothing where it
is absent.
"""

import dataclasses
import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from daq_signals import OVERSAMPLED, RATE, Analytic, constant, tone
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from daq.chain.channel import (
    Channel,
    ChannelState,
    TransducerSpec,
    certified_state,
    draw_state,
    ideal_analyzer,
)
from daq.chain.conditioning import Bend, Clip, Conditioned, HighPass, Resonance, Stage, conditioned
from daq.chain.transducer import Transduced

SPEC = TransducerSpec(
    "352C33", "acceleration", "m/s^2", 0.0102, 490.0, 1.6, 0.1, 1.5e-3, 1e4, 0.01, clips_at=5.0
)
FULL = dataclasses.replace(SPEC, linearity=0.01, resonance=50e3, resonance_damping=0.02)

STAGES: dict[str, Callable[[], Stage]] = {
    "bend": lambda: Bend(1e-3, 2e-3, 5.0),
    "resonance": lambda: Resonance(9e3, 0.05, OVERSAMPLED),
    "clip": lambda: Clip(0.5),
    "coupling": lambda: HighPass(0.5, OVERSAMPLED),
}


@pytest.mark.parametrize("stage", STAGES)
@given(cuts=st.lists(st.integers(1, 700), min_size=1, max_size=6))
def test_reads_of_any_size_give_the_same(stage: str, cuts: Sequence[int]) -> None:
    cut, whole = (Conditioned(Analytic(tone(1.0, 0.01)), [[STAGES[stage]()]]) for _ in range(2))
    parts = [cut.volts(n).copy() for n in cuts]
    assert np.array_equal(np.concatenate(parts, axis=1), whole.volts(sum(cuts)))


@pytest.mark.parametrize("f0", [2e3, 20e3, 36e3, 50e3, 300e3])
@pytest.mark.parametrize("frequency", [0.002, 0.05, 0.2, 0.45])
def test_a_resonance_lifts_the_pass_band_as_it_should(f0: float, frequency: float) -> None:
    """Gain 1/(1 - r^2 + 2j d r), r = f/f0: exactly that at the warped frequency, against
    scipy.signal; and within (w h)^2/6 of r (to next order, and near resonance divided by the
    distance to it) at the true one."""
    damping = 0.05
    w0 = 2 * np.pi * f0
    b, a = signal.bilinear([w0**2], [1, 2 * damping * w0, w0**2], OVERSAMPLED)
    volts = Analytic(tone(1.0, frequency)).volts(4000)[0]
    expected = signal.lfilter(b, a, volts)
    Resonance(f0, damping, OVERSAMPLED).apply(volts)
    np.testing.assert_allclose(volts, expected, rtol=0, atol=1e-11)
    turn = 2 * np.pi * frequency / 8
    r = frequency * RATE / f0
    found = signal.freqz(b, a, worN=[turn])[1][0]
    exact = 1 / (1 - r**2 + 2j * damping * r)
    if r < 0.7:
        assert (
            abs(found - exact)
            <= 1.1 * turn**2 / 6 * abs(r**2 * exact) / (1 - r**2) + 1.1 * turn**2 / 12 * 0.1 * r
        )


def test_a_bend_makes_the_harmonics_of_its_polynomial() -> None:
    """x (1 + e x + o x^2) of a sine A: second harmonic e A^2/2, third o A^3/4, first A (1 + 3/4 o
    A^2).
    """
    n, amplitude, even, odd, full = 1000, 3.0, 2e-3, 5e-3, 5.0
    volts = amplitude * np.sin(2 * np.pi * np.arange(n) / n)
    Bend(even, odd, full).apply(volts)
    lines = np.abs(np.fft.rfft(volts)) * 2 / n
    relative = amplitude / full
    assert lines[1] == pytest.approx(amplitude * (1 + 0.75 * odd * relative**2), rel=1e-12)
    assert lines[2] == pytest.approx(amplitude * even * relative / 2, rel=1e-9)
    assert lines[3] == pytest.approx(amplitude * odd * relative**2 / 4, rel=1e-9)


def test_an_iepe_sensor_clips_before_the_range_ends() -> None:
    channel = Channel("a", SPEC, 10.0, "", "+x", coupling="IEPE", corner=0.5)
    source = conditioned(Analytic(tone(8.0, 0.002)), [channel], [certified_state(channel)])
    volts = source.volts(8 * 500)
    # the coupling, 0.5 Hz, takes 1 - e^(-2 pi 0.5 t) of the mean of a half wave at most
    assert np.abs(volts).max() < 5.0 * (1 + 2 * math.pi * 0.5 * 500 / RATE)
    assert (
        np.mean(np.abs(np.diff(volts[0])) < 1e-3) > 0.4
    )  # flat tops: |sin| > 5/8 for 57 % of the time


def test_the_coupling_is_one_more_pole() -> None:
    """The same arithmetic as a transducer's discharge of 1/(2 pi f_c)."""
    source, other = Analytic(tone(1.0, 0.002)), Analytic(tone(1.0, 0.002))
    volts = Conditioned(source, [[HighPass(0.5, OVERSAMPLED)]]).volts(4000)
    expected = Transduced(other, [ChannelState(1.0, 1 / (2 * math.pi * 0.5), 1.0)]).volts(4000)
    np.testing.assert_allclose(volts, expected, rtol=1e-12, atol=1e-15)


def test_an_absent_stage_is_not_there() -> None:
    source = Analytic(constant(1.0))
    dc = Channel("a", SPEC, 10.0, "", "+x")
    assert conditioned(source, [dc], [certified_state(dc)]) is source


def test_what_is_drawn_is_what_is_built() -> None:
    """A bend within half the linearity each, a corner within its tolerance; the first three draws
    are as ever.
    """
    channel = Channel("a", FULL, 10.0, "", "+x", coupling="AC", corner=0.5)
    analyzer = dataclasses.replace(ideal_analyzer(), ac_tolerance=0.1, skew=1e-7)
    states = [draw_state(channel, analyzer, np.random.default_rng(i)) for i in range(300)]
    for values, half in (
        (np.array([s.bend for s in states]).ravel(), 0.005),
        (np.array([s.corner for s in states]) / 0.5 - 1, 0.1),
        (np.array([s.skew for s in states]), 1e-7),
    ):
        assert np.abs(values).max() <= half
        assert values.std() == pytest.approx(
            half / math.sqrt(3), rel=5 / math.sqrt(2 * len(values))
        )
    plain = draw_state(
        Channel("a", SPEC, 10.0, "", "+x"), ideal_analyzer(), np.random.default_rng(3)
    )
    assert (plain.corner, plain.skew, plain.bend) == (None, 0.0, (0.0, 0.0))
    assert (plain.sensitivity, plain.time_constant) == (
        states[3].sensitivity,
        states[3].time_constant,
    )


def test_a_row_of_stages_for_every_channel() -> None:
    with pytest.raises(ValueError, match="stages of 2 channels"):
        Conditioned(Analytic(constant(1.0)), [[], []])


@pytest.mark.parametrize("damping", [0.0, 1.0])
def test_a_resonance_has_to_swing(damping: float) -> None:
    with pytest.raises(ValueError, match="damping"):
        Resonance(1e3, damping, OVERSAMPLED)
