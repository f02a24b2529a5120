"""What intervals hold of drawn sessions: each judged by the coverage factor at its own share."""

import numpy as np
import pytest

from analysis.comparison.refills import SESSIONS, held
from analysis.uncertainty.budget import CERTIFICATE_NU
from analysis.uncertainty.estimate import Estimate
from analysis.uncertainty.skewed_scatter import SEED, sessions_of


@pytest.mark.parametrize("certified", [1e-4, 0.01, 0.2])
@pytest.mark.parametrize("n", [2, 4, 8, 128])
def test_every_session_is_judged_by_its_own_factor(n: int, certified: float) -> None:
    """At 128 refills the factor falls and rises again with the refills' share of the uncertainty;
    at 2 it grows sixfold. Some errors lie between the least and the largest factor, others do not.
    """
    refills = 1 - np.random.default_rng(n).gamma(1.0, 0.05, 100)
    factors = (1.4, 1.0)
    error, scatter = sessions_of(refills, n, SESSIONS)
    error += certified * np.random.default_rng(SEED).standard_normal(SESSIONS)
    shares = np.linspace(0.0, 1.0, 17)
    k = [
        Estimate.of(0.0, ((s**0.5, n - 1.0), ((1.0 - s) ** 0.5, CERTIFICATE_NU))).k for s in shares
    ]
    for factor, share in zip(factors, held(refills, certified, n, factors), strict=True):
        own = (factor * scatter) ** 2
        U = np.interp(own / (own + certified**2), shares, k) * np.sqrt(own + certified**2)
        assert share == np.mean(np.abs(error) <= U)


def test_drawn_sessions_have_the_moments_of_their_refills() -> None:
    """The error of a mean of n refills, and n - 1 degrees of freedom of its variance; 4000 sessions
    give the variance of the error to sqrt(2/4000) = 2.2 %: four of them.
    """
    refills = np.random.default_rng(1).standard_normal(300)
    error, u = sessions_of(refills, 5, 4000)
    assert np.mean(error**2) == pytest.approx(refills.var() / 5, rel=0.09)
    assert np.mean(u**2) == pytest.approx(refills.var() / 5, rel=0.09)
