"""What a skewed scatter of refills does to stated intervals: their coverage, found with the prediction's own refills.

Student's t assumes a normal scatter. Where a few refills lie far below all others, four of them mostly miss these, err
high and agree too well: of a skew of -1.5 the interval for 95 % holds the mean in 90 %. Neither logarithms nor a
bootstrap of the four mend it; more refills do.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.conditions import Result
from analysis.estimate import Estimate
from analysis.uncertainty import CERTIFICATE_NU

__all__ = ["SKEWED", "WANTED", "Coverage", "coverage", "coverage_row", "skew"]

Array = NDArray[np.float64]

SKEWED = 1.0  # size of the skew from which on the coverage is told
WANTED = 0.93
TRIED = (4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)  # refills
SESSIONS = 4000  # drawn: a coverage of 93 % is good to 0.4 %
SHARES = 33  # of the scatter, at which the coverage factor is computed
SEED = 1


@dataclass(frozen=True, slots=True)
class Coverage:
    """skew: of the refills; share: of the stated 95 % intervals that hold the mean of all refills; needed: fewest refills
    tried with which WANTED of them do, None where none of TRIED is enough."""

    skew: float
    share: float
    needed: int | None


def coverage_row(result: Result) -> dict[str, float | int | None]:
    """The report's entry of a condition: the skew wherever refills were predicted, the rest where it is large."""
    found = coverage(result) if len(result.runs) > 1 else None
    told = None if found is None or abs(found.skew) < SKEWED else found
    return {
        "refill_skew": found.skew if found else None,
        "refill_coverage": told.share if told else None,
        "refills_needed": told.needed if told else None,
    }


def coverage(result: Result) -> Coverage | None:
    """What the interval of W_exp holds; None where no refills were predicted, or they do not scatter."""
    if result.W_T is None or not result.W_exp.value > 0 or not result.refills:
        return None
    poured = np.array(result.refills) * result.W_T.value / result.W_exp.value
    if not poured.std() > 0:
        return None
    certified = math.sqrt(math.fsum(line.part**2 for line in result.lines if line.shared)) / result.W_exp.value
    found = skew(poured)
    if abs(found) < SKEWED:
        return Coverage(found, math.nan, None)
    shares: Mapping[int, float] = {n: _held(poured, certified, n) for n in {len(result.runs), *TRIED}}
    needed = next((n for n in TRIED if shares[n] >= WANTED), None)
    return Coverage(found, shares[len(result.runs)], needed)


def skew(values: Sequence[float] | Array) -> float:
    """Third central moment over the cube of the standard deviation; 0 without scatter."""
    apart = np.asarray(values) - np.mean(values)
    size = float(np.sqrt(np.mean(apart**2)))
    return float(np.mean(apart**3)) / size**3 if size else 0.0


def _held(poured: Array, certified: float, n: int) -> float:
    """Share of sessions of n refills, instruments off by `certified` (relative, one sigma), whose U holds the mean."""
    rng = np.random.default_rng(SEED)
    drawn = rng.choice(poured, (SESSIONS, n))
    error = drawn.mean(axis=1) - poured.mean() + certified * rng.standard_normal(SESSIONS)
    u = drawn.std(axis=1, ddof=1) / math.sqrt(n)
    total = np.hypot(u, certified)
    share = np.linspace(0.0, 1.0, SHARES)
    parts = ([(math.sqrt(s), n - 1.0), (math.sqrt(1.0 - s), CERTIFICATE_NU)] for s in share)
    k = np.interp((u / np.maximum(total, 1e-300)) ** 2, share, [Estimate.of(0.0, each).k for each in parts])
    return float(np.mean(np.abs(error) <= k * total))
