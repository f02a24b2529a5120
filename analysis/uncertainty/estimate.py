"""Estimates: measured values with their standard uncertainty, the results of the analysis."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

__all__ = ["Estimate", "coverage_factor", "effective_dof"]

Array = NDArray[np.float64]
Part = tuple[float, float]  # standard uncertainty, degrees of freedom

LEVEL = 0.95  # coverage probability of every expanded uncertainty
UNBOUNDED = 1e6  # degrees of freedom that cannot be distinguished from infinity
FEW = 30.0  # degrees of freedom below which a part's own uncertainty is an estimate from few values
PRIOR = 1.4
"""Exponent of the prior in `_spread_of`. 0 adds errors of Student's distributions, as GUM
Supplement 1 does: up to 97.6 % instead of 95 % at 3 values. 2 is right to second order for many
values (Ghosh and Kim, Canad. J. Statist. 29, 5 (2001)): down to 93.2 % at 3. In between, the
largest error of the coverage over all fractions is least: 94.2 to 95.9 % at 3 values, 94.7 to 95.6
% at 4 (tests).
"""
NODES = 64, 16  # of the quadratures over the two groups' variances: k is good to 1e-4 (tests)


def coverage_factor(nu: float, level: float = LEVEL) -> float:
    """Return the two-sided coverage factor k of Student's t at `nu` degrees of freedom (GUM G.3):
    1.96 at infinity, 3.18 at 3.
    """
    from scipy.special import ndtri, stdtrit

    p = 0.5 + level / 2
    return float(ndtri(p)) if math.isinf(nu) else float(stdtrit(nu, p))


def effective_dof(parts: Sequence[Part]) -> float:
    """Return the Welch-Satterthwaite degrees of freedom (GUM eq. G.2b) of a sum with parts
    (standard uncertainty, nu).

    Infinite where no part with finite nu contributes.
    """
    total = math.fsum(u * u for u, _ in parts)
    if total == 0:
        return math.inf
    spread = math.fsum((u * u / total) ** 2 / nu for u, nu in parts if not math.isinf(nu))
    return math.inf if spread < 1 / UNBOUNDED else 1 / spread


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value, its standard uncertainty u (same unit) and the effective degrees of freedom nu of u
    (inf allowed).

    groups: (u, nu) of the parts that were estimated from few values, and of the rest, where both
    contribute. The two u add in quadrature, but k is not Student's at nu: where a handful of
    refills scatters little by chance, nu comes out large beside the certificates and U too small,
    so that it contains the truth in 92 % instead of 95 % of the cases (3 refills, certificates of
    half their uncertainty). k is that of the Behrens-Fisher problem instead, see _spread_of.
    """

    value: float
    u: float
    nu: float
    groups: tuple[Part, ...] = ()

    @classmethod
    def of(cls, value: float, parts: Sequence[Part]) -> "Estimate":
        """Return the estimate from independent parts (standard uncertainty in the value's unit,
        nu).

        Welch-Satterthwaite within each of the two groups.
        """
        few, rest = (
            [part for part in parts if part[0] and (part[1] < FEW) == small]
            for small in (True, False)
        )
        groups = tuple((_root(group), effective_dof(group)) for group in (few, rest) if group)
        return cls(value, _root(parts), effective_dof(parts), groups if len(groups) > 1 else ())

    def parts(self, times: float = 1.0) -> tuple[Part, ...]:
        """Return the independent parts that a multiple of the estimate contributes to another one."""
        return tuple((times * u, nu) for u, nu in self.groups or ((self.u, self.nu),))

    @property
    def k(self) -> float:
        """Coverage factor for 95 %."""
        return self.factor(LEVEL)

    @property
    def U(self) -> float:
        """Expanded uncertainty for 95 %."""
        return self.k * self.u if self.u else 0.0

    def factor(self, level: float) -> float:
        """Return the two-sided coverage factor for a level."""
        if not self.groups:
            return coverage_factor(self.nu, level)
        share = (self.groups[0][0] / self.u) ** 2
        return _factor(share, self.groups[0][1], self.groups[1][1], level)

    def p(self) -> float:
        """Return the two-sided p of the value against 0; 1 without uncertainty."""
        from scipy.special import ndtr, stdtr

        if not self.u:
            return 1.0
        t = abs(self.value) / self.u
        if not self.groups:
            return float(2 * (ndtr(-t) if math.isinf(self.nu) else stdtr(self.nu, -t)))
        inverse, weights = _spread_of(
            (self.groups[0][0] / self.u) ** 2, self.groups[0][1], self.groups[1][1]
        )
        # The weights add up to 1 but for round-off.
        return min(1.0, float(weights @ (2 * ndtr(-t * inverse))))


def _root(parts: Sequence[Part]) -> float:
    """Return the root of the sum of squared uncertainties."""
    return math.sqrt(math.fsum(u * u for u, _ in parts))


@lru_cache(maxsize=2**17)
def _factor(share: float, nu_few: float, nu_rest: float, level: float) -> float:
    """Return k of two groups by Halley's method, started from Welch and Satterthwaite's: each step
    triples the digits.

    share: fraction of u^2 that is due to the first group.
    """
    from scipy.special import ndtr

    inverse, weights = _spread_of(share, nu_few, nu_rest)
    k, change = coverage_factor(1 / (share**2 / nu_few + (1 - share) ** 2 / nu_rest), level), 1.0
    while abs(change) > 1e-4 * k:  # cubic convergence: the remaining error is about 1e-12
        deviates = k * inverse
        missing = level - float(weights @ (2 * ndtr(deviates) - 1))
        slope = weights * inverse * np.exp(-0.5 * deviates**2) * math.sqrt(2 / math.pi)
        density, bend = float(slope.sum()), -k * float(slope @ inverse**2)
        newton = missing / density
        change = newton / (1 + 0.5 * newton * bend / density)
        k += change
    return k


def _spread_of(share: float, nu_few: float, nu_rest: float) -> tuple[Array, Array]:
    """Return the distribution of error over u: a mixture of normals, as 1/(standard deviation) and
    weights.

    share: fraction of u^2 that is due to the first group. It is the posterior under the prior (s1
    s2)^-(1 + PRIOR) (s1^2 + s2^2)^(PRIOR/2) of the two groups' true uncertainties s, under which a
    group alone has Student's k.
    """
    few, w_few = _variances(nu_few, NODES[0])
    rest, w_rest = _variances(nu_rest, NODES[1])
    variance = (share * few[:, None] + (1 - share) * rest).ravel()
    weights = (w_few[:, None] * w_rest).ravel() * variance ** (PRIOR / 2)
    return 1 / np.sqrt(variance), weights / weights.sum()


@lru_cache(maxsize=256)
def _variances(nu: float, nodes: int) -> tuple[Array, Array]:
    """Return nu over chi^2 of nu + PRIOR degrees of freedom at the nodes of a quadrature, and their
    weights.

    The quadrature is over the fourth root of the probability, because the variance is large where
    that is small.
    """
    from scipy.special import gammaincinv

    if math.isinf(nu):
        return np.ones(1), np.ones(1)
    points, weights = _legendre(nodes)
    x = (points + 1) / 2
    return nu / (2 * gammaincinv((nu + PRIOR) / 2, x**4)), 2 * weights * x**3


@lru_cache(maxsize=2)
def _legendre(nodes: int) -> tuple[Array, Array]:
    """Return nodes in (-1, 1) and weights of a Gauss-Legendre quadrature."""
    points, weights = np.polynomial.legendre.leggauss(nodes)
    return points, weights
