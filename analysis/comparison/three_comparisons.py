"""Three comparisons that answer different questions, never mixed: chain, prediction, model.

chain: W_exp against the simulation's own ledger; tests the instruments and the analysis. prediction: against W_T as the
model gives it, uncertain by level and numerics. model: against W_T as uncertain as what nobody measured makes it; only
where the record does not come from the model itself.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from analysis.results.condition import Result
from analysis.uncertainty.estimate import Estimate

__all__ = ["comparisons", "model_row"]

INSIDE = (0.025, 0.975)
SEVEN = 0.07  # the offset that the paper reports


def model_row(result: Result) -> dict[str, float | None]:
    """The report's entry: 95 % interval of W_T over the model's parameters, J, and E_n with half its width as U_T."""
    if result.W_T is None or result.difference is None or not result.model:
        return dict.fromkeys(("W_T_low", "W_T_high", "E_n_model"))
    low, high = (result.W_T.value * float(q) for q in np.quantile(result.model, INSIDE))
    U = math.hypot(result.difference.U, (high - low) / 2)
    return {"W_T_low": low, "W_T_high": high, "E_n_model": result.difference.value / U if U else None}


def comparisons(results: Sequence[Result]) -> list[dict[str, Any]]:
    """One entry for each: what with, of how many conditions, in how many |E_n| <= 1, and why it was not made or what it
    cannot tell."""
    model = [(result, row["E_n_model"]) for result in results if (row := model_row(result))["E_n_model"] is not None]
    none = "" if results else "no run states an energy"
    return [
        _entry(
            "chain", "the rig's own ledger", _scores([r.chain for r in results]), none or "the record holds no truth"
        ),
        _entry(
            "prediction", "W_T as predicted", _scores([r.difference for r in results if r.comparable]),
            none or "nothing is predicted that stands out of the detection limit",
        ),
        _entry(
            "model", "W_T with friction, restitution and play as uncertain as they are", [E for _, E in model],
            none or "the record comes from the model itself, or no spread of W_T was given",
        ) | ({"why": _telling([result for result, _ in model])} if model else {}),
    ]  # fmt: skip


def _scores(differences: Sequence[Estimate | None]) -> list[float]:
    return [d.value / d.U for d in differences if d is not None and d.U]


def _entry(name: str, against: str, scores: Sequence[float], why: str) -> dict[str, Any]:
    return {
        "comparison": name, "against": against, "n": len(scores), "within": sum(abs(E) <= 1 for E in scores),
        "why": "" if scores else f"not made: {why}",
    }  # fmt: skip


def _telling(results: Sequence[Result]) -> str:
    """Which offset the model comparison could tell; a draw of the parameters is the same in all conditions."""
    W_T = np.array([result.W_T.value for result in results if result.W_T is not None])
    total = W_T @ np.array([result.model for result in results]) / W_T.sum()
    low, high = (float(q) - 1 for q in np.quantile(total, INSIDE))
    text = f"what nobody measured leaves W_T open from {100 * low:+.0f} % to {100 * high:+.0f} % (95 %)"
    if (high - low) / 2 > SEVEN:
        return f"{text}: 7 % cannot test this model without measured friction"
    return text
