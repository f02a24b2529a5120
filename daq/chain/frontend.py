"""The analyzer's front end: anti-alias filter, decimation, gain, noise and conversion to codes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from daq.chain.channel import AnalyzerSpec, Channel, ChannelState
from daq.chain.fir import DELAY, OVERSAMPLING, Decimator
from daq.chain.noise import Flicker
from daq.chain.source import FloatArray
from daq.compiled import njit

__all__ = ["BLOCK", "FILTER_DELAY", "FrontEnd", "NotFinite", "noise_volts"]

BLOCK = 5120  # most output samples per internal block
# samples; output n is centred at drive time (n - FILTER_DELAY) / rate
FILTER_DELAY = DELAY - 0.5 / OVERSAMPLING

Codes = npt.NDArray[np.int32]


class NotFinite(Exception):
    """A source delivered a value that is not a finite number, which no code can represent."""


@dataclass(frozen=True)
class Converter:
    """One channel's conversion: code = round(volts * codes_per_volt + gauss * noise), clipped to
    lowest..highest.
    """

    codes_per_volt: float
    noise: float
    lowest: int
    highest: int


def noise_volts(
    channel: Channel, analyzer: AnalyzerSpec, state: ChannelState, rate: float
) -> float:
    """Return the rms noise at the converter in V: transducer and analyzer in quadrature, each in
    the band 0..rate/2 (Hz).
    """
    sensor = channel.transducer.noise_in_band(rate) * state.sensitivity * state.gain
    return math.hypot(sensor, analyzer.noise_in_band(channel.range_V, rate))


def block_size(samples: int) -> int:
    """Return the smallest block size that covers `samples` in as few blocks of at most BLOCK as
    possible.
    """
    return math.ceil(samples / math.ceil(samples / BLOCK))


class FrontEnd:
    """Converts volts at the oversampled rate to codes at the output rate, block by block, for all
    channels.

    rate: output rate in Hz. noise: one generator per channel; a channel without noise draws nothing
    from it. samples: total number that will be read, where known: the block size is then chosen so
    that hardly any output is computed in vain. Blocks have one size from start to end, so that no
    result depends on how a record is read.
    """

    def __init__(
        self,
        analyzer: AnalyzerSpec,
        channels: Sequence[Channel],
        states: Sequence[ChannelState],
        rate: float,
        noise: Sequence[np.random.Generator],
        samples: int = BLOCK,
    ) -> None:
        if analyzer.oversampling != OVERSAMPLING:
            raise ValueError(
                f"the anti-alias filter oversamples {OVERSAMPLING} times, not {analyzer.oversampling}"
            )
        if not len(channels) == len(states) == len(noise) > 0:
            raise ValueError(
                f"{len(channels)} channels, {len(states)} states, {len(noise)} noise generators"
            )
        self.rate = rate
        self.names = tuple(channel.name for channel in channels)
        if len(channels) > analyzer.channels:
            raise ValueError(
                f"{len(channels)} channels on the {analyzer.channels} of {analyzer.model}"
            )
        top = 2 ** (analyzer.bits - 1)
        self.lowest, self.highest = -top, top - 1
        self._converters = []
        for channel, state in zip(channels, states, strict=True):
            code = analyzer.volts_per_code(channel.range_V)
            sigma = noise_volts(channel, analyzer, state, rate)
            self._converters.append(
                Converter(state.gain / code, sigma / code, self.lowest, self.highest)
            )
        self._noise = tuple(noise)
        self.block = block_size(samples)
        # A channel sampled late shows its signal early: hence the minus sign.
        self._decimators = [
            Decimator(self.block, -state.skew * OVERSAMPLING * rate) for state in states
        ]
        self._flicker: list[Flicker | None] = []
        for channel, state, rng in zip(channels, states, noise, strict=True):
            spots = channel.transducer.noise_spots
            self._flicker.append(Flicker(spots, state.sensitivity, rate, rng) if spots else None)
        self._gauss = np.zeros(self.block)

    def convert(self, volts: FloatArray) -> Codes:
        """Return the codes (channels, block) of the next volts (channels, 8 block).

        Raises NotFinite.

        The array belongs to the caller.
        """
        codes = np.empty((len(self._converters), self.block), dtype=np.int32)
        for row, converter in enumerate(self._converters):
            filtered = self._decimators[row].push(volts[row])
            # Checked after the filter, an eighth of the data: a non-finite input makes outputs
            # non-finite too.
            if not np.isfinite(filtered).all():
                raise NotFinite(
                    f"channel {self.names[row]}: the source delivered a value that is not finite"
                )
            flicker = self._flicker[row]
            if flicker is not None:
                flicker.add(filtered)
            if converter.noise:
                self._noise[row].standard_normal(out=self._gauss)
            _quantise(filtered, converter.codes_per_volt, self._gauss, converter.noise,
                      converter.lowest, converter.highest, codes[row])  # fmt: skip
        return codes


@njit(cache=True, nogil=True)
def _quantise(
    volts: FloatArray,
    per_volt: float,
    gauss: FloatArray,
    noise: float,
    lowest: int,
    highest: int,
    codes: Codes,
) -> None:
    """Clip to the rails, then round half to even."""
    for i in range(volts.size):
        value = per_volt * volts[i] + noise * gauss[i]
        codes[i] = np.int32(np.rint(min(max(value, lowest), highest)))
