"""What is predicted of a condition before it is run: W_T about its level, and what refills do to it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rig.campaign.campaign import Campaign
from rig.prediction.document import has_level
from rig.prediction.model import Prediction, predict_about
from rig.prediction.refills import refill_ratios
from rig.protocol.spec import Condition
from rig.theory.total import AVERAGED_CYCLES


@dataclass(frozen=True)
class Forecast:
    """The prediction of one condition, which `condition` names.

    point: at the set level; table: W_T, W_f, W_c (J) at levels about it (m/s^2); refills: energies of poured beds over
    W_T, empty where the repeats share one bed
    """

    condition: str
    point: Prediction
    table: Mapping[str, Sequence[float]]
    refills: tuple[float, ...]
    ends: bool = True  # the one item of its task (rig.campaign.executor)


def forecast(campaign: Campaign, condition: Condition) -> Forecast:
    """Predict a condition of a campaign."""
    point, table = predict_about(condition, campaign.rig, campaign.averaged.get(condition.id, AVERAGED_CYCLES))
    poured = campaign.protocol.repeats.refill and has_level(condition)
    return Forecast(condition.id, point, table, refill_ratios(condition, campaign.rig, point.W_T) if poured else ())


def forecasts(campaign: Campaign) -> dict[str, Forecast]:
    """Predict all conditions, here and one after the other; by condition."""
    return {condition.id: forecast(campaign, condition) for condition in campaign.conditions}
