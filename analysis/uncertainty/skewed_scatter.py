"""Correction of Student's interval for a skewed scatter of refills, found with the prediction's own
refills.

Student's t assumes a normal scatter. Where a few refills lie far below all others, four refills
mostly miss these: their mean errs high and their scatter is too small. With a skew of -1.5 the 95 %
interval contains the mean in 88 % of the cases. Neither logarithms nor a bootstrap of the four
correct it; knowledge of the distribution does.
"""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analysis.signals.compiled_loops import errors_of_means
from analysis.uncertainty.estimate import LEVEL, coverage_factor

__all__ = ["SEED", "sessions_of", "skew", "stretch"]

Array = NDArray[np.float64]

SESSIONS, NUMBERS = 2000, 2**15
"""Least number of simulated sessions, and least number of refills over all of them."""

SEED = 1  # of the draws: equal refills have equal factors


def skew(values: Sequence[float]) -> float:
    """Return the third central moment over the cube of the standard deviation; 0 without scatter."""
    if len(values) < 2:
        return 0.0
    apart = np.array(values) - np.mean(values)
    size = float(np.sqrt(np.mean(apart**2)))
    return float(np.mean(apart**3)) / size**3 if size else 0.0


@lru_cache(maxsize=4096)
def stretch(refills: tuple[float, ...], n: int) -> float:
    """Return the factor on the scatter of n refills with which Student's interval of their mean has
    its stated coverage.

    At least 1; 1 where nothing is known. refills: predicted energies of refilled beds, in any unit.
    """
    if n < 2 or len(set(refills)) < 2:
        return 1.0
    values = np.array(refills)
    error, u = sessions_of(values, n, max(SESSIONS, NUMBERS // n))
    ratio = np.abs(error[u > 0]) / u[u > 0]
    return max(1.0, float(np.quantile(ratio, LEVEL)) / coverage_factor(n - 1.0))


def sessions_of(refills: Array, n: int, count: int) -> tuple[Array, Array]:
    """Return the error of the mean of n refills and its standard uncertainty in simulated sessions,
    (count,) each.
    """
    return errors_of_means(refills - refills.mean(), _places(len(refills), n, count))


@lru_cache(maxsize=32)
def _places(size: int, n: int, count: int) -> NDArray[np.uint32]:
    """Return indices of n refills out of `size` for each session, (n, count): the same for all
    conditions.
    """
    drawn = np.random.default_rng([SEED, n]).integers(0, size, (count, n))
    return np.ascontiguousarray(drawn.T, np.uint32)
