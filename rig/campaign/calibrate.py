"""Setting the emulated rig's losses, once: from the ledger with ideal sensors, never from a factor on W."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from analysis.prediction import Curve
from rig.campaign.setup import Campaign
from rig.catalog import rig_with_losses
from rig.catalog.entries import Rig
from rig.errors import InputError, Mistake
from rig.ledger import COLUMNS
from rig.losses import drag_of_box, quadratic_energy, sound_of_box, viscous_energy
from rig.plan import Run, predictions
from rig.stand import CHUNK_CYCLES

IN_BED = ("W_f", "W_c", "W_viscous", "dKE_bed")


@dataclass(frozen=True)
class Account:
    """One run without parasitic losses, J per cycle: what the bed took, W_T at the level reached, and what unit
    coefficients of noise and air would take."""

    bed: float
    predicted: float
    noise: float
    air: float


def calibrated(campaign: Campaign, target: float, workers: int) -> Rig:
    """The campaign's rig with `noise` and `air` set in equal shares so that sum W_exp / sum W_T = 1 + target.

    Raises InputError where the protocol dissipates nothing or its beds already take more than that.
    """
    accounts = _accounts(campaign, workers)
    bed, predicted, noise, air = (
        sum(getattr(account, name) for account in accounts) for name in ("bed", "predicted", "noise", "air")
    )
    missing = (1.0 + target) * predicted - bed
    if not predicted > 0.0 or missing < 0.0:
        raise InputError(
            Mistake("--target", "", f"{target:g}, where W_T sums to {predicted:.4g} J and the beds take {bed:.4g} J",
                    "a protocol that dissipates, and a target that leaves something for the losses")
        )  # fmt: skip
    coefficients = {"noise": 0.5 * missing / noise, "air": 0.5 * missing / air}
    return rig_with_losses(
        campaign.rig, coefficients["noise"], coefficients["air"], _provenance(campaign, target, coefficients)
    )


def _accounts(campaign: Campaign, workers: int) -> Sequence[Account]:
    tables = predictions(campaign.conditions, campaign.rig, workers)
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(lambda run: _account(campaign, run, tables[run.condition.id][1]), campaign.runs))


def _account(campaign: Campaign, run: Run, table: dict[str, list[float]]) -> Account:
    acquire, motion = run.condition.acquire, campaign.motion(run)
    stand = campaign.stand(run)
    cycles = acquire.settle + acquire.record
    for _ in range(-(-cycles // CHUNK_CYCLES)):
        stand.advance()
    means = stand.drain_ledger()[acquire.settle : cycles].mean(axis=0)
    level = motion.acceleration * float(np.hypot(motion.sine[0], motion.cosine[0]))
    return Account(
        bed=float(sum(means[COLUMNS.index(name)] for name in IN_BED)),
        predicted=Curve.of(table["acceleration"], table["W_T"])(level),
        noise=viscous_energy(1.0, motion),
        air=quadratic_energy(1.0, motion),
    )


def _provenance(campaign: Campaign, target: float, found: dict[str, float]) -> dict[str, Any]:
    """How the coefficients came about, beside their first-principles sizes: they are effective values, not air."""
    cavity = campaign.conditions[0].scene.cavity
    height, width, length = (side + 2.0 * cavity.wall for side in (cavity.height, cavity.width, cavity.length))
    omega = 2.0 * np.pi * campaign.conditions[0].drive.frequency
    first = {"noise": sound_of_box(height, width, length, omega), "air": drag_of_box(height, width)}
    return {
        "protocol": campaign.protocol.name,
        "seed": campaign.protocol.seed,
        "target": target,
        "runs": len(campaign.runs),
        "method": "equal shares of (1 + target) sum W_T - sum W_bed, from the ledger, ideal sensors",
        **{f"{name}_first_principles": value for name, value in first.items()},
        **{f"{name}_over_first_principles": found[name] / first[name] for name in found},
    }
