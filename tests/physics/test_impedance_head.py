"""Gauge and accelerometer at the exciter's end of the stinger, on the stand."""

from dataclasses import replace

import numpy as np
import pytest

from rig.beds.janssen_stack import nominal
from rig.catalog.entries import Rig
from rig.drive.amplifier_command import Command
from rig.protocol.spec import Drive, Scene
from rig.stand.ledger import COUPLED_COLUMNS
from rig.stand.shaker import CoupledStand


def test_a_head_at_the_exciter_reads_the_stinger_too(rig: Rig, steel: Scene) -> None:
    """On the stand: work read at the exciter's end is the ledger's at the gauge plus its loss in
    the stinger, once all cycles are alike; the apparent mass of a locked bed is M/(1 - w^2 M/k)
    there."""
    scene = replace(steel, bed="locked", losses=("noise",))
    lossy = replace(rig, exciter=replace(rig.exciter, stinger_damping=2000.0))
    drive = Drive(
        mode="shaker", frequency=50.0, amplifier="current", gauge="exciter", accelerometer="exciter"
    )
    stand = CoupledStand(scene, lossy, drive, nominal(scene, rig), 50.0 * 4096)
    command = Command((15.0 + 0j,), 50.0, 2)
    stand.begin(command)
    signals = stand.advance(command)[:, :4096]
    orders = np.arange(1, 4)
    turns = np.exp(-2j * np.pi * np.outer(orders, (np.arange(4096) + 0.5) / 4096))
    force, acceleration = (2.0 * turns @ row / 4096 for row in signals)
    jw = 2j * np.pi * 50.0 * orders
    work = -0.5 / 50.0 * float(((force * acceleration.conj()).imag / jw.imag).sum())
    ledger = dict(zip(COUPLED_COLUMNS, stand.drain_ledger()[0], strict=True))
    gauge = sum(ledger[name] for name in ("W_noise", "W_f", "W_c", "dKE_box", "dKE_bed"))
    assert ledger["W_stinger"] > 0.2 * gauge
    assert work == pytest.approx(gauge + ledger["W_stinger"], rel=1e-4)
    plant = stand.plant
    mass = (force[0] * acceleration[0].conj()).real / abs(acceleration[0]) ** 2
    stinger = plant.stinger + 100j * np.pi * plant.stinger_damping
    load = plant.box + plant.damping / (100j * np.pi)
    seen = load / (1.0 - (100.0 * np.pi) ** 2 * load / stinger)
    assert mass == pytest.approx(seen.real + rig.gauge_mass, rel=1e-4)
