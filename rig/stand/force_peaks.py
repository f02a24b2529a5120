"""Peak force with the full number of rows. A reduced model makes its few rows strike simultaneously
and so overestimates the peak.
"""

from dataclasses import replace

from daq.chain.fir import OVERSAMPLING
from rig.catalog.entries import Rig
from rig.drive.exciter_limits import Demand, demand
from rig.stand.prescribed import Stand

PASS_BAND = 0.45
"""Recorded band as a fraction of the output rate: the pass band of the anti-alias filter."""

AHEAD = 8
"""Number of chunks simulated; the last one represents the steady state."""


def beyond(use: Demand) -> bool:
    """Return whether a peak exceeds the limit of exciter or stinger."""
    return max(use.peak, use.buckling) > 1.0


def steady(stand: Stand) -> Stand:
    """Return a stand after `AHEAD` more chunks of cycles."""
    for _ in range(AHEAD):
        stand.advance()
    return stand


def use_of(rig: Rig, stand: Stand) -> Demand:
    """Return the utilisation of the exciter in the recorded band by the latest cycles of a stand at
    the oversampled rate.
    """
    return demand(
        rig.exciter,
        stand.latest_force,
        stand.rate,
        stand.motion,
        PASS_BAND * stand.rate / OVERSAMPLING,
    )


def with_peaks_of(use: Demand, other: Demand) -> Demand:
    """Return a utilisation with the peaks of another; the ratings on the fundamental stay."""
    return replace(use, peak=other.peak, buckling=other.buckling)
