"""Input ranges chosen by a dry run: one per channel for all conditions, because a session has one
channel table.
"""

from collections.abc import Mapping, Sequence
from dataclasses import astuple

from daq.chain.auto_range import filtered_peaks
from daq.chain.fir import OVERSAMPLING
from rig.beds.janssen_stack import nominal
from rig.catalog.entries import Rig
from rig.drive.waveform import Waveform
from rig.protocol.spec import Condition
from rig.stand.channels import AUTO, Instruments, ranged
from rig.stand.prescribed import Stand

AHEAD = 16
"""Cycles of the dry run."""


def auto_ranged(
    tools: Instruments, conditions: Sequence[Condition], rig: Rig, rates: Mapping[str, float]
) -> Instruments:
    """Return the instruments with their automatic ranges (`acquire.ranges: auto`) chosen by a dry
    run.

    rates : output rate in Hz by condition

    Each condition is simulated for `AHEAD` cycles with its nominal bed, as set; the largest peak
    over all conditions counts.
    """
    asked = conditions[0].acquire.ranges
    if AUTO not in astuple(asked):
        return tools
    peaks: dict[str, float] = {}
    for condition in conditions:
        drive, rate = condition.drive, rates[condition.id]
        motion = Waveform(drive.frequency, drive.acceleration)
        stand = Stand(
            condition.scene, rig, motion, nominal(condition.scene, rig), OVERSAMPLING * rate
        )
        found = filtered_peaks(stand, round(AHEAD * rate / drive.frequency))
        for name, peak in zip(stand.names, found, strict=True):
            peaks[name] = max(peaks.get(name, 0.0), float(peak))
    return ranged(tools, asked, peaks)
