"""Predictions and known facts of the conditions, as plain numbers for the session."""

import math
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from typing import Any

from rig.catalog.entries import Rig
from rig.drive.losses import loss_coefficients, over_first_principles
from rig.prediction.model import Prediction, predict_about
from rig.protocol.spec import Condition
from rig.stand.gas import LEAST_SHARE, share_of_weight
from rig.theory.total import AVERAGED_CYCLES

NOWHERE: Mapping[str, int] = {}
NO_REFILLS: Mapping[str, Sequence[float]] = {}


def predictions(
    conditions: Iterable[Condition], rig: Rig, workers: int, averaged: Mapping[str, int] = NOWHERE
) -> dict[str, tuple[Prediction, dict[str, Any]]]:
    """Return W_T of every condition by id: at the set acceleration, and as a table about it for
    interpolation.

    averaged : cycles over which rows without a period are averaged, for conditions that have their
        own number
    """
    wanted = tuple(conditions)
    with ThreadPoolExecutor(workers) as pool:
        found = pool.map(
            lambda c: predict_about(c, rig, averaged.get(c.id, AVERAGED_CYCLES)), wanted
        )
        return {condition.id: both for condition, both in zip(wanted, found, strict=True)}


def prediction_document(
    found: Mapping[str, tuple[Prediction, Mapping[str, Any]]],
    refills: Mapping[str, Sequence[float]] = NO_REFILLS,
) -> dict[str, Any]:
    """Return the predictions as plain numbers for the session; another model's numbers can replace
    them.

    refills : of conditions whose bed is refilled, energies of refilled beds divided by W_T
    """
    conditions = {}
    for name, (point, table) in found.items():
        entry: dict[str, Any] = {
            **table,
            "u_rel": point.u_rel,
            "u_levels": point.u_levels,
            "u_settling": point.u_settling,
            "u_stated": point.u_stated,
            "prediction": point.prediction,
            "shares_mechanism": point.shares_mechanism,
            "bound": _finite(point.bound),
            "period": point.period,
            "periodic_share": point.periodic_share,
        }
        if point.reasons.get("W_T"):
            entry["why"] = point.reasons["W_T"]
        # Refills tell of W_T only where it is of the bed itself.
        if refills.get(name) and point.shares_mechanism:
            entry["refills"] = list(refills[name])
        conditions[name] = entry
    return {"conditions": conditions}


def _finite(value: float) -> float | None:
    """Return None for infinity, which JSON does not have: an elastic single mass has no bound."""
    return value if math.isfinite(value) else None


def scene_facts(condition: Condition, point: Prediction) -> dict[str, Any]:
    """Return the data that identify a condition in reports and `rig model`: scene keys,
    SI units.
    """
    scene, drive = condition.scene, condition.drive
    return {
        "id": condition.id,
        "material": str(scene.grains.material),
        "density": scene.grains.density,
        "diameter": scene.grains.diameter,
        "fill": scene.grains.fill,
        **({} if scene.cavity.material is None else {"wall_material": str(scene.cavity.material)}),
        "bed": scene.bed,
        "axis": scene.axis,
        "drive": drive.mode,
        "frequency": drive.frequency,
        **({} if drive.sweep_to is None else {"sweep_to": drive.sweep_to}),
        "bed_mass": point.bed_mass,
        "box_mass": point.box_mass,
    }


def condition_facts(
    condition: Condition, rig: Rig, point: Prediction, rate: float
) -> dict[str, Any]:
    """Return the facts that the laboratory knows of a condition beforehand, for the session."""
    cavity, frequency = condition.scene.cavity, condition.drive.frequency
    coefficients = loss_coefficients(rig, cavity, frequency)
    return {
        **scene_facts(condition, point),
        "carried": point.carried,
        "acceleration_set": condition.drive.acceleration,
        "settle_cycles": condition.acquire.settle,
        "record_cycles": condition.acquire.record,
        "samples_per_cycle": rate / condition.drive.frequency,
        "gauge_mass": rig.gauge_mass,
        "moving_mass": rig.exciter.moving_mass,
        "losses": list(condition.scene.losses),
        "support": condition.scene.support,
        "over_first_principles": over_first_principles(coefficients, cavity, frequency),
        **({"loss_coefficients": coefficients} if None in (rig.loss_noise, rig.loss_air) else {}),
        "gas": _gas_facts(condition, rig),
        "dashpot_c": condition.scene.dashpot.c if condition.scene.bed == "dashpot" else None,
        **(_places(condition)),
    }


def _places(condition: Condition) -> dict[str, str]:
    """Return the ends of the stinger to which gauge and accelerometer are fixed; prescribed motion
    has no stinger.
    """
    drive = condition.drive
    return (
        {}
        if drive.mode == "prescribed"
        else {"gauge": drive.gauge, "accelerometer": drive.accelerometer}
    )


def _gas_facts(condition: Condition, rig: Rig) -> dict[str, Any] | None:
    """Return whether gas drag is switched on, and its largest ratio to the bed's weight; None if it
    is not listed.
    """
    if "gas" not in condition.scene.losses:
        return None
    share = share_of_weight(
        condition.scene, rig, condition.drive.acceleration, condition.drive.frequency
    )
    return {"on": share > LEAST_SHARE, "share_of_weight": share}


def model_row(condition: Condition, point: Prediction) -> dict[str, Any]:
    """Return one line of `rig model`."""
    return {
        **scene_facts(condition, point),
        "acceleration": condition.drive.acceleration,
        **asdict(point),
    } | {"bound": _finite(point.bound)}
