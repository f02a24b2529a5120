"""The account over 1e5 cycles of scenes as protocols have them, in both drives: nothing leaks into
the sum.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from rig.beds.janssen_stack import nominal, refill
from rig.catalog.entries import Rig
from rig.drive.amplifier_command import Command
from rig.drive.waveform import waveform
from rig.protocol.spec import Cavity, Drive, Grains, Layers, Scene, SingleMass
from rig.stand.ledger import COLUMNS, COUPLED_COLUMNS, LOST_IN_EXCITER, SPENT
from rig.stand.prescribed import Stand
from rig.stand.shaker import CoupledStand

Array = NDArray[np.float64]

DRIFT = 1e-9
"""Largest fraction of the work by which the sum of an account may be off, whatever the number of
cycles.
"""

EDGES = 64
"""Sampling edges per cycle: energies are found at the events, whatever their number."""

STEEL = Grains(density=7900.0)
BEDS = {
    "empty": Scene(bed="empty", losses=("noise", "air")),
    "locked": Scene(bed="locked", grains=STEEL, losses=("air", "mount"), support="guide"),
    "dashpot": Scene(bed="dashpot", losses=("noise", "mount"), support="cords"),
    "layers": Scene(grains=STEEL, losses=("noise", "air", "gas")),
    "layers that rebound": Scene(grains=replace(STEEL, diameter=0.015), losses=()),
    "single mass, thrown": Scene(
        bed="single_mass", grains=replace(STEEL, fill=0.1), axis="vertical", losses=()
    ),
    "single mass, bouncing, lid": Scene(
        bed="single_mass",
        grains=replace(STEEL, fill=0.1),
        axis="vertical",
        losses=("noise",),
        single_mass=SingleMass(restitution=0.6, gap=2e-3),
    ),
    "single mass, no weight": Scene(
        bed="single_mass",
        grains=replace(STEEL, fill=0.1),
        axis="zero_gravity",
        losses=(),
        single_mass=SingleMass(restitution=0.3, gap=2e-3),
    ),
    "single mass, rough floor": Scene(
        bed="single_mass",
        grains=replace(STEEL, fill=0.1),
        losses=(),
        single_mass=SingleMass(friction=0.15, gap=1e-3, restitution=0.2),
    ),
}
LEVELS = {"layers": 3.0, "layers that rebound": 5.0, "single mass, rough floor": 5.0}
"""m/s^2, else 20: rows at 3 m/s^2 have periods or none side by side, so that some are simulated
throughout.
"""


def drift(
    rows: Iterator[Array], columns: tuple[str, ...], given: str, spent: tuple[str, ...]
) -> float:
    """What a balance leaves of its sum, over the work that went through it in either direction."""
    left, scale = [], []
    into, out = columns.index(given), [columns.index(name) for name in spent]
    for part in rows:
        assert np.isfinite(part).all()
        left.append(math.fsum(part[:, into]) - math.fsum(part[:, out].ravel()))
        scale.append(float(np.abs(part[:, into]).sum()))
    return abs(math.fsum(left)) / max(math.fsum(scale), np.finfo(float).tiny)


def prescribed(name: str, rig: Rig, cycles: int) -> Iterator[Array]:
    """Ledger rows of a scene whose waveform and bed are drawn as in a run."""
    scene, rng = BEDS[name], np.random.default_rng(3)
    motion = waveform(
        Drive(acceleration=LEVELS.get(name, 20.0)), rig.level_error, rig.third_harmonic, rng
    )
    stand = Stand(scene, rig, motion, refill(scene, rig, rng), EDGES * motion.frequency)
    for _ in range(cycles // 100):
        stand.read(100 * EDGES)
        yield stand.drain_ledger()


@pytest.mark.parametrize("cycles", [1000, pytest.param(100_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", BEDS)
def test_no_bed_drifts_in_prescribed_drive(name: str, cycles: int, rig: Rig) -> None:
    assert drift(prescribed(name, rig, cycles), COLUMNS, "W_gauge", SPENT) <= DRIFT


@pytest.mark.parametrize("name", ["empty", "locked"])
def test_what_takes_nothing_takes_nothing_for_ever(name: str, rig: Rig) -> None:
    """Without losses every number of the account is 0, to the last bit."""
    scene = replace(BEDS[name], losses=(), support="none")
    motion = waveform(Drive(), 0.0, 0.0, None)
    stand = Stand(scene, rig, motion, nominal(scene, rig), EDGES * motion.frequency)
    stand.read(2000 * EDGES)
    assert not stand.drain_ledger().any()


COUPLED = {
    "empty": Scene(bed="empty", losses=("noise", "air")),
    "locked": Scene(bed="locked", grains=STEEL, losses=("air",)),
    "layers": Scene(
        grains=Grains(density=7900.0, fill=0.05, diameter=0.01), layers=Layers(rows=1), losses=()
    ),
    "single_mass": Scene(
        bed="single_mass",
        axis="vertical",
        grains=Grains(density=3400.0, fill=0.1, diameter=2e-3),
        losses=(),
        cavity=Cavity(length=0.06, width=0.06, height=0.06, wall=0.03),
        single_mass=SingleMass(restitution=0.3, gap=3e-3),
    ),
}


def coupled(scene: Scene, rig: Rig, cycles: int) -> Iterator[Array]:
    """Ledger rows of a held command, from rest."""
    drive = Drive(mode="shaker", amplifier="current")
    stand = CoupledStand(scene, rig, drive, nominal(scene, rig), 4000 * 20.0)
    for _ in range(cycles // 50):
        stand.advance(Command((25.0 + 0j,), 20.0, 50))
        yield stand.drain_ledger()


@pytest.mark.parametrize("name", COUPLED)
@pytest.mark.parametrize("cycles", [200, pytest.param(100_000, marks=pytest.mark.slow)])
def test_no_bed_drifts_in_coupled_drive(name: str, cycles: int, rig: Rig) -> None:
    """Box and exciter, each in its own balance. A single mass takes a thousandth of the energy that
    goes back and forth.
    """
    rows = list(coupled(COUPLED[name], rig, cycles))
    assert drift(iter(rows), COUPLED_COLUMNS, "W_gauge", SPENT) <= DRIFT
    assert (
        drift(
            iter(rows), COUPLED_COLUMNS, "W_electric", (*LOST_IN_EXCITER, "dE_exciter", "W_gauge")
        )
        <= DRIFT
    )
