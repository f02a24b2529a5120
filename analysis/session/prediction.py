"""Predicted energies as plain numbers: a power law between tabulated accelerations."""

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["BEYOND", "Curve", "Given", "Predicted", "SessionPrediction", "middle"]

CLOSE = 0.01
"""Relative distance from an acceleration within which all points count for the slope: the measured
acceleration may be off by as much.
"""

NEAR, EITHER_SIDE = 0.04, 3
"""Where fewer points are that close: relative distance within which points count, and their
greatest number on either side, because W is rough from point to point. More points would hide a
slope that changes within 1 %, as that of a single mass does near a jump to another orbit.
"""

BEYOND = 0.1
"""Relative distance outside the tabulated accelerations up to which W_T is still extrapolated: a
table about one level supports no more.
"""


@dataclass(frozen=True, slots=True)
class Curve:
    """W (J per cycle) tabulated at increasing accelerations (m/s^2), a power law between the points
    and beyond the ends.

    Next to a zero the curve is linear, and zero beyond it, because zero has no logarithm.
    """

    accelerations: tuple[float, ...]
    values: tuple[float, ...]

    @classmethod
    def of(cls, accelerations: Sequence[float], values: Sequence[float]) -> "Curve":
        """Return a curve from a table in any order. ValueError where it is not a table of positive
        accelerations.
        """
        if len(accelerations) != len(values) or not values or min(accelerations) <= 0:
            raise ValueError(
                "a prediction needs as many values as accelerations, at least one, accelerations positive"
            )
        pairs = sorted(zip(map(float, accelerations), map(float, values), strict=True))
        return cls(tuple(a for a, _ in pairs), tuple(w for _, w in pairs))

    def _stretch(self, a: float) -> int:
        """Return the index of the interval that contains a, or is nearest to it."""
        inner = sum(1 for x in self.accelerations[1:-1] if x <= a)
        return min(inner, len(self.values) - 2)

    def __call__(self, a: float) -> float:
        """Return W at acceleration a (m/s^2), J per cycle."""
        if len(self.values) == 1:
            return self.values[0]
        i = self._stretch(a)
        a0, a1, w0, w1 = *self.accelerations[i : i + 2], *self.values[i : i + 2]
        if w0 > 0 and w1 > 0:
            return float(w0 * (a / a0) ** (math.log(w1 / w0) / math.log(a1 / a0)))
        between = min(max((a - a0) / (a1 - a0), 0.0), 1.0)
        return w0 + (w1 - w0) * between

    def reaches(self, a: float) -> bool:
        """Return whether acceleration a (m/s^2) is tabulated, or at most BEYOND outside the table."""
        return self.accelerations[0] * (1 - BEYOND) <= a <= self.accelerations[-1] * (1 + BEYOND)

    def exponent(self, a: float) -> float | None:
        """Return n = dlnW / dlna at a, the slope of a line through nearby points (`CLOSE`, `NEAR`).

        None where W is zero or a single point is known.
        """
        if len(self.values) == 1 or self(a) <= 0:
            return None
        i = self._stretch(a)
        # Points around the nearest one, so that they lie on both sides of it where possible.
        near = i if abs(self.accelerations[i] - a) < abs(self.accelerations[i + 1] - a) else i + 1
        low, high = max(near - 1, 0), min(near + 1, len(self.values) - 1)
        while low > 0 and self._counts(a, low - 1, near):
            low -= 1
        while high + 1 < len(self.values) and self._counts(a, high + 1, near):
            high += 1
        if min(self.values[low : high + 1]) <= 0:
            low, high = i, i + 1
        if min(self.values[low : high + 1]) <= 0:
            return None
        x, y = (
            list(map(math.log, part[low : high + 1])) for part in (self.accelerations, self.values)
        )
        return statistics.linear_regression(x, y).slope

    def _counts(self, a: float, place: int, near: int) -> bool:
        """Return whether a point is near enough to a for its slope; near: index of the nearest
        point.
        """
        apart = abs(self.accelerations[place] / a - 1)
        return apart <= CLOSE or (apart <= NEAR and abs(place - near) <= EITHER_SIDE)


Given = float | tuple[float, ...] | None
"""A number given once, or one beside each acceleration."""


@dataclass(frozen=True, slots=True)
class Predicted:
    """The prediction of a condition, means over its runs, each at its measured acceleration.

    Energies in J per cycle; exponent: dlnW_T/dlna. None for unknown values.
    """

    W_T: float | None = None
    W_f: float | None = None
    W_c: float | None = None
    exponent: float | None = None
    W_T_as_printed: float | None = None
    bound: float | None = None
    period: float | None = None
    periodic_share: float | None = None


@dataclass(frozen=True, slots=True)
class SessionPrediction:
    """The prediction of one condition as curves, with the relative standard uncertainties of its
    entry.
    """

    total: Curve
    friction: Curve
    collision: Curve
    u_rel: float
    u_levels: float
    u_settling: float
    u_stated: float = 0.0


def middle(value: Given, accelerations: Sequence[float]) -> float | None:
    """Return a number that is given once, or of a list beside the accelerations the one at their
    median.
    """
    if isinstance(value, tuple):
        order = sorted(range(len(accelerations)), key=accelerations.__getitem__)
        value = value[order[len(order) // 2]] if value else None
    return value if value is None else value + 0
