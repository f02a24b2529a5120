"""Choose settling and record lengths so that the mean W of every record-length window after
settling is within tolerance.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from rig.fidelity.pilot import Pilot

Array = NDArray[np.float64]

LEAST_RECORD = 4
"""Shortest record, cycles."""

RECORDS = (
    4,
    5,
    6,
    7,
    8,
    9,
    10,
    12,
    15,
    16,
    18,
    20,
    24,
    30,
    36,
    40,
    48,
    60,
    72,
    96,
    120,
    144,
    192,
    240,
    288,
    384,
    480,
)
"""Trial record lengths; many are multiples of 2, 3, 4 and 6, the common periods of rows."""

WINDOWS = 3
"""Least number of windows after settling in a pilot run."""

MULTIPLES = 8
"""Number of multiples tried of each record length, against the noise of the instruments."""

LONGEST_RECORD = 1024
"""Longest record, cycles, to average the noise of the instruments."""


@dataclass(frozen=True)
class LengthChoice:
    """Cycles of settling and record, and their errors, relative to W.

    window : largest error of any window of `record` cycles that begins after `settle` cycles
    noise : expanded uncertainty due to instrument noise
    """

    settle: int
    record: int
    window: float
    noise: float

    @property
    def error(self) -> float:
        """Error counted against the tolerance."""
        return self.window + self.noise


def choose_lengths(
    pilots: Sequence[Pilot], allowed: float, noise: float, least_settle: int = 1, written: int = 50
) -> LengthChoice:
    """Return the shortest run with an error of at most `allowed`; if there is none, the most
    accurate one within `written` cycles in total.

    noise : relative expanded uncertainty of a record of one cycle; it falls with the square root of
        the number of cycles
    """
    series = [pilot.work / pilot.W - 1.0 for pilot in pilots if pilot.W > 0.0]
    cycles = min((one.size for one in series), default=WINDOWS * RECORDS[-1])
    series = [one[:cycles] for one in series]
    worst: dict[int, Array] = {}
    for record in RECORDS:
        if record <= cycles // WINDOWS:
            worst[record] = _worst(series, record)[least_settle:] if series else np.zeros(1)
    found: list[LengthChoice] = []
    for record, errors in worst.items():
        found.extend(_within(record, errors, allowed, noise))
    if not found:
        budget = max(written - least_settle, LEAST_RECORD)
        for record, errors in worst.items():
            found.extend(_in_time(record, errors, noise, budget))
        best = min(found, key=lambda choice: choice.error)
    else:
        best = min(found, key=lambda choice: (choice.settle + choice.record, choice.error))
    return replace(best, settle=least_settle + best.settle)


def _within(record: int, worst: Array, allowed: float, noise: float) -> Iterator[LengthChoice]:
    """Yield the shortest settling within `allowed` for a record and for multiples of it, if there
    is any.

    The error of a mean over several windows is at most that of the worst of them.
    """
    needed = (noise / allowed) ** 2 if noise < allowed * math.sqrt(LONGEST_RECORD) else math.inf
    first = max(math.ceil(min(needed, 2.0 * LONGEST_RECORD) / record), 1)
    for times in range(first, min(first + MULTIPLES, LONGEST_RECORD // record) + 1):
        left = noise / math.sqrt(times * record)
        within = np.flatnonzero(worst <= allowed - left)
        if within.size:
            yield LengthChoice(int(within[0]), times * record, float(worst[within[0]]), left)


def _in_time(record: int, worst: Array, noise: float, budget: int) -> Iterator[LengthChoice]:
    """Yield multiples of a record that leave the rest of `budget` cycles for settling."""
    for times in range(1, budget // record + 1):
        settle = min(budget - times * record, worst.size - 1)
        yield LengthChoice(
            settle, times * record, float(worst[settle]), noise / math.sqrt(times * record)
        )


def _worst(series: Sequence[Array], record: int) -> Array:
    """Return the largest error of any window of `record` cycles that begins at a cycle or later,
    over all series.

    One value for each cycle after which enough windows begin.
    """
    sums = [np.concatenate(([0.0], np.cumsum(one))) for one in series]
    errors = np.max([np.abs(total[record:] - total[:-record]) / record for total in sums], axis=0)
    # Running maximum from the end: the worst window from each cycle on.
    behind: Array = np.maximum.accumulate(errors[::-1])[::-1]
    return behind[: behind.size - (WINDOWS - 1) * record]
