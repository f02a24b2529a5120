"""Uncertainty of W_T due to the model's unmeasured parameters: Monte Carlo over friction,
restitution and clearance.

None of them was measured for these grains: the ranges are stated here, rectangular and independent
of each other (GUM Supplement 1). They matter if the record does not come from this model; a
simulated bed `layers` shares the parameters.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from daq.random_streams import stream
from rig.beds.janssen_stack import nominal
from rig.catalog.entries import Rig
from rig.errors import InputError
from rig.prediction.own import total_of
from rig.protocol.spec import Condition

DRAWS = 100
SEED = 1
"""One seed for all conditions: a draw is one possible truth, common to all of them."""


@dataclass(frozen=True)
class Stated:
    """The assumed range of a parameter, with its reason."""

    low: float
    high: float
    reason: str


STATED: Mapping[str, Stated] = {
    "grain_friction": Stated(0.15, 0.5, "mu_p, smooth steel to angular oxide"),
    "wall_friction": Stated(0.2, 0.6, "mu_s, grains on steel"),
    "janssen_ratio": Stated(0.5, 0.9, "K_p, 0.7 within 0.2"),
    "restitution_grains": Stated(0.8, 0.98, "e, 0.9 within 0.1, below 1"),
    "restitution_wall": Stated(0.65, 0.85, "e0, 0.75 within 0.1"),
    "clearance": Stated(0.1, 1.25, "c, from a tenth of the paper's own distance to beyond it"),
}


def model_ratios(condition: Condition, rig: Rig, draws: int = DRAWS) -> tuple[float, ...] | None:
    """Return W_T divided by the nominal W_T at the set level for each draw of `STATED`; None if W_T
    is 0 or a draw cannot be followed.
    """
    scene, drive = condition.scene, condition.drive
    point = total_of(scene, rig, nominal(scene, rig), drive.acceleration, drive.frequency).total
    if not point > 0.0:
        return None
    ratios = []
    for values in drawn(draws):
        clearance = values.pop("clearance")
        other = replace(scene, layers=replace(scene.layers, clearance=clearance))
        chosen = replace(rig, **dict[str, Any](values))
        try:
            total = total_of(
                other, chosen, nominal(other, chosen), drive.acceleration, drive.frequency
            ).total
        except InputError:
            return None
        ratios.append(total / point)
    return tuple(ratios)


def drawn(draws: int) -> list[dict[str, float]]:
    """Return the parameters of each draw, by name."""
    u = stream(SEED, "model").random((draws, len(STATED)))
    low = np.array([stated.low for stated in STATED.values()])
    high = np.array([stated.high for stated in STATED.values()])
    return [dict(zip(STATED, row.tolist(), strict=True)) for row in low + (high - low) * u]
