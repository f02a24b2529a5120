"""Calibration of the emulated rig's losses, done once: from the ledger with ideal sensors, never by
a factor on W.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np

from analysis.comparison.offset_terms import Actual
from analysis.session.exciter import TrueInstruments, TrueState
from analysis.session.prediction import Curve
from analysis.uncertainty.budget import angle_uncertainty
from daq.chain.channel import ChannelState
from daq.chain.frontend import FILTER_DELAY
from rig.campaign.campaign import Campaign
from rig.campaign.one_run.prescribed_run import stand_of
from rig.campaign.one_run.run_inputs import motion_of
from rig.catalog.entries import Rig
from rig.catalog.rig_file import rig_with_losses
from rig.drive.losses import first_principles, quadratic_energy
from rig.drive.waveform import viscous_energy
from rig.errors import InputError, Mistake
from rig.prediction.document import predictions
from rig.protocol.schedule import Run
from rig.stand.exact_waveform import account_of, level, taken_by_bed


@dataclass(frozen=True)
class Account:
    """One run without noise and air, J per cycle.

    there : energy dissipated in bed, gas and mount
    predicted : W_T at the level reached
    noise, air : energy that unit coefficients of noise and air would dissipate
    """

    there: float
    predicted: float
    noise: float
    air: float


def calibrated(
    campaign: Campaign,
    target: float,
    workers: int,
    progress: Callable[[int, int], None] = lambda _done, _of: None,
) -> Rig:
    """Return the campaign's rig with `noise` and `air` such that sum W_exp / sum W_T = 1 + target,
    in equal parts.

    Gas and mount count with the bed if the protocol lists them. Raises InputError if a null test of
    the instruments would fail, if the protocol dissipates nothing, or if its beds already dissipate
    more than that. `progress` is called with the number of runs done and the total.
    """
    _check_nulls(campaign)
    accounts = _accounts(campaign, workers, progress)
    there, predicted, noise, air = (
        sum(getattr(account, name) for account in accounts)
        for name in ("there", "predicted", "noise", "air")
    )
    missing = (1.0 + target) * predicted - there
    if not predicted > 0.0 or missing < 0.0:
        raise InputError(
            Mistake(
                "--target",
                "",
                f"{target:g}; W_T sums to {predicted:.4g} J, {there:.4g} J are taken already",
                "a protocol that dissipates, and a target that leaves something for the losses",
            )
        )
    coefficients = {"noise": 0.5 * missing / noise, "air": 0.5 * missing / air}
    return rig_with_losses(
        campaign.rig,
        coefficients["noise"],
        coefficients["air"],
        _provenance(campaign, target, coefficients),
    )


def _true_state(state: ChannelState) -> TrueState:
    return TrueState(state.sensitivity, state.time_constant, state.gain, state.corner, state.skew)


def _check_nulls(campaign: Campaign) -> None:
    """Reject instruments with which a locked bed would not look like mass: their energies contain a
    phase error.

    The residual angle between the actual poles and the correction by the certified ones is compared
    with its expanded uncertainty.
    """
    tools, rate = campaign.instruments, campaign.lengths[campaign.conditions[0].id].rate
    info = {channel.name: channel for channel in tools.table(rate, FILTER_DELAY)}
    states = {
        channel.name: _true_state(state)
        for channel, state in zip(tools.channels, tools.states, strict=True)
    }
    actual = Actual(TrueInstruments(states["force"], states["acceleration"]), 0.0)
    for frequency in sorted({condition.drive.frequency for condition in campaign.conditions}):
        omega = 2.0 * np.pi * frequency
        force, acceleration = (
            actual.response(info[name], omega) for name in ("force", "acceleration")
        )
        angle = float(np.angle(force * acceleration.conjugate()))
        U = angle_uncertainty(info["force"], info["acceleration"], frequency).U
        if abs(angle) > U:
            raise InputError(
                Mistake(
                    "",
                    "acquire.sensors",
                    f"a null angle of {1e3 * angle:.3g} mrad at {frequency:g} Hz",
                    f"within its uncertainty of {1e3 * U:.3g} mrad: calibrate the sensors (another seed) first",
                )
            )


def _accounts(
    campaign: Campaign, workers: int, progress: Callable[[int, int], None]
) -> Sequence[Account]:
    tables = predictions(campaign.conditions, campaign.rig, workers, campaign.averaged)
    with ThreadPoolExecutor(workers) as pool:
        found = []
        try:
            for account in pool.map(
                lambda run: _account(campaign, run, tables[run.condition.id][1]), campaign.runs
            ):
                found.append(account)
                progress(len(found), len(campaign.runs))
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        return found


def _account(campaign: Campaign, run: Run, table: dict[str, Any]) -> Account:
    if table["W_T"] is None:
        found = f"no W_T in condition {run.condition.id}"
        raise InputError(Mistake("", "prediction", found, "a prediction that is stated in each"))
    motion = motion_of(campaign, run)
    account = account_of(stand_of(campaign, run), run.condition.acquire)
    return Account(
        there=taken_by_bed(account) + account["W_gas"] + account["W_mount"],
        predicted=Curve.of(table["acceleration"], table["W_T"])(level(motion)),
        noise=viscous_energy(1.0, motion),
        air=quadratic_energy(1.0, motion),
    )


def _provenance(campaign: Campaign, target: float, found: dict[str, float]) -> dict[str, Any]:
    """Return the origin of the coefficients, with first-principles values for comparison: effective
    values, no explanation.
    """
    condition = campaign.conditions[0]
    first = first_principles(condition.scene.cavity, condition.drive.frequency)
    return {
        "protocol": campaign.protocol.name,
        "seed": campaign.protocol.seed,
        "target": target,
        "runs": len(campaign.runs),
        "method": "equal shares of (1 + target) sum W_T - sum W_bed, from the ledger, ideal sensors",
        **{f"{name}_first_principles": value for name, value in first.items()},
        **{f"{name}_over_first_principles": found[name] / first[name] for name in found},
    }
