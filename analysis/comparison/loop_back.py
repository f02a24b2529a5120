"""The loop-back null: both inputs have seen one voltage, so that what differs between them is the
analyzer's own.

The certified couplings and skews are undone as everywhere. What is left must lie within their
tolerances: an angle, of which W takes (pi/w^2) M_eff a^2 per radian, and a ratio of gains. Sensors
and their poles are not in it.
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
    """One run: lead of the acceleration's input over the force's, rad; force's gain over the
    acceleration's less 1; u: standard deviation of either (rad, relative) from the noise, the
    sensors' counted in."""

    run: str
    frequency: float
    angle: float
    gain: float
    u: float


def loop_back(record: RecordedSession, run: RunFacts, window: Window, frequency: float) -> LoopBack:
    """What a run of the loop-back tells. AnalysisError for one with missing or clipped samples, or
    without signal.
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
    u = math.sqrt(2 / round(window.cycles * window.grid.period) * noise)
    return LoopBack(run.name, frequency, -cmath.phase(ratio), abs(ratio) - 1, u)


def _undone(channel: ChannelFacts, rate: float, frequency: float) -> complex:
    """What undoes a channel's certified delay and coupling at a frequency (Hz)."""
    turn = cmath.exp(2j * math.pi * frequency * (channel.filter_delay / rate - channel.skew))
    return turn * (1 - 1j * channel.corner / frequency)


def loop_back_nulls(
    found: Sequence[LoopBack], channels: Mapping[str, ChannelFacts]
) -> tuple[NullTest, ...]:
    """A null test for each frequency of the loop-backs."""
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
    """Mean of the runs, with what it was measured to: their scatter, or the noise of a single one;
    the arithmetic.
    """
    parts = [(line.part, line.nu) for line in scatter_line(values)] or [(ones[0].u, math.inf)]
    return combine(math.fsum(values) / len(values), [*parts, (resolution, math.inf)])
