"""How long to settle and to record: no window of so many cycles behind the settling may be off by more than allowed."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rig.fidelity.pilot import Pilot

Array = NDArray[np.float64]

LEAST_RECORD = 4
"""Fewest cycles that are recorded."""

RECORDS = (4, 5, 6, 7, 8, 9, 10, 12, 15, 16, 18, 20, 24, 30, 36, 40, 48, 60, 72, 96, 120, 144, 192, 240, 288, 384, 480)
"""Records that are tried; many are multiples of 2, 3, 4 and 6, the common periods of rows."""

WINDOWS = 3
"""A pilot holds at least so many windows behind the settling."""

MULTIPLES = 8
"""Longer records tried of each length, against the instruments' noise."""

LONGEST_RECORD = 1024
"""Most cycles that are recorded to average the instruments' noise."""


@dataclass(frozen=True)
class LengthChoice:
    """Cycles to settle and to record, and what they cost in accuracy, relative to W.

    window : largest error of any stretch of `record` cycles that begins behind `settle` cycles
    noise : expanded, of the instruments
    """

    settle: int
    record: int
    window: float
    noise: float

    @property
    def error(self) -> float:
        """What is counted against the tolerance."""
        return self.window + self.noise


def choose_lengths(pilots: Sequence[Pilot], allowed: float, noise: float, least_settle: int = 1) -> LengthChoice:
    """The shortest run whose error is at most `allowed`; where there is none, the one with the smallest error.

    noise : expanded error of a record of one cycle, relative; it falls with the root of the cycles
    """
    series = [pilot.work / pilot.W - 1.0 for pilot in pilots if pilot.W > 0.0]
    cycles = min((one.size for one in series), default=0)
    tried = [
        choice
        for record in RECORDS
        if not series or record <= cycles // WINDOWS
        for choice in _of_record(record, [one[:cycles] for one in series], allowed, noise, least_settle)
    ]
    good = [choice for choice in tried if choice.error <= allowed]
    if good:
        return min(good, key=lambda choice: (choice.settle + choice.record, choice.error))
    return min(tried, key=lambda choice: choice.error)


def _of_record(
    record: int, series: Sequence[Array], allowed: float, noise: float, least_settle: int
) -> Iterator[LengthChoice]:
    """The shortest settling for a record, and for longer ones that are multiples of it: a mean of windows is off by no
    more than the worst of them. The last one given is the most accurate."""
    worst = _worst(series, record)[least_settle:] if series else np.zeros(1)
    needed = math.inf if noise >= allowed * math.sqrt(LONGEST_RECORD) else (noise / allowed) ** 2
    longest = LONGEST_RECORD // record
    first = min(max(math.ceil(needed / record), 1), longest) if needed < math.inf else longest
    for times in sorted({*range(first, min(first + MULTIPLES, longest) + 1), longest if noise else 1}):
        left = noise / math.sqrt(times * record)
        within = np.flatnonzero(worst <= allowed - left)
        settle = int(within[0]) if within.size else worst.size - 1
        yield LengthChoice(least_settle + settle, times * record, float(worst[settle]), left)


def _worst(series: Sequence[Array], record: int) -> Array:
    """Largest error of any window of `record` cycles that begins at a cycle or behind it, over all series: one for each
    cycle behind which enough windows begin."""
    sums = [np.concatenate(([0.0], np.cumsum(one))) for one in series]
    errors = np.max([np.abs(total[record:] - total[:-record]) / record for total in sums], axis=0)
    behind: Array = np.maximum.accumulate(errors[::-1])[::-1]
    return behind[: max(behind.size - (WINDOWS - 1) * record, 1)]
