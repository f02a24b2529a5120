"""Variances of conditions that scatter differently, each from few repeats: shrunk towards their
expected values.

The variance of four refills has 3 degrees of freedom: alone it decides nearly nothing, and pooling
is wrong where one condition scatters more than another. So the variances are expected up to a
common factor (equal ones where nothing is known), and the true variances are modelled as draws from
s0^2 nu0/chi^2(nu0) times the expected ones, with s0 and nu0 estimated from all conditions of the
session. If the expectation is right, nu0 is large, and the variances are the expected ones with one
factor; if not, each counts mostly for itself. Smyth, Stat. Appl. Genet. Mol. Biol. 3, 3 (2004).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["Prior", "prior_of"]

Part = tuple[float, float]  # variance, degrees of freedom


@dataclass(frozen=True, slots=True)
class Prior:
    """The distribution of the variances over their expected values.

    variance : typical ratio
    nu : its degrees of freedom (inf: all ratios are equal)
    pooled : mean ratio
    most : degrees of freedom of all conditions together, which none can exceed
    """

    variance: float
    nu: float
    pooled: float
    most: float

    def moderated(self, variance: float, nu: float, expected: float | None = None) -> Part:
        """Return a condition's moderated variance with its degrees of freedom.

        variance, nu: its own (nu = 0 without repeats); expected: None where no variance is
        expected.

        Never less than its own: refills have long tails, and the mean of those that contain an
        outlier errs by as much as they scatter. Without an expectation never less than the mean of
        all either: a small variance of a few refills is more often chance. Both keep false
        exclusions of the best at 5 % (tests/physics/test_claims_scatter.py).
        """
        least = max(variance, self.pooled if expected is None else 0.0)
        common = self.variance * (1.0 if expected is None else expected)
        if math.isinf(self.nu):
            return max(common, least), self.most
        shrunk = (self.nu * common + nu * variance) / (self.nu + nu)
        return max(shrunk, least), min(self.nu + nu, self.most)


def prior_of(parts: Sequence[Part]) -> Prior:
    """Return the prior, from ratios of positive variances to expected ones with their degrees of
    freedom (at least 1).

    By the moments of their logarithms: ln s^2 of nu degrees of freedom has the mean ln sigma^2 +
    psi(nu/2) - ln(nu/2) and the variance psi'(nu/2); the variance of the logarithms beyond
    psi'(nu/2) is that of ln sigma^2, psi'(nu0/2).
    """
    from scipy.special import psi

    variance, nu = np.array(parts).T
    most = float(nu.sum())
    pooled = float(nu @ variance) / most
    logs = np.log(variance) - psi(nu / 2) + np.log(nu / 2)
    beyond = float(logs.var(ddof=1) - _zeta(2, nu / 2).mean()) if len(parts) > 1 else 0.0
    if beyond <= 0:
        return Prior(pooled, math.inf, pooled, most)
    half = _inverse_trigamma(beyond)
    return Prior(math.exp(float(logs.mean() + psi(half)) - math.log(half)), 2 * half, pooled, most)


def _inverse_trigamma(value: float) -> float:
    """Return x with psi'(x) = value > 0, by Newton's method on 1/psi', which is convex and nearly
    straight (Smyth, appendix).
    """
    x, change = 0.5 + 1 / value, math.inf
    while abs(change) > 1e-8 * x:
        tri = float(_zeta(2, x))
        change = tri * (1 - tri / value) / (-2 * float(_zeta(3, x)))
        x += change
    return x


def _zeta(order: int, x: float | NDArray[np.float64]) -> NDArray[np.float64]:
    """Return Hurwitz's zeta: psi'(x) is that of order 2, psi''(x) -2 times that of order 3."""
    from scipy import special

    zeta: Callable[..., NDArray[np.float64]] = special.zeta
    return zeta(order, x)
