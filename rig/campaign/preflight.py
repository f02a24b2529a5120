"""Looking ahead: what each condition asks of exciter, front end and disk, and what its repeats will be able to tell."""

import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from analysis.uncertainty import angle_uncertainty, certificate_lines, combine, noise_at, resolution_lines
from daq.channel import ChannelInfo
from daq.fir import OVERSAMPLING
from daq.frontend import FILTER_DELAY
from daq.seeds import stream
from rig.beds.stack import nominal, refill
from rig.campaign.dwelling import STOPS, Dwelling
from rig.campaign.setup import PASS_BAND, Campaign
from rig.drive.dwell import phasors
from rig.drive.exciter import Demand, demand
from rig.drive.waveform import Waveform
from rig.ledger import COLUMNS, IN_BED
from rig.losses import LOST
from rig.model import predict, total_of
from rig.scene import Condition
from rig.stand import Stand
from rig.theory.total import AVERAGED_CYCLES

Array = NDArray[np.float64]

AHEAD = 8
"""Chunks of cycles simulated of each condition: the last one stands for the steady state."""

HELD = 16
"""Cycles simulated in coupled drive once the level is held: the last half counts."""

POURINGS = 8
"""Refills whose W_T is computed to expect the scatter between repeats."""

BYTES_PER_SAMPLE = 4
CONFIDENCE = 0.975

OFFSET = 0.07
"""Offset from W_T, relative, that the planned number of repeats should tell from none: the paper's."""

MOST_REPEATS = 100


@dataclass(frozen=True)
class Outlook:
    """One condition before it is run. Energies in J per cycle, W_exp and U as the repeats are expected to give them.

    exciter : shares of the exciter's limits, `Demand`
    range_force, range_acceleration : peak over the range of the channel
    stopped : what keeps the level from being reached in coupled drive, "" for nothing
    W_detect : below it nothing could be claimed; smallest_difference : between two conditions, 95 %
    repeats_needed : fewest repeats with which U is at most `OFFSET` of W_exp; None where no number up to 100 is enough
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

    @property
    def flags(self) -> tuple[str, ...]:
        """Limits that the condition exceeds."""
        used = {f"exciter {name}": share for name, share in asdict(self.exciter).items()}
        used |= {"force range": self.range_force, "acceleration range": self.range_acceleration}
        stopped = (f"the level is not reached: {self.stopped}",) if self.stopped else ()
        return (*stopped, *(f"{name} {share:.2f} of its limit" for name, share in used.items() if share > 1.0))

    @property
    def beyond(self) -> tuple[str, ...]:
        """Ratings of the exciter, fundamental, and of the front end that are exceeded; `peak` is a warning only."""
        return tuple(flag for flag in self.flags if not flag.startswith("exciter peak"))


def preflight(campaign: Campaign, workers: int) -> Iterator[Outlook]:
    """The outlook of every condition, in order."""
    with ThreadPoolExecutor(workers) as pool:
        yield from pool.map(lambda condition: outlook(campaign, condition), campaign.conditions)


def disk(campaign: Campaign) -> int:
    """Bytes that the session's samples will take."""
    samples = sum(campaign.lengths[run.condition.id].samples for run in campaign.runs)
    return samples * BYTES_PER_SAMPLE * len(campaign.instruments.channels)


@dataclass(frozen=True)
class Look:
    """A condition as simulated without instruments: use of the exciter, J per cycle that are taken, level reached in
    m/s^2, apparent mass in kg, peaks of force (N) and acceleration (m/s^2), wall seconds per cycle, and what keeps the
    level from being reached ("" for nothing)."""

    exciter: Demand
    lost: float
    level: float
    mass: float
    force: float
    acceleration: float
    seconds: float
    stopped: str = ""


def outlook(campaign: Campaign, condition: Condition) -> Outlook:
    """Simulate a few cycles of a condition as set, without instruments, and plan its measurement."""
    rig, scene, drive = campaign.rig, condition.scene, condition.drive
    rate = campaign.lengths[condition.id].rate
    look = (look_coupled if drive.mode == "coupled" else look_servo)(campaign, condition, OVERSAMPLING * rate)
    channels = campaign.instruments.table(rate, FILTER_DELAY)
    reactive = np.pi * look.mass * (look.level / (2.0 * np.pi * drive.frequency)) ** 2
    point = predict(condition, rig, campaign.averaged.get(condition.id, AVERAGED_CYCLES))
    U, difference, needed = _plan(campaign, condition, channels, look, float(reactive))
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
    )


def look_servo(campaign: Campaign, condition: Condition, rate: float) -> Look:
    """The programmed motion, exact; the exciter solved backwards."""
    rig, scene, drive = campaign.rig, condition.scene, condition.drive
    motion = Waveform(drive.frequency, drive.acceleration)
    started = time.perf_counter()
    stand = Stand(scene, rig, motion, nominal(scene, rig), rate)
    for _ in range(AHEAD):
        stand.advance()
    seconds = time.perf_counter() - started
    rows = stand.drain_ledger()
    use = demand(rig.exciter, stand.latest_force, stand.rate, motion, PASS_BAND * rate / OVERSAMPLING)
    return Look(
        exciter=use,
        lost=_lost(rows[2 * len(rows) // 3 :]),
        level=drive.acceleration,
        mass=apparent_mass(stand, motion),
        force=use.peak * rig.exciter.force_peak + stand.weight,
        acceleration=drive.acceleration,
        seconds=seconds / len(rows),
    )


def look_coupled(campaign: Campaign, condition: Condition, rate: float) -> Look:
    """The dwell with the nominal bed, until its level is held, and some cycles more."""
    rig, frequency = campaign.rig, condition.drive.frequency
    started = time.perf_counter()
    dwelling = Dwelling(condition, rig, nominal(condition.scene, rig), rate)
    cycles = 0
    while dwelling.dwell.steady_from is None or cycles < dwelling.dwell.steady_from:
        cycles += 1
        dwelling.stand.read(round(cycles * rate / frequency) - round((cycles - 1) * rate / frequency))
        dwelling.ledger()
    signals = dwelling.stand.read(round(HELD * rate / frequency))
    rows = dwelling.ledger()[:HELD]
    seconds = (time.perf_counter() - started) / (cycles + HELD)
    last = signals[:2, -round(HELD // 2 * rate / frequency) :]
    force, acceleration = (phasors(row, 0, rate, frequency, 1)[0] for row in last)
    recorded = _within(last, rate, PASS_BAND * rate / OVERSAMPLING)
    scalars = dwelling.scalars()
    level = abs(acceleration)
    return Look(
        exciter=dwelling.demand,
        lost=_lost(rows[HELD // 2 :]),
        level=level,
        mass=(force * acceleration.conjugate()).real / level**2 if level else 0.0,
        force=float(np.abs(recorded[0]).max()),
        acceleration=float(np.abs(recorded[1]).max()),
        seconds=seconds,
        stopped=next((name for name in STOPS if scalars[f"stopped_by_{name}"]), ""),
    )


def _within(signals: Array, rate: float, band: float) -> Array:
    """Signals (channels, samples) over whole cycles without what lies above a band (Hz): the peaks of impacts that the
    anti-alias filter leaves of them."""
    spectrum = np.fft.rfft(signals, axis=1)
    spectrum[:, np.fft.rfftfreq(signals.shape[1], 1.0 / rate) > band] = 0.0
    return np.fft.irfft(spectrum, signals.shape[1], axis=1)


def _lost(rows: Array) -> float:
    """What bed and losses take by a ledger, J per cycle."""
    means = rows.mean(axis=0)
    return float(sum(means[COLUMNS.index(name)] for name in (*IN_BED, *LOST)))


def apparent_mass(stand: Stand, motion: Waveform) -> float:
    """Re(F A*)/|A|^2 at the fundamental over the latest whole cycles, kg."""
    force = stand.latest_force
    phase = motion.omega * (np.arange(force.size) + 0.5) / stand.rate
    return float(-2.0 * np.mean(force * np.sin(phase)) / motion.acceleration)


def _plan(
    campaign: Campaign, condition: Condition, channels: tuple[ChannelInfo, ...], look: Look, reactive: float
) -> tuple[float | None, float | None, int | None]:
    """Expected U of W_exp, smallest decidable difference of two conditions, J; None where one run shows no scatter.
    Repeats needed, see Outlook."""
    n, s, W = campaign.protocol.repeats.n, _scatter(campaign, condition), look.lost
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

    needed = next((m for m in range(2 if s > 0.0 else 1, MOST_REPEATS + 1) if expected(m) <= OFFSET * W), None)
    if n == 1 and s > 0.0:
        return None, None, needed
    factor = stdtrit(2.0 * (n - 1), CONFIDENCE) * np.sqrt(2.0 / n) if n > 1 else 0.0
    return expected(n), float(factor * np.hypot(s, noise)), needed


def _scatter(campaign: Campaign, condition: Condition) -> float:
    """Standard deviation of W_T over some pourings, J: the refill scatter that the rig file assumes."""
    if not campaign.protocol.repeats.refill:
        return 0.0
    scene, drive, rig = condition.scene, condition.drive, campaign.rig
    rng = stream(campaign.protocol.seed, condition.seed_key, "preflight")
    fillings = [refill(scene, rig, rng) for _ in range(POURINGS)]
    W = [total_of(scene, rig, filling, drive.acceleration, drive.frequency).total for filling in fillings]
    return float(np.std(W, ddof=1))


def _range_use(channel: ChannelInfo, peak: float) -> float:
    return peak * channel.sensitivity / channel.range_V
