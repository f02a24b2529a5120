"""Forecast of a condition before it is run: W_T about its level, and its variation
between refills.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rig.catalog.entries import Rig
from rig.prediction.model import Prediction, predict_about
from rig.prediction.refills import refill_ratios
from rig.protocol.spec import Condition
from rig.theory.total import AVERAGED_CYCLES

__all__ = ["Forecast", "forecast"]


@dataclass(frozen=True)
class Forecast:
    """The prediction of one condition, which `condition` names.

    point : at the set level
    table : plain numbers at levels about it (`predict_about`)
    refills : energies of refilled beds divided by the bed's own prediction, empty if the repeats
        share one bed
    """

    condition: str
    point: Prediction
    table: Mapping[str, Any]
    refills: tuple[float, ...]
    ends: bool = True  # the one item of its task (rig.campaign.executor)


def forecast(condition: Condition, rig: Rig, refill: bool, cycles: int | None = None) -> Forecast:
    """Predict a condition.

    refill : whether every repeat has a refill of its own
    cycles : averaged for rows without a period, if that was chosen
    """
    point, table = predict_about(condition, rig, cycles or AVERAGED_CYCLES)
    ratios: tuple[float, ...] = ()
    if refill and condition.has_level and point.W_own is not None:
        ratios = refill_ratios(condition, rig, point.W_own)
    return Forecast(condition.id, point, table, ratios)
