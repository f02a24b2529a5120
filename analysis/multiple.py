"""Comparisons of several means: critical values and p values that keep the error of all of them together.

All tests take means of ln W with a common standard deviation s (nu degrees of freedom): a scale error of a sensor adds
the same to every ln W and cancels in each difference.
"""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analysis.estimate import coverage_factor

__all__ = ["beaten", "best_critical", "holm", "one_sided_p"]

NODES = 64  # of either quadrature: critical values are good to 1e-3 from 3 degrees of freedom on (tests)


def one_sided_p(t: float, nu: float) -> float:
    """P(T > t) of Student's t with nu degrees of freedom (inf: normal)."""
    from scipy.special import ndtr, stdtr

    return float(ndtr(-t) if math.isinf(nu) else stdtr(nu, -t))


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """Holm's adjusted p values (Scand. J. Statist. 6, 65 (1979)), in the order given: p <= level rejects."""
    order = sorted(range(len(p_values)), key=p_values.__getitem__)
    adjusted = [0.0] * len(p_values)
    worst = 0.0
    for place, index in enumerate(order):
        worst = max(worst, min(1.0, (len(order) - place) * p_values[index]))
        adjusted[index] = worst
    return tuple(adjusted)


def best_critical(counts: Sequence[float], own: int, nu: float, level: float) -> float:
    """One-sided critical value of Dunnett's type with the mean `own` as control: the d at which
    P(max_j (y_j - y_own) / (s sqrt(1/n_j + 1/n_own)) <= d) = 1 - level where all true means are equal.

    counts: runs behind each mean; nu: degrees of freedom of s. Dunnett, J. Am. Stat. Assoc. 50, 1096 (1955).
    """
    others = sorted(n for j, n in enumerate(counts) if j != own)
    return _critical(tuple(math.sqrt(n / (n + counts[own])) for n in others), nu, level)


@lru_cache(maxsize=256)
def _critical(loads: tuple[float, ...], nu: float, level: float) -> float:
    """By the secant method from the two bounds: a single comparison, and Bonferroni's."""
    old, new = _quantile(nu, level), _quantile(nu, level / len(loads))
    missing_old = _below(old, loads, nu) - (1 - level)
    while abs(new - old) > 1e-7:
        missing = _below(new, loads, nu) - (1 - level)
        old, new = new, new - missing * (new - old) / (missing - missing_old)
        missing_old = missing
    return new


def _quantile(nu: float, level: float) -> float:
    """One-sided t quantile."""
    return coverage_factor(nu, 1 - 2 * level)


def _below(d: float, loads: tuple[float, ...], nu: float) -> float:
    """P(max_j T_j <= d) of correlated t: given the control's error z and the scale s they are independent normals."""
    from scipy.special import gammaincinv, ndtr, ndtri

    points, weights = _gauss()
    p, weights = (points + 1) / 2, weights / 2
    z = ndtri(p)
    s = np.ones(1) if math.isinf(nu) else np.sqrt(2 * gammaincinv(nu / 2, p) / nu)
    w_s = np.ones(1) if math.isinf(nu) else weights
    load, times = np.unique(loads, return_counts=True)
    reach = (load * z[:, None] + d * s[:, None, None]) / np.sqrt(1 - load**2)
    return float(w_s @ np.prod(ndtr(reach) ** times, axis=-1) @ weights)


@lru_cache(maxsize=1)
def _gauss() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points and weights of the quadrature, which cost more than what is done with them: eigenvalues of a matrix."""
    points, weights = np.polynomial.legendre.leggauss(NODES)
    return points, weights


def beaten(means: Sequence[float], counts: Sequence[float], s: float, nu: float, level: float) -> tuple[bool, ...]:
    """Which means are told to be below the largest, by multiple comparisons with the best: those not beaten contain the
    best with a probability of at least 1 - level. Hsu, Ann. Statist. 9, 1026 (1981).

    means: of ln W; counts: runs (or effective runs) behind each; s, nu: common standard deviation of a run and its
    degrees of freedom.
    """
    if len(means) < 2:
        return (False,) * len(means)
    leaders: dict[float, list[float]] = {}  # the two largest means behind which so many runs stand
    for mean, n in zip(means, counts, strict=True):
        leaders[n] = sorted([*leaders.get(n, []), mean], reverse=True)[:2]
    critical = {n: best_critical(counts, counts.index(n), nu, level) for n in leaders}
    found = []
    for mean, own in zip(means, counts, strict=True):
        others = {n: best[1:] if n == own and mean == best[0] else best for n, best in leaders.items()}
        ratios = [(best[0] - mean) / (s * math.sqrt(1 / n + 1 / own)) for n, best in others.items() if best]
        found.append(max(ratios) > critical[own])
    return tuple(found)
