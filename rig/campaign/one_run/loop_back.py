"""The loop-back: one voltage at all inputs, so that differences between them are the analyzer's."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from daq.chain.channel import ideal_transducer
from daq.chain.fir import OVERSAMPLING
from daq.chain.source import PhysicalSource
from rig.kernels.waveform import sines
from rig.stand.channels import Instruments

SHARE = 0.5
"""Amplitude of the voltage, as a fraction of the smallest range in use."""


def inputs_alone(tools: Instruments) -> Instruments:
    """Return the instruments without their sensors, 1 V per unit; coupling, skew, gain and noise of
    the inputs remain.
    """
    return replace(
        tools,
        channels=tuple(
            replace(c, transducer=ideal_transducer(c.transducer.quantity)) for c in tools.channels
        ),
        states=tuple(
            replace(state, sensitivity=1.0, time_constant=None, bend=(0.0, 0.0))
            for state in tools.states
        ),
    )


class LoopBackSource:
    """A physical source in V: a sine of the drive's frequency from the analyzer's own generator at
    every input.

    The rig continues in the background: its account is kept, its signals are dropped.
    """

    def __init__(
        self, source: PhysicalSource, tools: Instruments, frequency: float, rate: float
    ) -> None:
        self._source, self._next = source, 0
        self._amplitude = SHARE * min(channel.range_V for channel in tools.channels)
        self._turn = (
            2 * math.pi * frequency / (OVERSAMPLING * rate)
        )  # generator and converter share their clock

    @property
    def names(self) -> tuple[str, ...]:
        """Channel names in row order."""
        return self._source.names

    @property
    def rate(self) -> float:
        """Oversampled rate in Hz."""
        return self._source.rate

    def read(self, n: int) -> NDArray[np.float64]:
        """Return the next n interval means in V, shape (channels, n)."""
        self._source.read(n)
        angle = np.asarray(self._turn * (self._next + 0.5 + np.arange(n)), dtype=np.float64)
        self._next += n
        # Mean of a sine over an interval: the value at its middle times sinc(half the phase step).
        sine = self._amplitude * math.sin(self._turn / 2) / (self._turn / 2) * sines(angle)[0]
        return np.tile(sine, (len(self.names), 1))
