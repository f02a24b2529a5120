"""What a campaign has to compute, task by task: predictions of its conditions, then its runs."""

from collections.abc import Iterator
from dataclasses import dataclass

from rig.campaign.campaign import Campaign
from rig.campaign.one_run.part import Part, paced
from rig.prediction.forecast import Forecast, forecast
from rig.protocol.schedule import Run
from rig.protocol.spec import Condition
from rig.theory.total import AVERAGED_CYCLES


@dataclass(frozen=True)
class ToPredict:
    """The task of predicting a condition."""

    condition: Condition

    @property
    def name(self) -> str:
        """The condition's id."""
        return self.condition.id


def foreseen(campaign: Campaign, condition: Condition) -> Forecast:
    """Predict a condition as its campaign will repeat it."""
    cycles = campaign.averaged.get(condition.id, AVERAGED_CYCLES)
    return forecast(condition, campaign.rig, campaign.protocol.repeats.refill, cycles)


def computed(campaign: Campaign, speed: float | None, task: ToPredict | Run) -> Iterator[Forecast | Part]:
    """Compute a task: the forecast of a condition, or the parts of a run, held to `speed` (rig seconds per wall second,
    None: as fast as possible).

    Raises InputError, MemoryError, and Overrun after the part that came too late.
    """
    if isinstance(task, ToPredict):
        yield foreseen(campaign, task.condition)
    else:
        yield from paced(campaign.parts(task), campaign.lengths[task.condition.id].rate, speed)
