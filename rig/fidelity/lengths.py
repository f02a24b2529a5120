"""How long to settle and to record: no window of so many cycles behind the settling may be off by more than allowed."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

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


def choose_lengths(
    pilots: Sequence[Pilot], allowed: float, noise: float, least_settle: int = 1, written: int = 50
) -> LengthChoice:
    """The shortest run whose error is at most `allowed`; where there is none, the most accurate one that takes no more
    than `written` cycles in all.

    noise : expanded error of a record of one cycle, relative; it falls with the root of the cycles
    """
    series = [pilot.work / pilot.W - 1.0 for pilot in pilots if pilot.W > 0.0]
    cycles = min((one.size for one in series), default=WINDOWS * RECORDS[-1])
    worst = {
        record: _worst([one[:cycles] for one in series], record)[least_settle:] if series else np.zeros(1)
        for record in RECORDS
        if record <= cycles // WINDOWS
    }
    found = [choice for n, errors in worst.items() for choice in _within(n, errors, allowed, noise)]
    if not found:
        budget = max(written - least_settle, LEAST_RECORD)
        found = [choice for n, errors in worst.items() for choice in _in_time(n, errors, noise, budget)]
        best = min(found, key=lambda choice: choice.error)
    else:
        best = min(found, key=lambda choice: (choice.settle + choice.record, choice.error))
    return replace(best, settle=least_settle + best.settle)


def _within(record: int, worst: Array, allowed: float, noise: float) -> Iterator[LengthChoice]:
    """The shortest settling within what is allowed, for a record and for longer ones that are multiples of it: a mean
    of windows is off by no more than the worst of them. Nothing where none is."""
    needed = (noise / allowed) ** 2 if noise < allowed * math.sqrt(LONGEST_RECORD) else math.inf
    first = max(math.ceil(min(needed, 2.0 * LONGEST_RECORD) / record), 1)
    for times in range(first, min(first + MULTIPLES, LONGEST_RECORD // record) + 1):
        left = noise / math.sqrt(times * record)
        within = np.flatnonzero(worst <= allowed - left)
        if within.size:
            yield LengthChoice(int(within[0]), times * record, float(worst[within[0]]), left)


def _in_time(record: int, worst: Array, noise: float, budget: int) -> Iterator[LengthChoice]:
    """Multiples of a record that leave the rest of some cycles to settle."""
    for times in range(1, budget // record + 1):
        settle = min(budget - times * record, worst.size - 1)
        yield LengthChoice(settle, times * record, float(worst[settle]), noise / math.sqrt(times * record))


def _worst(series: Sequence[Array], record: int) -> Array:
    """Largest error of any window of `record` cycles that begins at a cycle or behind it, over all series: one for each
    cycle behind which enough windows begin."""
    sums = [np.concatenate(([0.0], np.cumsum(one))) for one in series]
    errors = np.max([np.abs(total[record:] - total[:-record]) / record for total in sums], axis=0)
    behind: Array = np.maximum.accumulate(errors[::-1])[::-1]
    return behind[: behind.size - (WINDOWS - 1) * record]
