"""Ablation of the waveform: energy that a run's bed would dissipate in the exact waveform of the
level reached.
"""

import numpy as np

from rig.beds.janssen_stack import Filling
from rig.catalog.entries import Rig
from rig.drive.waveform import Waveform
from rig.protocol.spec import Acquire, Scene
from rig.stand.ledger import COLUMNS, IN_BED
from rig.stand.prescribed import CHUNK_CYCLES, Stand

EDGES = 64
"""Sampling edges per cycle: the energies are computed at the events and do not depend on it."""


def level(motion: Waveform) -> float:
    """Return the amplitude of the fundamental acceleration, m/s^2."""
    return motion.acceleration * float(np.hypot(motion.sine[0], motion.cosine[0]))


def account_of(stand: Stand, acquire: Acquire) -> dict[str, float]:
    """Return the ledger of a stand from its start: means over the recorded cycles, J per cycle."""
    cycles = acquire.settle + acquire.record
    for _ in range(-(-cycles // CHUNK_CYCLES)):
        stand.advance()
    means = stand.drain_ledger()[acquire.settle : cycles].mean(axis=0)
    return dict(zip(COLUMNS, map(float, means), strict=True))


def taken_by_bed(account: dict[str, float]) -> float:
    """Return the energy that the bed of an account receives, including its change of kinetic
    energy, J per cycle.
    """
    return sum(account[name] for name in (*IN_BED, "dKE_bed"))


def exact_energy(
    scene: Scene, rig: Rig, motion: Waveform, filling: Filling, acquire: Acquire
) -> float:
    """Return the energy, J per cycle, that a filling receives in the recorded cycles on an exact
    sine of equal level.
    """
    exact = Waveform(motion.frequency, level(motion))
    return taken_by_bed(
        account_of(Stand(scene, rig, exact, filling, EDGES * motion.frequency), acquire)
    )
