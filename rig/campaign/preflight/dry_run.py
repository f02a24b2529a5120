"""Dry run: a condition simulated without instruments, before it is run."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from daq.chain.fir import OVERSAMPLING
from rig.beds.janssen_stack import nominal
from rig.campaign.campaign import Campaign
from rig.campaign.one_run.coupled_dwell import Dwelling
from rig.campaign.one_run.part import STOPS
from rig.campaign.one_run.run_inputs import filling_of
from rig.drive.dwell import phasors
from rig.drive.exciter_limits import Demand
from rig.drive.losses import LOST
from rig.drive.waveform import Waveform
from rig.fidelity.scene_rows import side_by_side
from rig.protocol.spec import Condition
from rig.stand.force_peaks import AHEAD, PASS_BAND, beyond, steady, use_of, with_peaks_of
from rig.stand.ledger import COLUMNS, IN_BED
from rig.stand.prescribed import CHUNK_CYCLES, Stand

Array = NDArray[np.float64]

HELD = 16
"""Cycles simulated in shaker-coupled drive once the level is held: the last half counts."""


@dataclass(frozen=True)
class DryRun:
    """Results of a dry run, without instruments.

    exciter : utilisation of the exciter
    side_by_side : the same with all rows (see `Outlook`), None if not needed
    lost : dissipated energy, J per cycle
    level : reached, m/s^2
    mass : apparent mass, kg
    force, acceleration : peaks, N and m/s^2
    seconds : wall time per cycle
    stopped : reason why the level is not reached, "" for none
    """

    exciter: Demand
    side_by_side: Demand | None
    lost: float
    level: float
    mass: float
    force: float
    acceleration: float
    seconds: float
    stopped: str = ""


def dry_run_prescribed(campaign: Campaign, condition: Condition, rate: float) -> DryRun:
    """Run a condition in its exact prescribed motion; the exciter is solved backwards.

    Under `fidelity: auto`, peaks that exceed a limit are those of all rows, as in its runs.
    """
    rig, scene, drive = campaign.rig, condition.scene, condition.drive
    motion = Waveform(drive.frequency, drive.acceleration)
    stand = Stand(scene, rig, motion, nominal(scene, rig), rate)
    # Loads the compiled kernels: they must not count as simulation time.
    stand.advance()
    started = time.perf_counter()
    rows = steady(stand).drain_ledger()
    seconds = (time.perf_counter() - started) / (AHEAD * CHUNK_CYCLES)
    use = use_of(rig, stand)
    force = use.peak * rig.exciter.force_peak + stand.weight
    full, more = side_by_side(scene), None
    if beyond(use) and full is not scene:
        more = use_of(rig, steady(Stand(full, rig, motion, nominal(full, rig), rate)))
    if more is not None and condition.id in campaign.choices:
        use, more = with_peaks_of(use, more), None
    return DryRun(
        exciter=use,
        side_by_side=more,
        lost=_lost(rows[2 * len(rows) // 3 :]),
        level=drive.acceleration,
        mass=apparent_mass(stand, motion),
        force=force,
        acceleration=drive.acceleration,
        seconds=seconds,
    )


def dry_run_coupled(campaign: Campaign, condition: Condition, rate: float) -> DryRun:
    """Run the dwell of a condition with the bed of its first run until its level is held, plus
    `HELD` cycles.

    A sweep runs from end to end, with energies and level at its first frequency. The nominal bed
    would not represent a run: its layers are all alike and hit simultaneously.
    """
    rig, frequency = campaign.rig, condition.drive.frequency
    started = time.perf_counter()
    first = next(run for run in campaign.runs if run.condition.id == condition.id)
    dwelling = Dwelling(condition, rig, filling_of(campaign, first), rate)
    cycles = 0
    while dwelling.dwell.steady_from is None or cycles < dwelling.dwell.steady_from:
        cycles += 1
        dwelling.stand.read(
            round(cycles * rate / frequency) - round((cycles - 1) * rate / frequency)
        )
        dwelling.ledger()
    acquire, swept = condition.acquire, condition.drive.sweep_to is not None
    signals = dwelling.stand.read(round(HELD * rate / frequency))
    rows = dwelling.ledger()[:HELD]
    last = signals[:2, -round(HELD // 2 * rate / frequency) :]
    if swept:
        wanted = round(
            (acquire.settle / frequency + condition.drive.swept_time(acquire.record)) * rate
        )
        last = dwelling.stand.read(max(wanted - signals.shape[1], 1))[:2]
        cycles += acquire.settle + acquire.record - HELD
        dwelling.ledger()
    seconds = (time.perf_counter() - started) / (cycles + HELD)
    begin = signals[:2, : round(rate / frequency)] if swept else last
    force, acceleration = (phasors(row, 0, rate, frequency, 1)[0] for row in begin)
    recorded = _within(last if swept else signals[:2], rate, PASS_BAND * rate / OVERSAMPLING)
    scalars = dwelling.scalars()
    level = abs(acceleration)
    return DryRun(
        exciter=dwelling.demand,
        side_by_side=None,
        lost=_lost(rows[: 1 if swept else HELD][0 if swept else HELD // 2 :]),
        level=level,
        mass=(force * acceleration.conjugate()).real / level**2 if level else 0.0,
        force=float(np.abs(recorded[0]).max()),
        acceleration=float(np.abs(recorded[1]).max()),
        seconds=seconds,
        stopped=next((name for name in STOPS if scalars[f"stopped_by_{name}"]), ""),
    )


def _within(signals: Array, rate: float, band: float) -> Array:
    """Return signals (channels, samples) over whole cycles without components above a band (Hz):
    the peaks of impacts after the anti-alias filter.
    """
    spectrum = np.fft.rfft(signals, axis=1)
    spectrum[:, np.fft.rfftfreq(signals.shape[1], 1.0 / rate) > band] = 0.0
    return np.fft.irfft(spectrum, signals.shape[1], axis=1)


def _lost(rows: Array) -> float:
    """Return the energy dissipated in bed and losses by a ledger, J per cycle."""
    means = rows.mean(axis=0)
    return float(sum(means[COLUMNS.index(name)] for name in (*IN_BED, *LOST)))


def apparent_mass(stand: Stand, motion: Waveform) -> float:
    """Return Re(F A*)/|A|^2 at the fundamental over the latest whole cycles, kg."""
    force = stand.latest_force
    phase = motion.omega * (np.arange(force.size) + 0.5) / stand.rate
    return float(-2.0 * np.mean(force * np.sin(phase)) / motion.acceleration)
