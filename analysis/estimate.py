"""A measured value with its standard uncertainty: what the analysis returns."""

import math
from dataclasses import dataclass

__all__ = ["Estimate", "coverage_factor", "effective_dof"]

LEVEL = 0.95  # coverage probability of every expanded uncertainty
UNBOUNDED = 1e6  # degrees of freedom beyond which nothing is told from infinity


def coverage_factor(nu: float, level: float = LEVEL) -> float:
    """Two-sided coverage factor k of Student's t at `nu` degrees of freedom (GUM G.3): 1.96 at infinity, 3.18 at 3."""
    from scipy.special import ndtri, stdtrit

    p = 0.5 + level / 2
    return float(ndtri(p)) if math.isinf(nu) else float(stdtrit(nu, p))


def effective_dof(parts: list[tuple[float, float]]) -> float:
    """Welch-Satterthwaite degrees of freedom (GUM eq. G.2b) of a sum with parts (standard uncertainty, nu).

    Infinite where no part with finite nu contributes.
    """
    total = math.fsum(u * u for u, _ in parts)
    if total == 0:
        return math.inf
    spread = math.fsum((u * u / total) ** 2 / nu for u, nu in parts if not math.isinf(nu))
    return math.inf if spread < 1 / UNBOUNDED else 1 / spread


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value, its standard uncertainty u (same unit) and the degrees of freedom nu of u (inf allowed)."""

    value: float
    u: float
    nu: float

    @property
    def k(self) -> float:
        """Coverage factor for 95 %."""
        return coverage_factor(self.nu)

    @property
    def U(self) -> float:
        """Expanded uncertainty for 95 %."""
        return self.k * self.u if self.u else 0.0
