"""What a voltage goes through between a transducer's element and the anti-alias filter, stage by stage.

Every stage works in place on one channel's oversampled volts. A channel holds the stages that it needs and no others;
where no channel needs any, the source is handed on as it is.
"""

import math
from collections.abc import Sequence
from typing import Protocol

import numba
import numpy as np
from numpy.typing import NDArray

from daq.chain.channel import Channel, ChannelState
from daq.chain.source import AnalogSource, FloatArray
from daq.chain.transducer import high_pass

__all__ = ["Bend", "Clip", "Conditioned", "HighPass", "Resonance", "Stage", "conditioned"]


class Stage(Protocol):
    """One step of a channel's way, with its own memory of what went before."""

    def apply(self, volts: FloatArray) -> None:
        """Replace the next interval means, V, by what comes out."""


class Bend:
    """Deviation from the straight line: v (1 + even (v/full) + odd (v/full)^2); full: V at full scale."""

    def __init__(self, even: float, odd: float, full: float) -> None:
        self._even, self._odd = even / full, odd / full**2

    def apply(self, volts: FloatArray) -> None:
        """See Stage. A mean over an interval stands for the values in it: the error is that of their variance."""
        volts *= 1 + volts * (self._even + self._odd * volts)


class Resonance:
    """The transducer on its mounting: y'' + 2 d w0 y' + w0^2 y = w0^2 x, at rest at the start.

    Bilinear transform without prewarping: stable for any w0 against the rate, gain exactly 1 at frequency 0. Its
    frequency is read as (2/h) tan(w h/2), so that the deviation from 1 is right to (w h)^2/6 of itself: 2 % at the edge
    of the recorded band. A resonance above that band rings at another frequency, which the filter takes away.
    """

    def __init__(self, frequency: float, damping: float, rate: float) -> None:
        if not 0 < damping < 1:
            raise ValueError(f"a resonance has a damping ratio between 0 and 1, not {damping}")
        c = rate / (math.pi * frequency)  # 2 / (w0 h)
        whole = 1 + 2 * damping * c + c * c
        self._weights = (1 / whole, (2 - 2 * c * c) / whole, (1 - 2 * damping * c + c * c) / whole)
        self._memory = (0.0, 0.0)

    def apply(self, volts: FloatArray) -> None:
        """See Stage."""
        self._memory = _resonate(volts, self._memory, self._weights)


NOWHERE = np.empty(0, dtype=np.intp)


class Clip:
    """The sensor's own amplifier: nothing beyond +- limit (V)."""

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self.places = NOWHERE

    def apply(self, volts: FloatArray) -> None:
        """See Stage. `places`: where it clipped, this time."""
        self.places = np.flatnonzero(np.abs(volts) > self._limit)
        if self.places.size:
            np.clip(volts, -self._limit, self._limit, out=volts)


class HighPass:
    """The coupling: one pole at `corner` (Hz), as a transducer's discharge is solved."""

    def __init__(self, corner: float, rate: float) -> None:
        self._step, self._slow = 2 * math.pi * corner / rate, 0.0

    def apply(self, volts: FloatArray) -> None:
        """See Stage."""
        self._slow = high_pass(volts, self._slow, self._step, 1.0, volts)


class Conditioned:
    """An analog source whose channels go through stages, row by row."""

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
        """Next n interval means in volts, shape (channels, n): the source's own array, worked over."""
        volts = self._source.volts(n)
        for row, stages in zip(volts, self._stages, strict=True):
            for stage in stages:
                stage.apply(row)
        return volts

    def clipped(self) -> tuple[NDArray[np.intp], ...]:
        """See Clipping."""
        clips = ([stage.places for stage in stages if isinstance(stage, Clip)] for stages in self._stages)
        return tuple(places[0] if places else NOWHERE for places in clips)


def conditioned(source: AnalogSource, channels: Sequence[Channel], states: Sequence[ChannelState]) -> AnalogSource:
    """The source with what its channels need: bend, resonance, clipping sensor, coupling. Itself where none does."""
    stages = [_stages(channel, state, source.rate) for channel, state in zip(channels, states, strict=True)]
    return Conditioned(source, stages) if any(stages) else source


def _stages(channel: Channel, state: ChannelState, rate: float) -> list[Stage]:
    spec, found = channel.transducer, list[Stage]()
    if any(state.bend):
        found.append(Bend(*state.bend, full=spec.full_scale * state.sensitivity))
    if spec.resonance is not None:
        found.append(Resonance(spec.resonance, spec.resonance_damping, rate))
    if channel.coupling == "IEPE" and spec.clips_at is not None:
        found.append(Clip(spec.clips_at))
    if state.corner is not None:
        found.append(HighPass(state.corner, rate))
    return found


@numba.njit(cache=True, nogil=True)
def _resonate(x: FloatArray, memory: tuple[float, float], weights: tuple[float, float, float]) -> tuple[float, float]:
    """b (1 + 1/z)^2 / (1 + p/z + q/z^2) in place, transposed direct form; returns its memory at the end."""
    b, p, q = weights
    m1, m2 = memory
    for i in range(x.size):
        gained = b * x[i]
        y = gained + m1
        m1, m2 = 2 * gained - p * y + m2, gained - q * y
        x[i] = y
    return m1, m2
