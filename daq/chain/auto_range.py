"""Choosing an input range: what the anti-alias filter hands on of a signal, and the smallest range that holds it."""

from collections.abc import Sequence

import numpy as np

from daq.chain.fir import DELAY, OVERSAMPLING, Decimator
from daq.chain.source import FloatArray, PhysicalSource

__all__ = ["HEADROOM", "filtered_peaks", "smallest_range"]

HEADROOM = 2.0  # range over the peak that was looked at: refills scatter, and a look ahead is short (assumed)


def filtered_peaks(source: PhysicalSource, samples: int) -> FloatArray:
    """Largest magnitude of every channel, in its unit, over `samples` output samples after the filter has filled."""
    outputs, skip = samples + int(2 * DELAY), int(2 * DELAY)
    physical = source.read(OVERSAMPLING * outputs)
    rows = (Decimator(outputs).push(np.ascontiguousarray(row)) for row in physical)
    return np.array([float(np.abs(row[skip:]).max()) for row in rows])


def smallest_range(ranges: Sequence[float], peak_V: float) -> float:
    """Smallest range (V) that is `HEADROOM` times a peak; the largest where none is."""
    enough = [value for value in ranges if value >= HEADROOM * peak_V]
    return min(enough) if enough else max(ranges)
