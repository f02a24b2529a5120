"""The force as the coil's current tells it."""

import numpy as np
import pytest
from scipy.integrate import cumulative_simpson

from rig.catalog.entries_by_name import exciter
from rig.drive.coil_force import Armature, CoilForce
from rig.drive.waveform import Waveform

MOTION = Waveform(20.0, 3.0, (1.0, 0.0, 0.003), (0.0, 0.0, 0.002))
PER_CYCLE = 4096


class Massless:
    """No force at the gauge; the box's mean acceleration over each interval."""

    names = ("force", "acceleration")
    rate = PER_CYCLE * MOTION.frequency

    def __init__(self) -> None:
        self._next = 0

    def read(self, n: int) -> np.ndarray:
        edges = 2 * np.pi * np.arange(self._next, self._next + n + 1) / PER_CYCLE
        self._next += n
        return np.stack([np.zeros(n), np.diff(MOTION.at(edges)[1]) * self.rate])


def test_an_armature_is_mass_flexure_and_damping() -> None:
    """By an independent road: the acceleration integrated twice by Simpson's rule, from the
    motion's start.
    """
    armature = Armature.of(exciter("JZ-30"))
    n = 2 * PER_CYCLE
    force, acceleration = CoilForce(Massless(), armature, MOTION).read(n)
    fine = np.linspace(0.0, 2 / MOTION.frequency, 2 * n + 1)
    phase = MOTION.omega * fine
    a = -MOTION.acceleration * sum(
        p * np.sin(h * phase) + q * np.cos(h * phase)
        for h, (p, q) in enumerate(zip(MOTION.sine, MOTION.cosine, strict=True), 1)
    )
    v = cumulative_simpson(a, x=fine, initial=0) + MOTION.start_velocity
    x = cumulative_simpson(v, x=fine, initial=0) + float(MOTION.at(np.zeros(1))[0][0])
    wanted = armature.mass * acceleration + (armature.damping * v + armature.stiffness * x)[1::2]
    assert force == pytest.approx(wanted, abs=1e-6 * np.abs(force).max())


def test_only_the_damping_takes_energy() -> None:
    """pi c w X^2 in each harmonic; mass and stiffness are in quadrature."""
    armature = Armature(0.5, 9.6, 9500.0)
    coil = CoilForce(Massless(), armature, MOTION)
    force = np.concatenate([coil.read(n)[0] for n in (1, 1000, PER_CYCLE - 1001)])
    position = MOTION.at(2 * np.pi * np.arange(PER_CYCLE + 1) / PER_CYCLE)[0]
    found = float((force * np.diff(position)).sum())
    parts = [
        np.pi
        * armature.damping
        * h
        * MOTION.omega
        * (MOTION.length_unit / h**2) ** 2
        * (p * p + q * q)
        for h, (p, q) in enumerate(zip(MOTION.sine, MOTION.cosine, strict=True), 1)
    ]
    assert found == pytest.approx(sum(parts), rel=1e-5)
