"""Signal conditioning between a transducer's element and the anti-alias filter, stage by stage.

Every stage works in place on one channel's oversampled volts. A channel has only the stages that it
needs; where no channel needs any, the source is returned unchanged.
"""

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from daq.chain.channel import Channel, ChannelState
from daq.chain.source import AnalogSource, FloatArray
from daq.chain.transducer import high_pass
from daq.compiled import njit

__all__ = ["Bend", "Clip", "Conditioned", "HighPass", "Resonance", "Stage", "conditioned"]


class Stage(Protocol):
    """One step of a channel's conditioning, with its own state."""

    def apply(self, volts: FloatArray) -> None:
        """Replace the next interval means (V) by the stage's output."""


class Bend:
    """Nonlinearity: v (1 + even (v/full) + odd (v/full)^2); full: V at full scale."""

    def __init__(self, even: float, odd: float, full: float) -> None:
        self._even, self._odd = even / full, odd / full**2

    def apply(self, volts: FloatArray) -> None:
        """See Stage.

        Applied to interval means: the error is of the order of the variance within an interval.
        """
        volts *= 1 + volts * (self._even + self._odd * volts)


class Resonance:
    """The transducer on its mounting: y'' + 2 d w0 y' + w0^2 y = w0^2 x, at rest at the start.

    Bilinear transform without prewarping: stable for any w0 h (h: interval), gain exactly 1 at
    frequency 0. It maps a frequency w to (2/h) tan(w h/2), so the response's deviation from 1 has
    the relative error (w h)^2/6: 2 % at the edge of the recorded band. A resonance above that band
    rings at a shifted frequency, which the anti-alias filter removes.
    """

    def __init__(self, frequency: float, damping: float, rate: float) -> None:
        if not 0 < damping < 1:
            raise ValueError(f"a resonance has a damping ratio between 0 and 1, not {damping}")
        # c is the bilinear transform's 2/h over w0; the weights are b, p, q of `_resonate`.
        c = rate / (math.pi * frequency)
        whole = 1 + 2 * damping * c + c * c
        # Normalised by the coefficient of the newest output.
        self._weights = (1 / whole, (2 - 2 * c * c) / whole, (1 - 2 * damping * c + c * c) / whole)
        self._memory = (0.0, 0.0)

    def apply(self, volts: FloatArray) -> None:
        """See Stage."""
        self._memory = _resonate(volts, self._memory, self._weights)


NOWHERE = np.empty(0, dtype=np.intp)


class Clip:
    """The limit of the sensor's own amplifier, +- limit (V)."""

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self.places = NOWHERE

    def apply(self, volts: FloatArray) -> None:
        """See Stage. Leaves in `places` the indices at which it clipped in this call."""
        self.places = np.flatnonzero(np.abs(volts) > self._limit)
        if self.places.size:
            np.clip(volts, -self._limit, self._limit, out=volts)


class HighPass:
    """The AC coupling: one pole at `corner` (Hz), solved exactly like a transducer's discharge."""

    def __init__(self, corner: float, rate: float) -> None:
        self._step, self._slow = 2 * math.pi * corner / rate, 0.0

    def apply(self, volts: FloatArray) -> None:
        """See Stage."""
        self._slow = high_pass(volts, self._slow, self._step, 1.0, volts)


class Conditioned:
    """An analog source with a sequence of stages on each channel."""

    def __init__(self, source: AnalogSource, stages: Sequence[Sequence[Stage]]) -> None:
        if len(stages) != len(source.names):
            raise ValueError(f"stages of {len(stages)} channels for {', '.join(source.names)}")
        self._source = source
        self._stages = tuple(tuple(row) for row in stages)

    @property
    def names(self) -> tuple[str, ...]:
        """Channel names in row order."""
        return self._source.names

    @property
    def rate(self) -> float:
        """Oversampled rate in Hz."""
        return self._source.rate

    def volts(self, n: int) -> FloatArray:
        """Return the next n interval means in volts, shape (channels, n): the source's own array,
        modified in place.
        """
        volts = self._source.volts(n)
        for row, stages in zip(volts, self._stages, strict=True):
            for stage in stages:
                stage.apply(row)
        return volts

    def clipped(self) -> tuple[NDArray[np.intp], ...]:
        """See Clipping."""
        return tuple(_clip_places(stages) for stages in self._stages)


def _clip_places(stages: Sequence[Stage]) -> NDArray[np.intp]:
    """Return the indices at which a channel's sensor clipped in the last call, empty without a
    clipping stage.
    """
    for stage in stages:
        if isinstance(stage, Clip):
            return stage.places
    return NOWHERE


def conditioned(
    source: AnalogSource, channels: Sequence[Channel], states: Sequence[ChannelState]
) -> AnalogSource:
    """Return the source with the stages its channels need: bend, resonance, sensor clipping,
    coupling.

    Returns `source` itself where no channel needs any.
    """
    stages = [
        _stages(channel, state, source.rate)
        for channel, state in zip(channels, states, strict=True)
    ]
    return Conditioned(source, stages) if any(stages) else source


def _stages(channel: Channel, state: ChannelState, rate: float) -> list[Stage]:
    """Return a channel's stages in the order of the signal path."""
    spec, found = channel.transducer, list[Stage]()
    # The order of the signal path: the element, its mounting, its amplifier, the analyzer's
    # coupling.
    if any(state.bend):
        found.append(Bend(*state.bend, full=spec.full_scale * state.sensitivity))
    if spec.resonance is not None:
        found.append(Resonance(spec.resonance, spec.resonance_damping, rate))
    if channel.coupling == "IEPE" and spec.clips_at is not None:
        found.append(Clip(spec.clips_at))
    if state.corner is not None:
        found.append(HighPass(state.corner, rate))
    return found


@njit(cache=True, nogil=True)
def _resonate(
    x: FloatArray, memory: tuple[float, float], weights: tuple[float, float, float]
) -> tuple[float, float]:
    """Apply b (1 + 1/z)^2 / (1 + p/z + q/z^2) in place, transposed direct form; return its memory
    at the end.
    """
    b, p, q = weights
    m1, m2 = memory
    for i in range(x.size):
        gained = b * x[i]
        y = gained + m1
        m1, m2 = 2 * gained - p * y + m2, gained - q * y
        x[i] = y
    return m1, m2
