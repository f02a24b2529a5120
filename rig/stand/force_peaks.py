"""Force peaks of a bed with all its rows: few rows per layer hit together, which a box with more never feels."""

from dataclasses import replace

from daq.chain.fir import OVERSAMPLING
from rig.catalog.entries import Rig
from rig.drive.exciter_limits import Demand, demand
from rig.stand.prescribed import Stand

PASS_BAND = 0.45
"""Recorded band over the output rate: the anti-alias filter's pass band."""

AHEAD = 8
"""Chunks of cycles simulated: the last one stands for the steady state."""


def beyond(use: Demand) -> bool:
    """Whether a peak exceeds what exciter or stinger can bear."""
    return max(use.peak, use.buckling) > 1.0


def steady(stand: Stand) -> Stand:
    """A stand taken through some cycles more."""
    for _ in range(AHEAD):
        stand.advance()
    return stand


def use_of(rig: Rig, stand: Stand) -> Demand:
    """What the latest cycles of a stand, sampled at the oversampled rate, ask of the exciter in the recorded band."""
    return demand(rig.exciter, stand.latest_force, stand.rate, stand.motion, PASS_BAND * stand.rate / OVERSAMPLING)


def with_peaks_of(use: Demand, other: Demand) -> Demand:
    """A use of the exciter with the peaks of another one; what is rated on the fundamental stays."""
    return replace(use, peak=other.peak, buckling=other.buckling)
