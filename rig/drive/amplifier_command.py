"""What the amplifier is told: harmonics of a fundamental that move smoothly from one command to the next."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rig.kernels.waveform import sines

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Command:
    """Some cycles of u = Re sum_h U_h e^(j h theta), in V or A (peak), theta' = 2 pi frequency.

    `phasors` (harmonics 1..H) are reached at the end of the command: they move in a straight line from where the
    command before has left them, zero at the start. theta goes on from there as well. `sweep_to` : frequency in Hz at
    the end of a linear sweep; None holds it.
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
        """How long the command lasts, s."""
        return self.time_of(float(self.cycles))

    def time_of(self, turns: float) -> float:
        """Time from the start after which the phase has made so many turns, s."""
        return 2.0 * turns / (self.frequency + float(np.sqrt(self.frequency**2 + 2.0 * self._pace * turns)))

    def turns_at(self, time: Array) -> Array:
        """Turns of the phase since the start, at times from the start, s."""
        return (self.frequency + 0.5 * self._pace * time) * time

    def values(self, before: tuple[complex, ...], time: Array) -> Array:
        """The command at times from its start, s; `before` are the phasors that it starts from."""
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
        """Change of frequency per second, Hz/s: over the whole command the mean frequency is that of its ends."""
        last = self.last_frequency
        return (last**2 - self.frequency**2) / (2.0 * self.cycles)


def _at(phasors: tuple[complex, ...], harmonic: int) -> complex:
    return phasors[harmonic - 1] if harmonic <= len(phasors) else 0.0j
