"""A dwell in shaker-coupled drive: start-up, level control, settling and recording under a
constant command, ramp-down.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rig.drive.amplifier_command import Command
from rig.drive.level_control import Loop, Target, started, stepped

Array = NDArray[np.float64]

START_UP = 4
"""Cycles of the ramp from rest to the first command."""

RAMP_DOWN = 4
"""Cycles of the ramp from the last command to zero."""

HELD = 2
"""Cycles per command while the level is held."""


@dataclass(frozen=True)
class Plan:
    """Settings of a dwell at `frequency` (Hz).

    guess : fundamental of the first command, V or A
    targets : levels to be reached in turn, the last one recorded; without any, the guess is held
        (open loop)
    steady : cycles held under the last command
    response : acceleration of the box alone per unit command, harmonics 1, 2, ...; its length is
        the number of harmonics that are controlled
    reading : output of the controller's accelerometer per unit of true acceleration
    sweep : (first cycle of the sweep within the steady part, number of its cycles, final frequency
        in Hz, which the remaining cycles keep); None for no sweep
    """

    frequency: float
    guess: complex
    targets: tuple[Target, ...]
    steady: int
    response: tuple[complex, ...]
    reading: float = 1.0
    sweep: tuple[int, int, float] | None = None

    def at(self, cycle: int) -> float:
        """Return the frequency, Hz, after `cycle` steady cycles.

        A sweep is linear in time, so the square of the frequency is linear in the number of cycles:
        d(f^2)/dn = 2 f df/dn = 2 df/dt.
        """
        if self.sweep is None:
            return self.frequency
        first, count, last = self.sweep
        share = min(max(cycle - first, 0), count) / count
        return float(np.sqrt(self.frequency**2 + (last**2 - self.frequency**2) * share))


def phasors(
    signal: Array, first: int, per_second: float, frequency: float, count: int
) -> tuple[complex, ...]:
    """Return the phasors (peak) of harmonics 1 to `count` of a signal of interval means.

    first : number of intervals between time 0 and the start of the signal
    per_second : intervals per second
    frequency : of the fundamental, Hz
    """
    turns = (first + np.arange(signal.size) + 0.5) * (frequency / per_second)
    unit = np.exp(-2j * np.pi * (turns - np.floor(turns)))
    found, power = [], np.ones_like(unit)
    for _ in range(count):
        power = power * unit
        found.append(complex(2.0 * np.mean(signal * power)))
    return tuple(found)


class Dwell:
    """State machine of one dwell: each call takes the signals of the latest command and returns the
    next.

    acceleration, current : row numbers of these two signals
    rate : intervals per second
    shares : function from the fundamental of the current, A, to the used fraction of each exciter
        limit in the latest cycle, by name

    `loop` is the state of the level control; `steady_from` is the first cycle of the held command
    (None until then).
    """

    def __init__(
        self, plan: Plan, rate: float, acceleration: int, current: int,
        shares: Callable[[float], Mapping[str, float]],
    ) -> None:  # fmt: skip
        self.loop: Loop = started(plan.guess, len(plan.response))
        self.steady_from: int | None = None
        self._plan, self._rate = plan, rate
        self._rows = acceleration, current
        self._shares = shares
        self._left = list(plan.targets)
        self._cycles = 0
        self._intervals = 0

    def __call__(self, signals: Array | None) -> Command:
        """Return the next command; `signals` is None at the first call."""
        if signals is None:
            return self._next(self.loop.command, START_UP)
        first = self._intervals
        self._intervals += signals.shape[1]
        if self.steady_from is None:
            self._control(signals, first)
        if self.steady_from is None:
            return self._next(self.loop.command, 1)
        done = self._cycles - self.steady_from
        if done < self._plan.steady and self._plan.sweep is not None:
            self._cycles += 1
            return Command(self.loop.command, self._plan.at(done), 1, self._plan.at(done + 1))
        if done < self._plan.steady:
            return self._next(self.loop.command, min(HELD, self._plan.steady - done))
        return self._next((), RAMP_DOWN)

    def _next(self, phasor: tuple[complex, ...], cycles: int) -> Command:
        end = (
            self._plan.frequency
            if self.steady_from is None
            else self._plan.at(self._cycles - self.steady_from)
        )
        self._cycles += cycles
        return Command(phasor, end, cycles)

    def _control(self, signals: Array, first: int) -> None:
        """Advance the control loop with the last cycle of the signals."""
        if not self._left:
            self.steady_from = self._cycles
            return
        size = min(round(self._rate / self._plan.frequency), signals.shape[1])
        start = first + signals.shape[1] - size
        acceleration, current = (signals[row, -size:] for row in self._rows)

        def read(signal: Array, count: int) -> Sequence[complex]:
            return phasors(signal, start, self._rate, self._plan.frequency, count)

        measured = read(self._plan.reading * acceleration, len(self._plan.response))
        shares = self._shares(abs(read(current, 1)[0]))
        self.loop = stepped(self.loop, self._left[0], measured, shares, self._plan.response)
        if self.loop.status == "seeking":
            return
        # The last target, reached or not, is what is recorded; earlier ones are stations on the
        # way.
        if len(self._left) == 1:
            self.steady_from = self._cycles
        else:
            self.loop = replace(self.loop, status="seeking", window=(), fresh=0, cycles=0, limit="")
        self._left = self._left[1:]
