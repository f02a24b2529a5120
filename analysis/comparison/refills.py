"""The report's columns about refills: their mean beside the nominal bed, their skew, and the
coverage of the intervals.

U of a skewed scatter is widened until Student's interval of the refills holds 95 %
(`analysis.uncertainty.skewed_scatter`). The coverage beside certificates is simulated here, with
the condition's own budget and the prediction's own refills, and stated in the report.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analysis.results.condition import Result
from analysis.signals.compiled_loops import covered
from analysis.uncertainty.budget import CERTIFICATE_NU
from analysis.uncertainty.estimate import Estimate
from analysis.uncertainty.skewed_scatter import SEED, sessions_of, skew, stretch

__all__ = [
    "SKEWED",
    "TRIED",
    "WANTED",
    "Coverage",
    "RefillColumns",
    "coverage",
    "held",
    "refill_columns",
]

Array = NDArray[np.float64]

SKEWED = 0.75
"""Least skew for which the report states the coverage: the skew of some hundred refills is known to
0.25.
"""

WANTED = 0.93  # coverage that the recommended number of refills reaches
TRIED = (4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)  # numbers of refills
SESSIONS = 4000  # simulated: a coverage of 93 % is good to 0.4 %


@dataclass(frozen=True, slots=True)
class Coverage:
    """Simulated coverage of the 95 % intervals of W_exp.

    coverage : fraction of sessions whose stated interval contains the mean of all refills
    plain : the same of Student's interval, not widened
    needed : fewest refills with which `plain` reaches WANTED (the present number where it does);
        None where no number of TRIED is enough
    """

    coverage: float
    plain: float
    needed: int | None


@dataclass(frozen=True, slots=True)
class RefillColumns:
    """The columns of a condition about its refills.

    refill_mean : mean energy of the prediction's refills over the nominal bed's, less 1
    refill_skew : skew of their energies
    refill_coverage, refill_coverage_plain, refills_needed : see `Coverage`; None where the skew is
        small
    """

    refill_mean: float | None
    refill_skew: float | None
    refill_coverage: float | None
    refill_coverage_plain: float | None
    refills_needed: int | None


def refill_columns(result: Result) -> RefillColumns:
    """Return the columns of a condition about its refills."""
    found, refills = None, result.refills
    skewed = skew(refills)
    if len(result.runs) > 1 and abs(skewed) >= SKEWED:
        found = coverage(result)
    return RefillColumns(
        refill_mean=math.fsum(refills) / len(refills) - 1 if refills else None,
        refill_skew=skewed if refills else None,
        refill_coverage=found.coverage if found else None,
        refill_coverage_plain=found.plain if found else None,
        refills_needed=found.needed if found else None,
    )


def coverage(result: Result) -> Coverage | None:
    """Return the coverage of the interval of W_exp; None without W_T or where W_exp is not above 0."""
    if result.W_T is None or not result.W_exp.value > 0:
        return None
    refills = np.array(result.refills) * result.W_T.value / result.W_exp.value
    certified = (
        math.sqrt(math.fsum(line.part**2 for line in result.lines if line.shared))
        / result.W_exp.value
    )
    n = len(result.runs)
    stated, plain = held(refills, certified, n, (stretch(result.refills, n), 1.0))
    needed = n if plain >= WANTED else None
    for m in TRIED:
        if needed is None and m > n and held(refills, certified, m)[0] >= WANTED:
            needed = m
    return Coverage(stated, plain, needed)


def held(
    refills: Array, certified: float, n: int, factors: Sequence[float] = (1.0,)
) -> tuple[float, ...]:
    """Return the fraction of sessions of n refills whose U of W_exp contains the mean, one for each
    factor.

    refills: energies to draw from, over W_exp; certified: relative standard uncertainty of the
    instruments; factors: on the scatter between refills.
    """
    error, scatter = sessions_of(refills, n, SESSIONS)
    normal, k = _certificates(), _factors(n)
    return tuple(
        covered(error, scatter, certified, normal, factor, k) / SESSIONS for factor in factors
    )


@lru_cache(maxsize=1)
def _certificates() -> Array:
    """Return the errors of the instruments over their u, one for each simulated session."""
    return np.random.default_rng(SEED).standard_normal(SESSIONS)


@lru_cache(maxsize=32)
def _factors(n: int) -> Array:
    """Return the coverage factors k at fractions of u^2, from 0 to 1, that are due to the refills.

    n: number of refills. Interpolated linearly, k is within 0.7 % for two refills, 0.2 % for more.
    """
    fractions = np.linspace(0.0, 1.0, 17)
    parts = ([(math.sqrt(s), n - 1.0), (math.sqrt(1.0 - s), CERTIFICATE_NU)] for s in fractions)
    return np.array([Estimate.of(0.0, each).k for each in parts])
