"""The loop-back null test: one voltage at both inputs, so that any difference is the analyzer's
own.

The certified couplings and skews are corrected as in every run. The remaining differences must lie
within their tolerances: an angle, which changes W by (pi/w^2) M_eff a^2 per radian, and a ratio of
gains. The sensors and their poles have no part in it.
"""

import cmath
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from analysis.comparison.family_of_tests import Zero
from analysis.comparison.null_tests import NullTest
from analysis.energy.per_cycle import harmonics
from analysis.session.record import AnalysisError, ChannelFacts, RecordedSession, RunFacts
from analysis.signals.cycles import Window, on_grid
from analysis.uncertainty.budget import (
    ANGLE_RESOLUTION,
    RESOLUTION,
    combine,
    inputs_angle,
    inputs_gain,
    scatter_line,
)
from analysis.uncertainty.estimate import Estimate
from daq.chain.block import Flag, flag_names

__all__ = ["LoopBack", "loop_back", "loop_back_nulls"]

UNUSABLE = int(
    Flag.OVERLOAD_HI
    | Flag.OVERLOAD_LO
    | Flag.INVALID
    | Flag.OVERRUN
    | Flag.GAP
    | Flag.IEPE_OPEN
    | Flag.IEPE_SHORT
)


@dataclass(frozen=True, slots=True)
class LoopBack:
    """The result of one loop-back run.

    angle : lead of the acceleration's input over the force's, rad
    gain : ratio of the force's gain to the acceleration's, less 1
    u : standard deviation of either (rad, relative) from the noise, the sensors' included
    """

    run: str
    frequency: float
    angle: float
    gain: float
    u: float


def loop_back(record: RecordedSession, run: RunFacts, window: Window, frequency: float) -> LoopBack:
    """Return the angle and the gain between the inputs in a loop-back run.

    AnalysisError for a run with missing or clipped samples, or without signal.
    """
    volts, noise = [], 0.0
    channels = [record.channels[name] for name in ("force", "acceleration")]
    for channel in channels:
        total = 0j
        for part in window.segments():
            first, last = part.sample_range()
            signal = record.signal(run.name, channel.name, first, last)
            if signal.flags & UNUSABLE:
                raise AnalysisError(
                    f"{run.name} has {', '.join(flag_names(signal.flags & UNUSABLE))}"
                )
            samples = on_grid(signal.samples, first, part)
            total += (
                complex(harmonics(samples, part.cycles, samples.size // part.cycles)[0])
                * part.cycles
            )
        total *= channel.sensitivity / window.cycles * _undone(channel, run.rate, frequency)
        if abs(total) <= channel.noise_rms * channel.sensitivity:
            raise AnalysisError(f"{run.name}: nothing arrives at the input {channel.name}")
        volts.append(total)
        noise += (channel.noise_rms * channel.sensitivity / abs(total)) ** 2
    ratio = volts[0] / volts[1]
    # Each quadrature of a phasor over N samples has the variance 2/N of white noise.
    u = math.sqrt(2 / round(window.cycles * window.grid.period) * noise)
    return LoopBack(run.name, frequency, -cmath.phase(ratio), abs(ratio) - 1, u)


def _undone(channel: ChannelFacts, rate: float, frequency: float) -> complex:
    """Return the factor that corrects a channel's certified delay and coupling at a frequency (Hz)."""
    turn = cmath.exp(2j * math.pi * frequency * (channel.filter_delay / rate - channel.skew))
    return turn * (1 - 1j * channel.corner / frequency)


def loop_back_nulls(
    found: Sequence[LoopBack], channels: Mapping[str, ChannelFacts]
) -> tuple[NullTest, ...]:
    """Return a null test for each frequency of the loop-back runs."""
    force, acceleration = channels["force"], channels["acceleration"]
    grouped: dict[float, list[LoopBack]] = defaultdict(list)
    for one in found:
        grouped[one.frequency].append(one)
    nulls = []
    for frequency, ones in grouped.items():
        angle = _mean([one.angle for one in ones], ones, ANGLE_RESOLUTION)
        gain = _mean([one.gain for one in ones], ones, RESOLUTION)
        dphi = combine(
            angle.value, [(angle.u, angle.nu), *inputs_angle(force, acceleration, frequency)]
        )
        ratio = combine(
            gain.value, [(gain.u, gain.nu), *inputs_gain(force, acceleration, frequency)]
        )
        holds = abs(dphi.value) <= dphi.U and abs(ratio.value) <= ratio.U
        why = (
            f"the inputs differ by {dphi.value:.2g} rad (measured to {angle.U:.1g} rad; the certificates allow "
            f"{dphi.U:.2g}) and by {100 * ratio.value:.2g} % of gain (to {100 * gain.U:.1g}; {100 * ratio.U:.2g})"
        )
        verdict = "holds" if holds else "undecided"
        tested = (Zero(dphi, {}), Zero(ratio, {}))
        nulls.append(
            NullTest("loop-back", 0.0, frequency, len(ones), dphi, verdict, why, ratio, tested)
        )
    return tuple(nulls)


def _mean(values: Sequence[float], ones: Sequence[LoopBack], resolution: float) -> Estimate:
    """Return the mean of the runs with the uncertainty of its measurement.

    That is their scatter, or for a single run its noise, and the resolution of the arithmetic.
    """
    parts = [(line.part, line.nu) for line in scatter_line(values)] or [(ones[0].u, math.inf)]
    return combine(math.fsum(values) / len(values), [*parts, (resolution, math.inf)])
