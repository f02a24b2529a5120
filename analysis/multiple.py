"""Comparisons of several means: critical values and p values that keep the error of all of them together.

All tests take means of ln W, each with its variance and degrees of freedom: a scale error of a sensor adds the same
to every ln W and cancels in each difference.
"""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analysis.estimate import effective_dof

__all__ = ["Mean", "beaten", "best_p", "holm", "one_sided_p", "welch"]

Mean = tuple[float, float, float]
"""A mean, its variance, and the degrees of freedom of that."""

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


def welch(one: Mean, other: Mean, most: float = math.inf) -> tuple[float, float]:
    """t of the difference of two means, and its degrees of freedom after Welch and Satterthwaite; at most `most`, all
    that the session has: variances moderated by one prior rest on the same refills."""
    (a, v_a, nu_a), (b, v_b, nu_b) = one, other
    nu = effective_dof([(math.sqrt(v_a), nu_a), (math.sqrt(v_b), nu_b)])
    return (a - b) / math.sqrt(v_a + v_b), min(nu, most)


def best_p(t: float, variances: Sequence[float], own: int, nu: float) -> float:
    """P(max_j (y_j - y_own) / sqrt(v_j + v_own) > t) where all true means are equal: Dunnett's test with the mean `own`
    as control. variances: v of the means; nu: degrees of freedom. Dunnett, J. Am. Stat. Assoc. 50, 1096 (1955).
    """
    loads = [math.sqrt(variances[own] / (v + variances[own])) for j, v in enumerate(variances) if j != own]
    return 1 - _below(t, loads, nu)


def _below(d: float, loads: Sequence[float], nu: float) -> float:
    """P(max_j T_j <= d) of correlated t: given the control's error z and the scale s they are independent normals."""
    from scipy.special import gammaincinv, ndtr, ndtri

    points, weights = _gauss()
    p, weights = (points + 1) / 2, weights / 2
    z = ndtri(p)
    s = np.ones(1) if math.isinf(nu) else np.sqrt(2 * gammaincinv(nu / 2, p) / nu)
    w_s = np.ones(1) if math.isinf(nu) else weights
    load = np.array(loads)
    reach = (load * z[:, None] + d * s[:, None, None]) / np.sqrt(1 - load**2)
    return float(w_s @ np.prod(ndtr(reach), axis=-1) @ weights)


@lru_cache(maxsize=1)
def _gauss() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points and weights of the quadrature, which cost more than what is done with them: eigenvalues of a matrix."""
    points, weights = np.polynomial.legendre.leggauss(NODES)
    return points, weights


def beaten(means: Sequence[Mean], level: float, most: float = math.inf) -> tuple[bool, ...]:
    """Which means are told to be below the largest, by multiple comparisons with the best: those not beaten contain the
    best with a probability of at least 1 - level. Hsu, Ann. Statist. 9, 1026 (1981).

    They scatter differently, so that each comparison has degrees of freedom of its own (Hasler and Hothorn, Biom. J.
    50, 793 (2008)); a mean is judged by the one that is clearest alone. most: see `welch`.
    """
    found = []
    for own, mine in enumerate(means):
        against = [welch(other, mine, most) for j, other in enumerate(means) if j != own]
        t, nu = min(against, key=lambda pair: one_sided_p(*pair), default=(-math.inf, math.inf))
        lost = one_sided_p(t, nu) <= level  # else no family of comparisons is clearer
        found.append(lost and best_p(t, [v for _, v, _ in means], own, nu) <= level)
    return tuple(found)
