"""Read work-precision curves: the cost of a method at a given error, and the growth of a cost."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

FLOOR = 1e-17
"""Errors below this, including zero, are drawn and interpolated at this value."""


class Cost(NamedTuple):
    """Seconds at a given error; a lower bound where not `reached`, because even the finest setting
    misses it.
    """

    seconds: float
    reached: bool


def cost_at(wanted: float, errors: Sequence[float], seconds: Sequence[float]) -> Cost:
    """Return the cost at the error `wanted`, from log time over log error; settings ordered from
    coarse to fine.

    An error counts as the largest of its own and all finer settings': a coarse one that is exact by
    chance (errors change sign) is of no use to anybody who does not know the answer. There is no
    extrapolation beyond the coarsest setting.
    """
    worst = np.maximum.accumulate(np.maximum(np.abs(errors), FLOOR)[::-1])[::-1]
    if worst[-1] > wanted:
        return Cost(float(seconds[-1]), False)
    k = int(np.argmax(worst <= wanted))
    if k == 0 or worst[k] == worst[k - 1]:
        return Cost(float(seconds[k]), True)
    weight = math.log(wanted / worst[k - 1]) / math.log(worst[k] / worst[k - 1])
    return Cost(float(seconds[k - 1] ** (1.0 - weight) * seconds[k] ** weight), True)


def exponent(sizes: Sequence[float], seconds: Sequence[float]) -> tuple[float, float]:
    """Return (slope of log time over log size by least squares, its standard error, 0 for two
    points).
    """
    x, y = (
        np.log(np.asarray(sizes, dtype=np.float64)),
        np.log(np.asarray(seconds, dtype=np.float64)),
    )
    x = x - x.mean()
    slope = float(np.dot(x, y) / np.dot(x, x))
    if x.size < 3:
        return slope, 0.0
    left = y - y.mean() - slope * x
    return slope, float(math.sqrt(np.dot(left, left) / (x.size - 2) / np.dot(x, x)))


def order(steps: Sequence[float], errors: Sequence[float]) -> float:
    """Return the order at which errors fall with the number of steps: minus the slope of log error
    over log steps.
    """
    return -exponent(steps, np.maximum(np.abs(errors), FLOOR).tolist())[0]
