"""Transducers: a physical quantity becomes a voltage, through the actual sensitivity and the
high-pass pole.
"""

import math
from collections.abc import Sequence

import numpy as np

from daq.chain.channel import ChannelState
from daq.chain.source import FloatArray, PhysicalSource
from daq.compiled import njit

__all__ = ["Transduced", "high_pass"]


class Transduced:
    """An AnalogSource: a physical source measured by one transducer per channel, in the given
    actual states.

    The pole of a discharge time constant tau (y = x - z, z' = (x - z) / tau) is solved exactly for
    inputs that are constant over each interval, with z = 0 at drive time 0. A transducer without a
    pole is a multiplication. Each call of `volts` refills and returns the same array.
    """

    def __init__(self, source: PhysicalSource, states: Sequence[ChannelState]) -> None:
        if len(states) != len(source.names):
            raise ValueError(
                f"{len(states)} transducer states for the channels {', '.join(source.names)}"
            )
        self._source = source
        self._sensitivities = [state.sensitivity for state in states]
        self._steps = [
            0.0 if s.time_constant is None else 1 / (source.rate * s.time_constant) for s in states
        ]
        self._slow = [0.0 for _ in states]
        self._volts = np.empty((len(states), 0))

    @property
    def names(self) -> tuple[str, ...]:
        """Channel names in row order."""
        return self._source.names

    @property
    def rate(self) -> float:
        """Oversampled rate in Hz."""
        return self._source.rate

    def volts(self, n: int) -> FloatArray:
        """Return the next n interval means in volts, shape (channels, n)."""
        physical = self._source.read(n)
        if self._volts.shape[1] != n:
            self._volts = np.empty((len(self._steps), n))
        for row, (sensitivity, step) in enumerate(
            zip(self._sensitivities, self._steps, strict=True)
        ):
            if step:
                self._slow[row] = high_pass(
                    physical[row], self._slow[row], step, sensitivity, self._volts[row]
                )
            else:
                np.multiply(physical[row], sensitivity, out=self._volts[row])
        return self._volts


@njit(cache=True, nogil=True)
def high_pass(
    x: FloatArray, slow: float, step: float, sensitivity: float, volts: FloatArray
) -> float:
    """Apply one pole over consecutive intervals of length step = dt / tau; return z at the end.

    `volts` may be `x` itself.

    Over one interval z runs from z0 to x + (z0 - x) e^-step, so that the mean of y is (x - z0) (1 -
    e^-step) / step.
    """
    # expm1 keeps its digits for the short steps of a slow pole.
    keep, add = math.exp(-step), -math.expm1(-step)
    scale = sensitivity * add / step
    for i in range(x.size):
        value = x[i]
        volts[i] = scale * (value - slow)
        slow = keep * slow + add * value
    return slow
