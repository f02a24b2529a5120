"""Looking ahead: what each condition asks of exciter, front end and disk, and what its repeats will be able to tell."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from analysis.session.prediction_entry import PredictionEntry
from analysis.session.protocol import ExpectedClaim
from analysis.uncertainty.budget import angle_uncertainty, certificate_lines, combine, noise_at, resolution_lines
from daq.chain.channel import ChannelInfo
from daq.chain.fir import OVERSAMPLING
from daq.chain.frontend import FILTER_DELAY
from daq.documents.classes import built
from rig.campaign.before.decisions import Decision, Expected, decisions
from rig.campaign.before.dry_run import Look, look_coupled, look_servo
from rig.campaign.campaign import Campaign
from rig.campaign.claim_cases import cases
from rig.campaign.tasks import foreseen
from rig.drive.exciter_limits import Demand
from rig.prediction.document import condition_facts, has_level, prediction_document
from rig.protocol.spec import Condition

Array = NDArray[np.float64]

PEAKS = ("peak", "buckling")
"""Uses of the exciter that are judged by the peak of the force, which rows that hit together raise."""

BYTES_PER_SAMPLE = 4
CONFIDENCE = 0.975

OFFSET = 0.07
"""Offset from W_T, relative, that the planned number of repeats should tell from none: the paper's."""

MOST_REPEATS = 100


@dataclass(frozen=True)
class Outlook:
    """One condition before it is run. Energies in J per cycle, W_exp and U as the repeats are expected to give them.

    exciter : shares of the exciter's limits, `Demand`
    side_by_side : the same with as many rows as lie side by side, where peaks of the rows that are run exceed a limit;
        None elsewhere
    range_force, range_acceleration : peak over the range of the channel
    stopped : what keeps the level from being reached in coupled drive, "" for nothing
    W_detect : below it nothing could be claimed; smallest_difference : between two conditions, 95 %
    repeats_needed : fewest repeats with which U is at most `OFFSET` of W_exp; None where no number up to 100 is enough
    expected : what the claims are judged on beforehand; None of a sweep
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
    W_T: float
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
        """Ratings of the exciter, fundamental, and of the front end that are exceeded; `peak` is a warning only, and a
        stinger buckles under as many rows as lie side by side, not under fewer that hit together."""
        held = {"peak"}
        if self.side_by_side is not None and self.side_by_side.buckling <= 1.0:
            held.add("buckling")
        return tuple(flag for name, flag in self._exceeded() if name not in held)

    @property
    def fails(self) -> tuple[str, ...]:
        """Of these what would fail the verdict of a run: a level that is not reached, a channel that overloads."""
        return tuple(flag for name, flag in self._exceeded() if name in ("level", "range"))

    def _exceeded(self) -> Iterator[tuple[str, str]]:
        """Limits that are exceeded, by name, and how to say it."""
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
    """The outlook of every condition, in order."""
    with ThreadPoolExecutor(workers) as pool:
        yield from pool.map(lambda condition: outlook(campaign, condition), campaign.conditions)


def decided(campaign: Campaign, outlooks: Sequence[Outlook]) -> list[Decision]:
    """What can be decided of each claim of the protocol."""
    expected = [one.expected for one in outlooks if one.expected is not None]
    channels = campaign.instruments.table(campaign.lengths[campaign.conditions[0].id].rate, FILTER_DELAY)
    claims = [built(ExpectedClaim, claim) for claim in cases(campaign.protocol, campaign.conditions)]
    return decisions(claims, expected, channels, campaign.protocol.repeats.n)


def disk(campaign: Campaign) -> int:
    """Bytes that the session's samples will take."""
    samples = sum(campaign.lengths[run.condition.id].samples for run in campaign.runs)
    return samples * BYTES_PER_SAMPLE * len(campaign.instruments.channels)


def outlook(campaign: Campaign, condition: Condition) -> Outlook:
    """Simulate a few cycles of a condition as set, without instruments, and plan its measurement."""
    rig, scene, drive = campaign.rig, condition.scene, condition.drive
    rate = campaign.lengths[condition.id].rate
    look = (look_coupled if drive.mode == "coupled" else look_servo)(campaign, condition, OVERSAMPLING * rate)
    channels = campaign.instruments.table(rate, FILTER_DELAY)
    reactive = np.pi * look.mass * (look.level / (2.0 * np.pi * drive.frequency)) ** 2
    ahead = foreseen(campaign, condition)
    point, refills = ahead.point, ahead.refills
    scatter = float(np.std(refills)) * point.W_T if refills else 0.0
    U, difference, needed = _plan(campaign, condition, channels, look, float(reactive), scatter)
    samples = round(condition.acquire.record * rate / drive.frequency)
    entry: PredictionEntry | None = None
    if has_level(condition):
        document = prediction_document({condition.id: (point, ahead.table)}, {condition.id: refills})
        entry = built(PredictionEntry, document["conditions"][condition.id])
    expected = Expected(
        condition_facts(condition, rig, point, rate), look.lost, look.mass, look.level, entry, samples, refills
    )
    return Outlook(
        id=condition.id,
        material=scene.grains.material,
        bed=scene.bed,
        diameter=scene.grains.diameter,
        fill=scene.grains.fill,
        frequency=drive.frequency,
        acceleration=drive.acceleration,
        samples_per_cycle=rate / drive.frequency,
        exciter=look.exciter,
        side_by_side=look.side_by_side,
        range_force=_range_use(channels[0], look.force),
        range_acceleration=_range_use(channels[1], look.acceleration),
        W_T=point.W_T,
        W_exp=look.lost,
        U_W_exp=U,
        W_detect=float(reactive) * angle_uncertainty(channels[0], channels[1], drive.frequency).U,
        smallest_difference=difference,
        repeats_needed=needed,
        seconds_per_cycle=look.seconds,
        stopped=look.stopped,
        expected=None if drive.sweep_to is not None else expected,
    )


def _plan(
    campaign: Campaign,
    condition: Condition,
    channels: tuple[ChannelInfo, ...],
    look: Look,
    reactive: float,
    s: float,
) -> tuple[float | None, float | None, int | None]:
    """Expected U of W_exp and smallest decidable difference of two conditions, J; None where one run shows no
    scatter. Repeats needed, see Outlook. s: standard deviation of W between refills, J."""
    n, W = campaign.protocol.repeats.n, look.lost
    frequency, rate = condition.drive.frequency, campaign.lengths[condition.id].rate
    force, acceleration = channels[:2]
    tops = float(np.hypot(look.mass * look.level, W * 4.0 * np.pi * frequency**2 / max(look.level, 1e-12))), look.level
    lines = (
        *certificate_lines(force, acceleration, frequency, W, reactive, amplitudes=tops),
        *resolution_lines(W, reactive),
    )
    certified = [(line.part, line.nu) for line in lines]
    samples = round(condition.acquire.record * rate / frequency)
    noise = noise_at(frequency, *tops, force, acceleration, samples, rate)

    def expected(repeats: int) -> float:
        """U with so many repeats; noise is part of their scatter."""
        nu = repeats - 1.0 if repeats > 1 else np.inf
        return combine(W, [*certified, (float(np.hypot(s, noise)) / np.sqrt(repeats), nu)]).U

    tried = range(2 if s > 0.0 else 1, MOST_REPEATS + 1 if expected(MOST_REPEATS) <= OFFSET * W else 0)
    needed = next((m for m in tried if expected(m) <= OFFSET * W), None)
    if n == 1 and s > 0.0:
        return None, None, needed
    factor = stdtrit(2.0 * (n - 1), CONFIDENCE) * np.sqrt(2.0 / n) if n > 1 else 0.0
    return expected(n), float(factor * np.hypot(s, noise)), needed


def _range_use(channel: ChannelInfo, peak: float) -> float:
    return peak * channel.sensitivity / channel.range_V
