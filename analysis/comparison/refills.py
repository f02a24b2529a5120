"""What the report says of refills: what they take beside the nominal bed, their skew, and where
that is large how often the stated intervals hold, found with the prediction's own refills.

U of a skewed scatter is stretched until its share holds (`analysis.uncertainty.skewed_scatter`),
beside certificates and for the refills that were predicted; what it holds is computed anew for the
condition's own budget, and printed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analysis.results.condition import Result
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
"""Least skew for which the report states the coverage; the skew of some hundred refills is known to
0.25.
"""

WANTED = 0.93
TRIED = (4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)  # refills
SESSIONS = 4000  # drawn: a coverage of 93 % is good to 0.4 %


@dataclass(frozen=True, slots=True)
class Coverage:
    """Shares of the intervals for 95 % that hold the mean of all refills, with as many as there
    are: as stated, and of Student's t as it is. needed: fewest refills with which WANTED of the
    latter do (as many as there are where that is enough), None where none of TRIED is."""

    share: float
    plain: float
    needed: int | None


@dataclass(frozen=True, slots=True)
class RefillColumns:
    """What the report says of a condition's refills: what they take beyond the nominal bed in the
    mean, relative; their skew; where that is large the coverage as stated and of Student's t, and
    the refills needed for that."""

    refill_mean: float | None
    refill_skew: float | None
    refill_coverage: float | None
    refill_coverage_plain: float | None
    refills_needed: int | None


def refill_columns(result: Result) -> RefillColumns:
    """What the report says of the refills of a condition."""
    told, refills = None, result.refills
    if len(result.runs) > 1 and abs(skew(refills)) >= SKEWED:
        told = coverage(result)
    return RefillColumns(
        refill_mean=math.fsum(refills) / len(refills) - 1 if refills else None,
        refill_skew=skew(refills) if refills else None,
        refill_coverage=told.share if told else None,
        refill_coverage_plain=told.plain if told else None,
        refills_needed=told.needed if told else None,
    )


def coverage(result: Result) -> Coverage | None:
    """What the interval of W_exp holds; None without W_T and W_exp above 0."""
    if result.W_T is None or not result.W_exp.value > 0:
        return None
    poured = np.array(result.refills) * result.W_T.value / result.W_exp.value
    certified = (
        math.sqrt(math.fsum(line.part**2 for line in result.lines if line.shared))
        / result.W_exp.value
    )
    n = len(result.runs)
    share, plain = held(poured, certified, n, (stretch(result.refills, n), 1.0))
    needed = n if plain >= WANTED else None
    for m in TRIED:
        if needed is None and m > n and held(poured, certified, m)[0] >= WANTED:
            needed = m
    return Coverage(share, plain, needed)


def held(
    poured: Array, certified: float, n: int, factors: Sequence[float] = (1.0,)
) -> tuple[float, ...]:
    """Return the shares of sessions of n refills whose U of W_exp holds the mean.

    poured: energies that refills are drawn from, over W_exp; certified: relative standard
    uncertainty of the instruments; factors: on the scatter between refills, a share for each.
    """
    error, scatter = sessions_of(poured, n, SESSIONS)
    error = np.abs(error + certified * _certificates())
    shares, k = _factors(n)
    found = []
    for factor in factors:
        own = (factor * scatter) ** 2
        whole = own + certified**2
        found.append(float(np.mean(error <= np.interp(own / whole, shares, k) * np.sqrt(whole))))
    return tuple(found)


@lru_cache(maxsize=1)
def _certificates() -> Array:
    """Errors of the instruments over their u, in every session drawn."""
    return np.random.default_rng(SEED).standard_normal(SESSIONS)


@lru_cache(maxsize=32)
def _factors(n: int) -> tuple[Array, Array]:
    """Coverage factors of n refills beside certificates, by the refills' share of u^2; between them they lie within
    0.7 % of a straight line for two refills, 0.2 % for more."""
    share = np.linspace(0.0, 1.0, 17)
    parts = ([(math.sqrt(s), n - 1.0), (math.sqrt(1.0 - s), CERTIFICATE_NU)] for s in share)
    return share, np.array([Estimate.of(0.0, each).k for each in parts])
