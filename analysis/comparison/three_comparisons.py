"""Three comparisons that answer different questions, never mixed: chain, prediction, model.

chain: W_exp against the simulation's own ledger; tests the instruments and the analysis.
prediction: against W_T as the model gives it, uncertain by level and numerics. model: against W_T
as uncertain as what nobody measured makes it; only where the record does not come from the model
itself.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from analysis.results.agreement_row import ComparisonRow
from analysis.results.condition import Result
from analysis.uncertainty.estimate import Estimate

__all__ = ["ModelTold", "comparisons", "model_row"]

INSIDE = (0.025, 0.975)
SEVEN = 0.07  # the offset that the paper reports


@dataclass(frozen=True, slots=True)
class ModelTold:
    """95 % interval of W_T over the model's parameters, J, and E_n with half its width as U_T."""

    W_T_low: float | None = None
    W_T_high: float | None = None
    E_n_model: float | None = None


def model_row(result: Result) -> ModelTold:
    """What the report says of a condition against W_T as uncertain as what nobody measured makes
    it.
    """
    if result.W_T is None or result.difference is None or not result.model:
        return ModelTold()
    low, high = (result.W_T.value * float(q) for q in np.quantile(result.model, INSIDE))
    U = math.hypot(result.difference.U, (high - low) / 2)
    return ModelTold(low, high, result.difference.value / U if U else None)


def comparisons(results: Sequence[Result]) -> tuple[ComparisonRow, ...]:
    """One entry for each: what with, of how many conditions, in how many |E_n| <= 1, and why it was
    not made or what it cannot tell."""
    scored = [(result, model_row(result).E_n_model) for result in results]
    model = [(result, E) for result, E in scored if E is not None]
    none = "" if results else "no run states an energy"
    last = _entry(
        "model",
        "W_T with friction, restitution and clearance as uncertain as they are",
        [E for _, E in model],
        none or "the record comes from the model itself, or no spread of W_T was given",
    )
    return (
        _entry(
            "chain",
            "the rig's own ledger",
            _scores([r.chain for r in results]),
            none or "the record holds no truth",
        ),
        _entry(
            "prediction",
            "W_T as predicted",
            _scores([r.difference for r in results if r.comparable]),
            none or "nothing is predicted that stands out of the detection limit",
        ),
        replace(last, why=_telling([result for result, _ in model])) if model else last,
    )


def _scores(differences: Sequence[Estimate | None]) -> list[float]:
    return [d.value / d.U for d in differences if d is not None and d.U]


def _entry(name: str, against: str, scores: Sequence[float], why: str) -> ComparisonRow:
    return ComparisonRow(
        comparison=name, against=against, n=len(scores), within=sum(abs(E) <= 1 for E in scores),
        why="" if scores else f"not made: {why}",
    )  # fmt: skip


def _telling(results: Sequence[Result]) -> str:
    """Which offset the model comparison could tell; a draw of the parameters is the same in all
    conditions.
    """
    W_T = np.array([result.W_T.value for result in results if result.W_T is not None])
    total = W_T @ np.array([result.model for result in results]) / W_T.sum()
    low, high = (float(q) - 1 for q in np.quantile(total, INSIDE))
    text = f"what nobody measured leaves W_T open from {100 * low:+.0f} % to {100 * high:+.0f} % (95 %)"
    if (high - low) / 2 > SEVEN:
        return f"{text}: 7 % cannot test this model without measured friction"
    return text
