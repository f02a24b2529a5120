"""Predicted energies as plain numbers: a power law between tabulated accelerations."""

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["BEYOND", "Curve", "Given", "Predicted", "SessionPrediction", "middle"]

CLOSE = 0.01
"""How far from an acceleration, relative, all points tell of the slope there: as far as the
measured one may be off.
"""

NEAR, EITHER_SIDE = 0.04, 3
"""Where fewer are close, so many points to either side tell of it, as far off as that: W is rough
from one to the next. More would hide a slope that changes within a hundredth, as a single mass's
does beside a jump to another orbit."""

BEYOND = 0.1
"""How far outside its tabulated accelerations, relative, a W_T is still read: a table about one
level tells no more.
"""


@dataclass(frozen=True, slots=True)
class Curve:
    """W (J per cycle) tabulated at increasing accelerations (m/s^2); log-log between them and
    beyond the ends.

    A stretch with a zero at one end is linear instead and zero outside it: a logarithm has no place
    there.
    """

    accelerations: tuple[float, ...]
    values: tuple[float, ...]

    @classmethod
    def of(cls, accelerations: Sequence[float], values: Sequence[float]) -> "Curve":
        """A curve from a table in any order. ValueError where it is not a table of positive
        accelerations.
        """
        if len(accelerations) != len(values) or not values or min(accelerations) <= 0:
            raise ValueError(
                "a prediction needs as many values as accelerations, at least one, accelerations positive"
            )
        pairs = sorted(zip(map(float, accelerations), map(float, values), strict=True))
        return cls(tuple(a for a, _ in pairs), tuple(w for _, w in pairs))

    def _stretch(self, a: float) -> int:
        inner = sum(1 for x in self.accelerations[1:-1] if x <= a)
        return min(inner, len(self.values) - 2)

    def __call__(self, a: float) -> float:
        """W at acceleration a (m/s^2), J per cycle."""
        if len(self.values) == 1:
            return self.values[0]
        i = self._stretch(a)
        a0, a1, w0, w1 = *self.accelerations[i : i + 2], *self.values[i : i + 2]
        if w0 > 0 and w1 > 0:
            return float(w0 * (a / a0) ** (math.log(w1 / w0) / math.log(a1 / a0)))
        between = min(max((a - a0) / (a1 - a0), 0.0), 1.0)
        return w0 + (w1 - w0) * between

    def reaches(self, a: float) -> bool:
        """Whether acceleration a (m/s^2) is tabulated, or at most BEYOND outside the table."""
        return self.accelerations[0] * (1 - BEYOND) <= a <= self.accelerations[-1] * (1 + BEYOND)

    def exponent(self, a: float) -> float | None:
        """n = dlnW / dlna at a, a fit to the neighbouring points and all that tell of it (`CLOSE`,
        `NEAR`); None where W is zero or a single point is known."""
        if len(self.values) == 1 or self(a) <= 0:
            return None
        i = self._stretch(a)
        # About the nearest tabulated point, where that has neighbours on both sides.
        near = i if abs(self.accelerations[i] - a) < abs(self.accelerations[i + 1] - a) else i + 1
        low, high = max(near - 1, 0), min(near + 1, len(self.values) - 1)
        while low > 0 and self._tells(a, low - 1, near):
            low -= 1
        while high + 1 < len(self.values) and self._tells(a, high + 1, near):
            high += 1
        if min(self.values[low : high + 1]) <= 0:
            low, high = i, i + 1
        if min(self.values[low : high + 1]) <= 0:
            return None
        x, y = (
            list(map(math.log, part[low : high + 1])) for part in (self.accelerations, self.values)
        )
        return statistics.linear_regression(x, y).slope

    def _tells(self, a: float, place: int, near: int) -> bool:
        """Whether a point tells of the slope at a, whose nearest point is `near`."""
        apart = abs(self.accelerations[place] / a - 1)
        return apart <= CLOSE or (apart <= NEAR and abs(place - near) <= EITHER_SIDE)


Given = float | tuple[float, ...] | None
"""A number given once, or one beside each acceleration."""


@dataclass(frozen=True, slots=True)
class Predicted:
    """What is predicted of a condition, means over its runs, each at its measured acceleration: J
    per cycle; exponent: dlnW_T/dlna. None for what is not known."""

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
    """The prediction for one condition as curves, with the relative standard uncertainties of its
    entry.
    """

    total: Curve
    friction: Curve
    collision: Curve
    u_rel: float
    u_levels: float
    u_settling: float


def middle(value: Given, accelerations: Sequence[float]) -> float | None:
    """A number given once, or as a list beside the accelerations (then the one at the middle
    acceleration).
    """
    if isinstance(value, tuple):
        order = sorted(range(len(accelerations)), key=accelerations.__getitem__)
        value = value[order[len(order) // 2]] if value else None
    return value if value is None else value + 0
