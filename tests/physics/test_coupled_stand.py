"""The stand in shaker-coupled drive: laws that hold whatever the motion is."""

from dataclasses import replace

import numpy as np
import pytest

from rig.beds.janssen_stack import nominal
from rig.catalog.entries import Rig
from rig.drive.amplifier_command import Command
from rig.protocol.spec import Drive, Scene
from rig.stand.ledger import COUPLED_COLUMNS
from rig.stand.shaker import CoupledStand

RATE = 4096 * 20.0
COUPLED = Drive(mode="shaker", amplifier="current")


def stand(scene: Scene, rig: Rig, drive: Drive = COUPLED, **more: object) -> CoupledStand:
    return CoupledStand(scene, rig, drive, nominal(scene, rig), RATE, **more)  # type: ignore[arg-type]


def column(ledger: np.ndarray, name: str) -> np.ndarray:
    return ledger[:, COUPLED_COLUMNS.index(name)]


@pytest.mark.parametrize("amplifier", ["voltage", "current"])
@pytest.mark.parametrize("bed", ["empty", "locked", "dashpot", "layers"])
def test_both_accounts_close(rig: Rig, steel: Scene, bed: str, amplifier: str) -> None:
    """At the gauge plane and at the amplifier's terminals; quadrature of fourth order leaves 1e-9,
    impacts nothing.
    """
    scene = replace(steel, bed=bed, losses=("noise", "air", "gas", "mount"), support="guide")
    tested = stand(scene, rig, Drive(mode="shaker", amplifier=amplifier))  # type: ignore[arg-type]
    tested.advance(Command((10.0 + 0j,), 20.0, 8))
    ledger = tested.drain_ledger()
    assert column(ledger, "W_gauge")[-1] > 0
    assert np.abs(column(ledger, "closure")).max() < 1e-8
    assert np.abs(column(ledger, "closure_exciter")).max() < 1e-8


def test_the_signals_are_those_of_the_account(rig: Rig, steel: Scene) -> None:
    """Force times velocity from the record alone, summed, is W_gauge: both are means over the same
    intervals, and an impact counts half on either side of its edge. Products of means leave out (w
    h)^2/12: 2e-4 at the stinger's 715 Hz and less at the harmonics that carry the work."""
    tested = stand(steel, rig)
    record = [tested.advance(Command((10.0 + 0j,), 20.0, 8))]
    before = tested.drain_ledger()
    record.append(tested.advance(Command((10.0 + 0j,), 20.0, 1)))
    force, acceleration = np.concatenate(record, axis=1)
    v = np.concatenate(([0.0], np.cumsum(acceleration))) / RATE
    work = np.sum((force * 0.5 * (v[1:] + v[:-1])).reshape(-1, 4096), axis=1) / RATE
    accounted = np.concatenate((before, tested.drain_ledger()))
    assert work == pytest.approx(column(accounted, "W_gauge"), rel=1e-4, abs=1e-6)


def test_reading_is_what_advancing_gives(rig: Rig, steel: Scene) -> None:
    """Chunks of any size, commands from a driver: the same stream."""
    names = ("force", "acceleration", "voltage", "current")
    levels = iter((3.0, 8.0, 8.0, 8.0))
    one = stand(steel, rig, names=names)
    whole = np.concatenate([one.advance(Command((u + 0j,), 20.0)) for u in (3.0, 8.0, 8.0)], axis=1)
    read = stand(steel, rig, names=names, driver=lambda _seen: Command((next(levels) + 0j,), 20.0))
    parts = np.concatenate([read.read(n) for n in (5, 4096, 8187)], axis=1)
    assert np.array_equal(parts, whole)
