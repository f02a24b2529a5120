"""Pacing: the sample index is the only clock; a pacer waits for wall time, and fails when the
samples come late.
"""

import math
import time
from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["NEVER_LATE", "Overrun", "Pacer", "Punctuality"]


class Overrun(Exception):
    """The rig could not keep up with the wall clock. late: seconds after the deadline of
    `sample_index`.
    """

    def __init__(self, sample_index: int, late: float, margin: float) -> None:
        super().__init__(sample_index, late, margin)
        self.sample_index, self.late, self.margin = sample_index, late, margin

    def __str__(self) -> str:
        return (
            f"sample {self.sample_index} came {self.late:.3f} s after its time, more than the {self.margin:g} s "
            "allowed; choose a slower speed, or max"
        )


@dataclass(frozen=True)
class Punctuality:
    """Lateness of blocks, in wall seconds after their deadlines.

    count: number of blocks; total, squares: sums of the lateness and of its square; worst: largest
    lateness.
    """

    count: int = 0
    total: float = 0.0
    squares: float = 0.0
    worst: float = 0.0

    @property
    def mean(self) -> float:
        """Mean lateness, s."""
        return self.total / self.count if self.count else 0.0

    @property
    def jitter(self) -> float:
        """Standard deviation of the lateness, s."""
        return math.sqrt(max(self.squares / self.count - self.mean**2, 0.0)) if self.count else 0.0

    def __add__(self, other: "Punctuality") -> "Punctuality":
        """Return the statistics of both together."""
        return Punctuality(
            self.count + other.count, self.total + other.total, self.squares + other.squares,
            max(self.worst, other.worst),
        )  # fmt: skip


NEVER_LATE = Punctuality()


class Pacer:
    """Holds a stream of samples to wall time.

    rate: samples per second of rig time. speed: rig seconds per wall second, None for as fast as
    possible. margin: seconds that a sample may come late. clock, sleep: seconds, monotonic;
    replaceable for tests. punctuality: lateness of all samples waited for.
    """

    def __init__(
        self,
        rate: float,
        speed: float | None = None,
        margin: float = 0.5,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        if not rate > 0 or (speed is not None and not speed > 0):
            raise ValueError(f"rate {rate} and speed {speed} must be positive")
        self._per_sample = 0.0 if speed is None else 1 / (rate * speed)
        self._margin = margin
        self._clock = clock
        self._sleep = sleep
        self._start: float | None = None
        self.punctuality = NEVER_LATE

    def wait(self, sample_index: int) -> None:
        """Return when the wall time of `sample_index` has come.

        Raises Overrun when it comes later than the margin.

        The first call fixes the start. Every deadline counts from there, so that waits do not
        accumulate errors.
        """
        if not self._per_sample:
            return
        now = self._clock()
        if self._start is None:
            # The first sample waited for is on time by definition, whatever its index.
            self._start = now - sample_index * self._per_sample
        deadline = self._start + sample_index * self._per_sample
        if deadline > now:
            self._sleep(deadline - now)
            now = self._clock()
        late = max(now - deadline, 0.0)
        self.punctuality += Punctuality(1, late, late * late, late)
        if late > self._margin:
            raise Overrun(sample_index, late, self._margin)
