"""Integration of a sampled signal over time."""

import numpy as np
from numpy.typing import NDArray

__all__ = ["integral"]

Array = NDArray[np.float64]


def integral(signal: Array, step: float) -> Array:
    """Return the running integral along the last axis, up to a constant; step: s.

    Trapezoid rule with the Euler-Maclaurin end correction: gain error -11/720 (w step)^4 at w and
    no phase error, 3e-10 for the fundamental at 512 points to a cycle (the plain trapezoid's is
    1.3e-5). The slope in the correction wraps around at the ends of the whole array.
    """
    total = np.cumsum(signal, axis=-1)
    total -= 0.5 * signal
    flat, slope = signal.ravel(), np.empty(signal.size)
    np.subtract(flat[2:], flat[:-2], out=slope[1:-1])
    slope[0], slope[-1] = flat[1] - flat[-1], flat[0] - flat[-2]
    slope *= 1 / 24
    total -= slope.reshape(signal.shape)
    total *= step
    return np.asarray(total)
