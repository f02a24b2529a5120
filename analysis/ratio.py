"""Numbers taken over several conditions: errors that are common to all of them stay common."""

import math
from collections import defaultdict
from collections.abc import Sequence

from analysis.conditions import Result
from analysis.estimate import Estimate
from analysis.recorded import Recorded
from analysis.uncertainty import combine

__all__ = ["energy_ratio", "propagated", "recorded_ratio"]


def energy_ratio(results: Sequence[Result]) -> Estimate | None:
    """Sum of W_exp over sum of W_T of the conditions with a W_T above 0; None where there is none."""
    told = [(r, r.W_T.value) for r in results if r.W_T is not None and r.W_T.value > 0]
    if not told:
        return None
    total = math.fsum(w for _, w in told)
    ratio = math.fsum(r.W_exp.value for r, _ in told) / total
    return propagated(ratio, [(r, 1 / total, -ratio / total) for r, _ in told])


def recorded_ratio(results: Sequence[Result]) -> Estimate | None:
    """As energy_ratio, with the predictions on the recorded waveforms; None where there are none."""
    told = [(r, r.recorded) for r in results if r.recorded is not None and r.recorded.W_T.value > 0]
    if not told:
        return None
    total = math.fsum(found.W_T.value for _, found in told)
    ratio = math.fsum(r.W_exp.value for r, _ in told) / total
    return propagated(ratio, [(found, 1 / total, -ratio / total) for _, found in told])


def propagated(value: float, weights: Sequence[tuple[Result | Recorded, float, float]]) -> Estimate:
    """Uncertainty of a number with derivatives (to W_exp, to W_T) for each condition.

    Lines of a source that is shared between conditions add with their signs; the others add in quadrature.
    """
    shared: dict[str, float] = defaultdict(float)
    nu: dict[str, float] = {}
    parts: list[tuple[float, float]] = []
    for result, d_exp, d_T in weights:
        for line in result.lines:
            part = d_exp * line.part + d_T * line.part_T
            if line.shared:
                shared[line.source] += part
                nu[line.source] = line.nu
            else:
                parts.append((part, line.nu))
    return combine(value, [*parts, *((part, nu[source]) for source, part in shared.items())])
