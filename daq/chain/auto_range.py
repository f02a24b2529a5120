"""Choose an input range: the smallest that holds a signal's peak after the anti-alias filter."""

from collections.abc import Sequence

import numpy as np

from daq.chain.fir import DELAY, OVERSAMPLING, Decimator
from daq.chain.source import FloatArray, PhysicalSource

__all__ = ["HEADROOM", "filtered_peaks", "smallest_range"]

HEADROOM = 2.0
"""Range over the peak of the dry run, because refills scatter and a dry run is short (assumed)."""


def filtered_peaks(source: PhysicalSource, samples: int) -> FloatArray:
    """Return each channel's largest magnitude, in its unit, over `samples` output samples after the
    filter has filled.
    """
    outputs, skip = samples + int(2 * DELAY), int(2 * DELAY)
    physical = source.read(OVERSAMPLING * outputs)
    rows = (Decimator(outputs).push(np.ascontiguousarray(row)) for row in physical)
    return np.array([float(np.abs(row[skip:]).max()) for row in rows])


def smallest_range(ranges: Sequence[float], peak_V: float) -> float:
    """Return the smallest range (V) of at least `HEADROOM` times the peak; the largest where none
    is.
    """
    enough = [value for value in ranges if value >= HEADROOM * peak_V]
    return min(enough) if enough else max(ranges)
