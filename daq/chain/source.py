"""The two interfaces ahead of the acquisition: a physical quantity per channel, then a voltage per
channel.
"""

from typing import Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

__all__ = ["AnalogSource", "Clipping", "FloatArray", "PhysicalSource"]

FloatArray = npt.NDArray[np.float64]


@runtime_checkable
class PhysicalSource(Protocol):
    """A stream of physical quantities in SI units, each value the mean over one oversampled
    interval.

    Interval j covers [j, j + 1] / rate seconds of drive time, the same for every channel. The
    stream is stateful (each read continues where the last one ended), endless, and uses constant
    memory.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """Channel names in row order, e.g. ("force", "acceleration")."""

    @property
    def rate(self) -> float:
        """Oversampled rate in Hz: the analyzer's oversampling times its output rate."""

    def read(self, n: int) -> FloatArray:
        """Return the next n interval means, shape (channels, n), float64, SI units."""


@runtime_checkable
class AnalogSource(Protocol):
    """A stream of voltages at the analyzer's inputs, each value the mean over one oversampled
    interval.
    """

    @property
    def names(self) -> tuple[str, ...]:
        """Channel names in row order."""

    @property
    def rate(self) -> float:
        """Oversampled rate in Hz."""

    def volts(self, n: int) -> FloatArray:
        """Return the next n interval means in volts, shape (channels, n), float64, C-contiguous."""


@runtime_checkable
class Clipping(AnalogSource, Protocol):
    """An analog source that knows where a sensor's own amplifier clipped.

    No code can show that, because the filter that follows rounds the edge off.
    """

    def clipped(self) -> tuple[npt.NDArray[np.intp], ...]:
        """Return per channel the ascending indices in the last `volts` at which the sensor was at
        its limit.
        """
