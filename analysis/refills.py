"""What a skewed scatter of refills does to stated intervals, found with the prediction's own refills.

Student's t assumes a normal scatter. Where a few refills lie far below all others, four of them
mostly miss these, err high and agree too well. U is stretched for it (`analysis.uncertainty`),
which keeps 93 to 97 % up to a skew of 1; beyond, the report says what it holds and how many refills
mend it. Neither logarithms nor a bootstrap of the four do.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analysis.conditions import Result
from analysis.estimate import Estimate
from analysis.uncertainty import CERTIFICATE_NU, skew, stretched

__all__ = ["SKEWED", "WANTED", "Coverage", "coverage", "held", "refills_row"]

Array = NDArray[np.float64]

SKEWED = 0.75
"""Size of the skew from which on the coverage is told: that of some hundred refills is good to 0.25."""

WANTED = 0.93
TRIED = (4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)  # refills
SESSIONS = 4000  # drawn: a coverage of 93 % is good to 0.4 %
SEED = 1


@dataclass(frozen=True, slots=True)
class Coverage:
    """share: of the stated 95 % intervals that hold the mean of all refills, with as many as there
    are; needed: fewest refills with which WANTED of them do (as many as there are where that is
    enough), None where none of TRIED is."""

    share: float
    needed: int | None


def refills_row(result: Result) -> dict[str, float | int | None]:
    """The report's entry of a condition. refill_mean: what refills take beyond the nominal bed in the
    mean, relative; refill_skew; coverage and refills needed where that is large."""
    told, refills = None, result.refills
    if len(result.runs) > 1 and abs(skew(refills)) >= SKEWED:
        told = coverage(result)
    return {
        "refill_mean": math.fsum(refills) / len(refills) - 1 if refills else None,
        "refill_skew": skew(refills) if refills else None,
        "refill_coverage": told.share if told else None,
        "refills_needed": told.needed if told else None,
    }


def coverage(result: Result) -> Coverage | None:
    """What the interval of W_exp holds; None without W_T and W_exp above 0."""
    if result.W_T is None or not result.W_exp.value > 0:
        return None
    poured = np.array(result.refills) * result.W_T.value / result.W_exp.value
    certified = math.sqrt(math.fsum(line.part**2 for line in result.lines if line.shared)) / result.W_exp.value
    n, g = len(result.runs), skew(result.refills)
    share = held(poured, certified, n, g)
    if share >= WANTED:
        return Coverage(share, n)
    more = (m for m in TRIED if m > n and held(poured, certified, m, g) >= WANTED)
    return Coverage(share, next(more, None))


def held(poured: Array, certified: float, n: int, predicted: float) -> float:
    """Return the share of sessions of n refills whose U of W_exp holds the mean.

    poured: energies that refills are drawn from, over W_exp; certified: relative standard uncertainty of the
    instruments; predicted: skew that U is stretched for.
    """
    rng = np.random.default_rng(SEED)
    drawn = rng.choice(poured, (SESSIONS, n))
    error = drawn.mean(axis=1) - poured.mean() + certified * rng.standard_normal(SESSIONS)
    u = drawn.std(axis=1, ddof=1) / math.sqrt(n) * stretched(predicted, n)
    total = np.hypot(u, certified)
    share, k = _factors(n)
    return float(np.mean(np.abs(error) <= np.interp((u / total) ** 2, share, k) * total))


@lru_cache(maxsize=32)
def _factors(n: int) -> tuple[Array, Array]:
    """Coverage factors of n refills beside certificates, by the refills' share of u^2; between them they lie within
    0.1 % of a straight line."""
    share = np.linspace(0.0, 1.0, 17)
    parts = ([(math.sqrt(s), n - 1.0), (math.sqrt(1.0 - s), CERTIFICATE_NU)] for s in share)
    return share, np.array([Estimate.of(0.0, each).k for each in parts])
