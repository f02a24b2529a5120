"""One cause taken away: what a run's bed would take in the exact waveform of the level that the servo reached."""

import numpy as np

from rig.beds.janssen_stack import Filling
from rig.catalog.entries import Rig
from rig.drive.waveform import Waveform
from rig.protocol.spec import Acquire, Scene
from rig.stand.ledger import COLUMNS, IN_BED
from rig.stand.prescribed import CHUNK_CYCLES, Stand

EDGES = 64
"""Sampling edges per cycle: the energies are found at the events and do not depend on it."""


def level(motion: Waveform) -> float:
    """Amplitude of the fundamental acceleration, m/s^2."""
    return motion.acceleration * float(np.hypot(motion.sine[0], motion.cosine[0]))


def account_of(stand: Stand, acquire: Acquire) -> dict[str, float]:
    """Ledger of a stand at its start: means over the cycles that will be recorded, J per cycle."""
    cycles = acquire.settle + acquire.record
    for _ in range(-(-cycles // CHUNK_CYCLES)):
        stand.advance()
    means = stand.drain_ledger()[acquire.settle : cycles].mean(axis=0)
    return dict(zip(COLUMNS, map(float, means), strict=True))


def taken_by_bed(account: dict[str, float]) -> float:
    """What the bed of an account takes, its change of kinetic energy included, J per cycle."""
    return sum(account[name] for name in (*IN_BED, "dKE_bed"))


def exact_energy(scene: Scene, rig: Rig, motion: Waveform, filling: Filling, acquire: Acquire) -> float:
    """J per cycle that a filling takes over the recorded cycles when the box moves on an exact sine of equal level."""
    exact = Waveform(motion.frequency, level(motion))
    return taken_by_bed(account_of(Stand(scene, rig, exact, filling, EDGES * motion.frequency), acquire))
