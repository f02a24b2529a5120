"""Preflight of each condition: requirements on exciter, front end and disk, and the resolving power
of its repeats.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from analysis.session.prediction_entry import PredictionEntry
from analysis.session.protocol import ExpectedClaim
from analysis.uncertainty.budget import (
    angle_uncertainty,
    certificate_lines,
    combine,
    noise_at,
    resolution_lines,
)
from daq.chain.channel import ChannelInfo
from daq.chain.fir import OVERSAMPLING
from daq.chain.frontend import FILTER_DELAY
from daq.documents.classes import built
from rig.campaign.campaign import Campaign
from rig.campaign.claim_cases import cases
from rig.campaign.preflight.decisions import Decision, Expected, decisions
from rig.campaign.preflight.dry_run import DryRun, dry_run_coupled, dry_run_prescribed
from rig.drive.exciter_limits import Demand
from rig.prediction.document import condition_facts, prediction_document
from rig.prediction.forecast import forecast
from rig.protocol.spec import Condition

Array = NDArray[np.float64]

PEAKS = ("peak", "buckling")
"""Utilisations judged by the peak of the force, which rows that hit simultaneously raise."""

BYTES_PER_SAMPLE = 4
CONFIDENCE = 0.975

OFFSET = 0.07
"""Relative offset from W_T that the planned number of repeats should resolve: the paper's."""

MOST_REPEATS = 100


@dataclass(frozen=True)
class Outlook:
    """One condition before it is run. Energies in J per cycle; W_exp and U as expected from the
    repeats.

    exciter : utilisation of the exciter's limits, `Demand`
    side_by_side : the same with as many rows as lie side by side, if peaks of the simulated rows
        exceed a limit; else None
    range_force, range_acceleration : peak as a fraction of the channel's range
    stopped : reason why the level is not reached in shaker-coupled drive, "" for none
    W_detect : detection limit of W
    smallest_difference : resolvable difference between two conditions, 95 %
    repeats_needed : fewest repeats with which U is at most `OFFSET` of W_exp; None if no number up
        to 100 is enough
    expected : input of the claims' forecast; None for a sweep
    """

    id: str
    material: str
    bed: str
    diameter: float
    fill: float
    frequency: float
    acceleration: float
    samples_per_cycle: float
    exciter: Demand
    side_by_side: Demand | None
    range_force: float
    range_acceleration: float
    W_T: float | None
    W_exp: float
    U_W_exp: float | None
    W_detect: float
    smallest_difference: float | None
    repeats_needed: int | None
    seconds_per_cycle: float
    stopped: str = ""
    expected: Expected | None = None

    @property
    def flags(self) -> tuple[str, ...]:
        """Limits that the condition exceeds."""
        return tuple(flag for _, flag in self._exceeded())

    @property
    def beyond(self) -> tuple[str, ...]:
        """Exceeded ratings of exciter (fundamental) and front end.

        `peak` is a warning only. A stinger is judged for buckling with as many rows as lie side by
        side, not with fewer that hit simultaneously.
        """
        held = {"peak"}
        if self.side_by_side is not None and self.side_by_side.buckling <= 1.0:
            held.add("buckling")
        return tuple(flag for name, flag in self._exceeded() if name not in held)

    @property
    def fails(self) -> tuple[str, ...]:
        """Those of them that would fail the verdict of a run: a level that is not reached, a
        channel that overloads.
        """
        return tuple(flag for name, flag in self._exceeded() if name in ("level", "range"))

    def _exceeded(self) -> Iterator[tuple[str, str]]:
        """Yield the exceeded limits: name and text."""
        if self.stopped:
            yield "level", f"the level is not reached: {self.stopped}"
        for name, share in asdict(self.exciter).items():
            if share > 1.0:
                yield name, f"exciter {name} {share:.2f} of its limit{self._with_all_rows(name)}"
        for name, share in (("force", self.range_force), ("acceleration", self.range_acceleration)):
            if share > 1.0:
                yield "range", f"{name} range {share:.2f} of its limit"

    def _with_all_rows(self, name: str) -> str:
        if self.side_by_side is None or name not in PEAKS:
            return ""
        return f"; {asdict(self.side_by_side)[name]:.2f} with as many rows as lie side by side"


def preflight(campaign: Campaign, workers: int) -> Iterator[Outlook]:
    """Yield the outlook of every condition, in order."""
    with ThreadPoolExecutor(workers) as pool:
        yield from pool.map(lambda condition: outlook(campaign, condition), campaign.conditions)


def decided(campaign: Campaign, outlooks: Sequence[Outlook]) -> list[Decision]:
    """Return the forecast of each claim of the protocol."""
    expected = [one.expected for one in outlooks if one.expected is not None]
    channels = campaign.instruments.table(
        campaign.lengths[campaign.conditions[0].id].rate, FILTER_DELAY
    )
    claims = [
        built(ExpectedClaim, claim) for claim in cases(campaign.protocol, campaign.conditions)
    ]
    return decisions(claims, expected, channels, campaign.protocol.repeats.n)


def disk(campaign: Campaign) -> int:
    """Return the size of the session's samples in bytes."""
    samples = sum(campaign.lengths[run.condition.id].samples for run in campaign.runs)
    return samples * BYTES_PER_SAMPLE * len(campaign.instruments.channels)


def outlook(campaign: Campaign, condition: Condition) -> Outlook:
    """Simulate a few cycles of a condition as set, without instruments, and plan its
    measurement.
    """
    rig, scene, drive = campaign.rig, condition.scene, condition.drive
    rate = campaign.lengths[condition.id].rate
    dry = (dry_run_coupled if drive.mode == "shaker" else dry_run_prescribed)(
        campaign, condition, OVERSAMPLING * rate
    )
    channels = campaign.instruments.table(rate, FILTER_DELAY)
    reactive = np.pi * dry.mass * (dry.level / (2.0 * np.pi * drive.frequency)) ** 2
    ahead = forecast(
        condition, rig, campaign.protocol.repeats.refill, campaign.averaged.get(condition.id)
    )
    point, refills = ahead.point, ahead.refills
    scatter = float(np.std(refills)) * (point.W_own or 0.0) if refills else 0.0
    U, difference, needed = _plan(campaign, condition, channels, dry, float(reactive), scatter)
    samples = round(condition.acquire.record * rate / drive.frequency)
    entry: PredictionEntry | None = None
    if condition.has_level:
        document = prediction_document(
            {condition.id: (point, ahead.table)}, {condition.id: refills}
        )
        entry = built(PredictionEntry, document["conditions"][condition.id])
    expected = Expected(
        condition_facts(condition, rig, point, rate),
        dry.lost,
        dry.mass,
        dry.level,
        entry,
        samples,
        refills,
        point.W_own or 0.0,
    )
    return Outlook(
        id=condition.id,
        material=str(scene.grains.material),
        bed=scene.bed,
        diameter=scene.grains.diameter,
        fill=scene.grains.fill,
        frequency=drive.frequency,
        acceleration=drive.acceleration,
        samples_per_cycle=rate / drive.frequency,
        exciter=dry.exciter,
        side_by_side=dry.side_by_side,
        range_force=_range_use(channels[0], dry.force),
        range_acceleration=_range_use(channels[1], dry.acceleration),
        W_T=point.W_T,
        W_exp=dry.lost,
        U_W_exp=U,
        W_detect=float(reactive) * angle_uncertainty(channels[0], channels[1], drive.frequency).U,
        smallest_difference=difference,
        repeats_needed=needed,
        seconds_per_cycle=dry.seconds,
        stopped=dry.stopped,
        expected=None if drive.sweep_to is not None else expected,
    )


def _plan(
    campaign: Campaign,
    condition: Condition,
    channels: tuple[ChannelInfo, ...],
    dry: DryRun,
    reactive: float,
    s: float,
) -> tuple[float | None, float | None, int | None]:
    """Return expected U of W_exp and smallest resolvable difference of two conditions, J, and
    repeats needed (see Outlook).

    The first two are None if one run shows no scatter. s : standard deviation of W between refills,
    J
    """
    n, W = campaign.protocol.repeats.n, dry.lost
    frequency, rate = condition.drive.frequency, campaign.lengths[condition.id].rate
    force, acceleration = channels[:2]
    # Amplitudes of force and acceleration: the force has a part in phase (mass) and one in
    # quadrature (W).
    tops = (
        float(
            np.hypot(dry.mass * dry.level, W * 4.0 * np.pi * frequency**2 / max(dry.level, 1e-12))
        ),
        dry.level,
    )
    lines = (
        *certificate_lines(force, acceleration, frequency, W, reactive, amplitudes=tops),
        *resolution_lines(W, reactive),
    )
    certified = [(line.part, line.nu) for line in lines]
    samples = round(condition.acquire.record * rate / frequency)
    noise = noise_at(frequency, *tops, force, acceleration, samples, rate)

    def expected(repeats: int) -> float:
        """Return U with `repeats` repeats; noise is part of their scatter."""
        nu = repeats - 1.0 if repeats > 1 else np.inf
        return combine(W, [*certified, (float(np.hypot(s, noise)) / np.sqrt(repeats), nu)]).U

    tried = range(
        2 if s > 0.0 else 1, MOST_REPEATS + 1 if expected(MOST_REPEATS) <= OFFSET * W else 0
    )
    needed = next((m for m in tried if expected(m) <= OFFSET * W), None)
    if n == 1 and s > 0.0:
        return None, None, needed
    factor = stdtrit(2.0 * (n - 1), CONFIDENCE) * np.sqrt(2.0 / n) if n > 1 else 0.0
    return expected(n), float(factor * np.hypot(s, noise)), needed


def _range_use(channel: ChannelInfo, peak: float) -> float:
    return peak * channel.sensitivity / channel.range_V
