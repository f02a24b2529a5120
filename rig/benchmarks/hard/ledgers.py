"""Hard case of every bed: 1e5 cycles of the drive, after which the energy balance still closes."""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rig.beds.bed import Bed
from rig.beds.janssen_stack import Stack
from rig.beds.layers import LayersBed
from rig.beds.rigid import DashpotBed, LockedBed
from rig.beds.single_mass import SingleMassBed
from rig.benchmarks.hard.case import Case, CaseOutcome, Measure, at_most, exactly
from rig.drive.waveform import Sampling, Waveform
from rig.theory.single_mass import MassInGap

Array = NDArray[np.float64]

CYCLES = 100_000
CHUNK = 1000
PURE = Waveform(20.0, 5.0)
DISTORTED = Waveform(20.0, 5.0, (1.0, 0.0, 0.2), (0.0, 0.0, -0.1))


def account(bed: Bed, cycles: int = CYCLES) -> tuple[float, float, Array]:
    """Return (drift of the summed balance over the work done, the bed's final kinetic energy, the
    losses of each cycle).
    """
    start = bed.kinetic_at_start
    work, lost = [], []
    kinetic = start
    for _ in range(cycles // CHUNK):
        reaction = bed.advance(CHUNK)
        work.append(reaction.work)
        lost.append(reaction.friction + reaction.collision + reaction.viscous)
        kinetic = float(reaction.kinetic[-1])
        if not np.isfinite(reaction.momentum).all():
            return math.nan, math.nan, np.concatenate(lost)
    done, gone = math.fsum(np.concatenate(work)), math.fsum(np.concatenate(lost))
    left = abs(done - gone - (kinetic - start))
    scale = max(abs(done), np.finfo(float).tiny) if done else 1.0
    return left / scale, kinetic, np.concatenate(lost)


def layers(
    restitution: float, band: tuple[float, ...], clearance: tuple[float, ...], motion: Waveform
) -> LayersBed:
    """Return rows of 1 kg: thresholds in levels, clearances in amplitudes."""
    rows = Stack(
        threshold=np.array(band) * motion.acceleration,
        clearance=np.tile(np.array(clearance) * motion.length_unit, (len(band), 1)),
        row_mass=1.0,
        carried_mass=1.0,
        restitution=restitution,
    )
    return LayersBed(rows, Sampling(motion, 8.0))


def single_mass(
    gap: float, weight: float, friction: float, restitution: float, motion: Waveform
) -> SingleMassBed:
    """Return a single mass of 1 kg: gap in amplitudes, weight and friction in levels."""
    low, a = 0.0 if weight or gap < math.inf else -math.inf, motion.acceleration
    return SingleMassBed(
        MassInGap(
            1.0, low, gap * motion.length_unit, weight * a, friction * a, restitution, 0.0, 0.0
        ),
        Sampling(motion, 8.0),
    )


BEDS: tuple[tuple[str, Callable[[], Bed]], ...] = (
    ("empty", lambda: LockedBed(0.0, Sampling(PURE, 8.0))),
    ("locked", lambda: LockedBed(36.0, Sampling(PURE, 8.0))),
    ("dashpot", lambda: DashpotBed(50.0, Sampling(PURE, 8.0))),
    ("layers, plastic, period 1", lambda: layers(0.0, (0.1, 0.5), (0.5, 2.0), PURE)),
    ("layers, plastic, no period", lambda: layers(0.0, (0.02, 0.1), (4.1, 6.3), DISTORTED)),
    ("layers, e_row = .25", lambda: layers(0.25, (0.02, 0.3), (0.5, 3.0), DISTORTED)),
    ("layers, e_row = .75, no friction", lambda: layers(0.75, (0.0,), (1.0, 5.0), PURE)),
    (
        "single mass, plastic, vertical, period 1",
        lambda: single_mass(math.inf, 0.4, 0.0, 0.0, PURE),
    ),
    (
        "single mass, plastic, vertical, distorted",
        lambda: single_mass(math.inf, 0.14, 0.0, 0.0, DISTORTED),
    ),
    ("single mass, e = .6, with a lid", lambda: single_mass(3.0, 0.3, 0.0, 0.6, DISTORTED)),
    ("single mass, e = .9, no weight", lambda: single_mass(4.0, 0.0, 0.0, 0.9, PURE)),
    ("single mass, rough floor", lambda: single_mass(math.inf, 0.0, 0.3, 0.0, DISTORTED)),
)


def long_run() -> CaseOutcome:
    """The sum over 1e5 cycles: work, losses and the kinetic energy at both ends."""
    measures: list[Measure] = []
    for name, make in BEDS:
        drift, kinetic, lost = account(make())
        measures.append(at_most(f"{name}: drift over the work done", drift, 1e-9))
        if "period 1" in name or name in ("empty", "locked", "dashpot"):
            measures.append(
                exactly(
                    f"{name}: first 1000 settled cycles less the last 1000, J", _ends(lost), 0.0
                )
            )
        if not math.isfinite(kinetic):
            measures.append(at_most(f"{name}: kinetic energy", kinetic, math.inf))
    return CaseOutcome(measured=tuple(measures))


def _ends(lost: Array) -> float:
    """Return the losses of the first 1000 settled cycles less those of the last 1000."""
    return abs(float(lost[100:1100].sum() - lost[-1000:].sum()))


CASES = (
    Case(
        "1e5 cycles of every bed",
        "round-off that adds up; a replay that is not the cycle it stands for",
        "the sum closes to 1e-9 of the work done; steady cycles repeat to the last bit",
        long_run,
    ),
)
