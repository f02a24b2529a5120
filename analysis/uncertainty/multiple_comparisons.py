"""Comparisons of several means: p values that control the error of all comparisons together.

All tests take means of ln W, each with its variance and degrees of freedom: a scale error of a
sensor adds the same to every ln W and cancels in each difference.
"""

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from analysis.uncertainty.estimate import effective_dof

__all__ = ["Mean", "beaten", "holm", "one_sided_p", "welch"]

Array = NDArray[np.float64]
Mean = tuple[float, float, float]
"""A mean, its variance, and the degrees of freedom of the variance."""

GROUPS = 64
"""Largest number of groups of similar variance."""

REACH, STEP = 7.0, 0.05  # range and step of sums over a mean's own error, standard deviations


def one_sided_p(t: float, nu: float) -> float:
    """Return P(T > t) of Student's t with nu degrees of freedom (inf: normal)."""
    return float(_tail(np.array([t]), np.array([1 / nu]))[0])


def _tail(t: Array, inverse: Array) -> Array:
    """Return P(T > t) of Student's t with 1/`inverse` degrees of freedom (0: normal)."""
    from scipy.special import ndtr, stdtr

    found: Array = ndtr(-t)
    few = inverse > 0
    found[few] = stdtr(1 / inverse[few], -t[few])
    return found


def holm(p_values: Sequence[float]) -> tuple[float, ...]:
    """Return Holm's adjusted p values (Scand. J. Statist. 6, 65 (1979)), in the order given: p <=
    level rejects.
    """
    order = sorted(range(len(p_values)), key=p_values.__getitem__)
    adjusted = [0.0] * len(p_values)
    worst = 0.0
    for place, index in enumerate(order):
        worst = max(worst, min(1.0, (len(order) - place) * p_values[index]))
        adjusted[index] = worst
    return tuple(adjusted)


def welch(one: Mean, other: Mean, most: float = math.inf) -> tuple[float, float]:
    """Return t of the difference of two means and its degrees of freedom (Welch-Satterthwaite).

    most: upper limit of these, the degrees of freedom of the session: variances moderated by one
    prior rest on the same refills.
    """
    (a, v_a, nu_a), (b, v_b, nu_b) = one, other
    nu = effective_dof([(math.sqrt(v_a), nu_a), (math.sqrt(v_b), nu_b)])
    return (a - b) / math.sqrt(v_a + v_b), min(nu, most)


def beaten(means: Sequence[Mean], most: float = math.inf) -> tuple[float, ...]:
    """Return the p value of each mean for the hypothesis that it is the best.

    The means with p above a level contain the best with a probability of at least 1 - level
    (multiple comparisons with the best; Hsu, Ann. Statist. 9, 1026 (1981)).

    Means scatter differently, so each comparison has its own error and degrees of freedom. The most
    significant comparison of a mean is judged against the distribution of the most significant of
    as many by chance. All of them contain the mean's own error: a mean that scatters much is
    compared with all others at nearly the level of a single test. most: see `welch`.
    """
    from scipy.special import ndtr, ndtri

    if len(means) < 2:
        return (1.0,) * len(means)
    group, best, second, variance, nu, size = _alike(means)
    own, weights = _normal()
    found = []
    for place, (mean, v, dof) in enumerate(means):
        count, top = size.copy(), best.copy()
        mine = group[place]
        count[mine] -= 1
        if mean >= best[mine]:
            top[mine] = second[mine]
        there = count > 0
        other, top, count = variance[there], top[there], count[there]
        t = (top - mean) / np.sqrt(other + v)
        inverse = np.maximum((other**2 / nu[there] + v**2 / dof) / (other + v) ** 2, 1 / most)
        score = -float(ndtri(_tail(t, inverse).min()))
        reach = (score * np.sqrt(other + v))[:, None] + math.sqrt(v) * own
        found.append(
            1.0
            - float(
                (ndtr(reach / np.sqrt(other)[:, None]) ** count[:, None]).prod(axis=0) @ weights
            )
        )
    return tuple(found)


def _alike(
    means: Sequence[Mean],
) -> tuple[NDArray[np.int64], Array, Array, Array, Array, NDArray[np.int64]]:
    """Return the group of each mean, and of each group its two largest means, variance, degrees of
    freedom and size.

    Up to `GROUPS` means each form their own group, and the result is exact. More means are grouped
    by similar variance: each counts with the mean variance of its group and the fewest degrees of
    freedom in it, so that the work grows with the number of means and not with that of pairs.
    """
    value, variance, nu = np.array(means).T
    order = np.argsort(variance, kind="stable")
    count = min(GROUPS, len(means))
    starts = np.arange(count) * len(means) // count
    group = np.empty(len(means), np.int64)
    group[order] = np.searchsorted(starts, np.arange(len(means)), side="right") - 1
    size = np.diff([*starts, len(means)])
    by_value = np.lexsort((-value, group))  # the largest of each group first
    second = np.where(size > 1, value[by_value[np.minimum(starts + 1, len(means) - 1)]], -math.inf)
    mean = np.add.reduceat(variance[order], starts) / size
    return (
        group,
        value[by_value[starts]],
        second,
        mean,
        np.minimum.reduceat(nu[order], starts),
        size,
    )


@lru_cache(maxsize=1)
def _normal() -> tuple[Array, Array]:
    """Return normal deviates and their weights, whose sum is 1."""
    deviates = np.arange(-REACH, REACH + STEP / 2, STEP)
    weights = np.exp(-(deviates**2) / 2)
    return deviates, weights / weights.sum()
