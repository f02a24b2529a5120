"""The command to the amplifier: harmonics of a fundamental that change smoothly between
commands.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rig.kernels.waveform import sines

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Command:
    """A number of cycles of u = Re sum_h U_h e^(j h theta), in V or A (peak), theta' = 2 pi
    frequency.

    phasors : harmonics 1..H at the end of the command. They change linearly from the final values
        of the previous command (zero at the start of the run); theta is continuous as well
    sweep_to : frequency at the end of a linear sweep, Hz; None for a constant frequency
    """

    phasors: tuple[complex, ...]
    frequency: float
    cycles: int = 1
    sweep_to: float | None = None

    @property
    def last_frequency(self) -> float:
        """Frequency at the end, Hz."""
        return self.frequency if self.sweep_to is None else self.sweep_to

    @property
    def duration(self) -> float:
        """Duration of the command, s."""
        return self.time_of(float(self.cycles))

    def time_of(self, turns: float) -> float:
        """Return the time from the start at which the phase has advanced by `turns` turns, s."""
        # Root of f t + pace t^2/2 = turns in the form without cancellation, valid for pace = 0.
        return (
            2.0
            * turns
            / (self.frequency + float(np.sqrt(self.frequency**2 + 2.0 * self._pace * turns)))
        )

    def turns_at(self, time: Array) -> Array:
        """Return the turns of the phase since the start, at times from the start (s)."""
        return (self.frequency + 0.5 * self._pace * time) * time

    def values(self, before: tuple[complex, ...], time: Array) -> Array:
        """Return the command at times from its start (s), given the phasors `before` at
        the start.
        """
        turns = self.turns_at(time)
        share = time / self.duration
        theta = 2.0 * np.pi * (turns - np.floor(turns))
        total = np.zeros_like(time)
        for h in range(1, max(len(self.phasors), len(before)) + 1):
            first, last = _at(before, h), _at(self.phasors, h)
            if first == 0.0 and last == 0.0:
                continue
            phasor = first + (last - first) * share
            sine, cosine = sines(h * theta)
            total += phasor.real * cosine - phasor.imag * sine
        return total

    @property
    def _pace(self) -> float:
        """Sweep rate, Hz/s: the mean frequency over the whole command is that of its ends."""
        last = self.last_frequency
        return (last**2 - self.frequency**2) / (2.0 * self.cycles)


def _at(phasors: tuple[complex, ...], harmonic: int) -> complex:
    return phasors[harmonic - 1] if harmonic <= len(phasors) else 0.0j
