"""Comparisons of several means: critical values and p values that keep the error of all of them together.

All tests take means of ln W, each with its variance and degrees of freedom: a scale error of a sensor adds the same
to every ln W and cancels in each difference.
"""

import math
from collections.abc import Sequence

from analysis.estimate import effective_dof

__all__ = ["Mean", "beaten", "holm", "one_sided_p", "welch"]

Mean = tuple[float, float, float]
"""A mean, its variance, and the degrees of freedom of that."""


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


def beaten(means: Sequence[Mean], level: float, most: float = math.inf) -> tuple[bool, ...]:
    """Which means are told to be below another, by multiple comparisons with the best (Hsu, Ann. Statist. 9, 1026
    (1981)): those not beaten contain the best with a probability of at least 1 - level.

    They scatter differently, so that each comparison has an error and degrees of freedom of its own; the clearest of
    a mean's comparisons is judged at the level over their number (Bonferroni). most: see `welch`.
    """
    found = []
    for own, mine in enumerate(means):
        against = [one_sided_p(*welch(other, mine, most)) for j, other in enumerate(means) if j != own]
        found.append(min(against, default=1.0) * len(against) <= level)
    return tuple(found)
