"""A slow sweep of a rigid load through the resonances of mount and flexure, against the frequency
response.

With the phase phi, phi' = w and phi'' = b, the answer of a linear system to e^(j phi) is e^(j phi)
times

    int h(s) e^(-j w s + j b s^2/2) ds = H - j (b/2) H'' - (b^2/8) H'''' + ...         derivatives
    by w

(h the impulse response, the second exponential as a series): the sweep rate shifts the answer by
(b/2) |H''|, known from the steady response alone, and what that leaves goes with the rate squared.
Resonances of the default exciter under an empty box: 3.7 and 6.0 Hz, damped.
"""

from dataclasses import replace

import numpy as np
import pytest

from rig.beds.janssen_stack import nominal
from rig.catalog.entries import Rig
from rig.drive.amplifier_command import Command
from rig.drive.electrodynamic import I, Plant, response
from rig.protocol.spec import Amplifier, Drive, Scene
from rig.stand.shaker import CoupledStand

RATE = 10240.0
STEP = 0.02
"""Step of the differences, Hz. A second difference is off by step^2/12 of the fourth derivative:
0.4 % of the next term of the series at 0.2 Hz/s."""
FORGOTTEN = 7.0
"""Time constants of the slowest mode after which the start, where the rate sets in, is e^-7 of the
shift.
"""
EDGES = 2e-6
"""What the sampling leaves: the command is straight between edges and the signals are means, (w
h)^2/24 at 6.5 Hz.
"""
EVERY = 17
"""Samples compared: each 17th."""


def series(
    plant: Plant, amplifier: Amplifier, name: str, frequency: np.ndarray, pace: float
) -> list[np.ndarray]:
    """Terms of the answer at each frequency (Hz), sweep rate in Hz/s."""
    h = [getattr(response(plant, amplifier, frequency + k * STEP), name) for k in range(-3, 4)]
    step, b = 2.0 * np.pi * STEP, 2.0 * np.pi * pace
    second, fourth, sixth = (
        sum(weight * value for weight, value in zip(weights, h, strict=True)) / step**order
        for order, weights in (
            (2, (0, 0, 1, -2, 1, 0, 0)),
            (4, (0, 1, -4, 6, -4, 1, 0)),
            (6, (1, -6, 15, -20, 15, -6, 1)),
        )
    )
    return [h[3], -0.5j * b * second, -(b**2) / 8.0 * fourth, 1j * b**3 / 48.0 * sixth]


def undriven(plant: Plant) -> np.ndarray:
    """The matrix with the current given: its row and column are out."""
    return np.delete(np.delete(plant.matrix(), I, 0), I, 1)


@pytest.mark.parametrize(
    ("bed", "amplifier", "first", "last", "cycles"),
    [
        ("empty", "voltage", 3.0, 6.5, 110),
        ("locked", "voltage", 6.5, 3.0, 80),
        ("empty", "current", 6.5, 3.0, 110),
    ],
)
def test_a_slow_sweep_is_off_its_response_by_what_its_rate_makes(
    rig: Rig, steel: Scene, bed: str, amplifier: Amplifier, first: float, last: float, cycles: int
) -> None:
    """Force and acceleration, sample by sample, at 0.15 to 0.2 Hz/s, upwards and downwards. A
    current amplifier leaves the coil undamped: its flexure is damped instead, to keep the sweep
    slow for its mode."""
    if amplifier == "current":
        rig = replace(
            rig,
            exciter=replace(rig.exciter, flexure_damping_ratio=1.0, isolation_damping_ratio=0.2),
        )
    scene = replace(steel, bed=bed, losses=())
    drive = Drive(mode="shaker", frequency=first, amplifier=amplifier)
    tested = CoupledStand(scene, rig, drive, nominal(scene, rig), RATE)
    one = (1.0 + 0j,)
    tested.begin(Command(one, first))
    sweep = Command(one, first, cycles, sweep_to=last)
    signals = tested.advance(sweep)
    slowest = -np.linalg.eigvals(
        tested.plant.matrix() if amplifier == "voltage" else undriven(tested.plant)
    ).real.max()
    time = (np.arange(signals.shape[1]) + 0.5) / RATE
    picked = np.flatnonzero(time > FORGOTTEN / slowest)[::EVERY]
    time = time[picked]
    wave = np.exp(2j * np.pi * sweep.turns_at(np.asarray(time, dtype=np.float64)))
    pace = (last**2 - first**2) / (2.0 * cycles)
    for name, signal in zip(tested.names, signals[:, picked], strict=True):
        terms = series(tested.plant, amplifier, name, first + pace * time, pace)
        size = np.abs(terms[0])
        shift, second, third = ((np.abs(term) / size).max() for term in terms[1:])
        steady_only, shifted = (
            (np.abs(signal - (sum(terms[:n]) * wave).real) / size).max() for n in (1, 2)
        )
        floor = EDGES + np.exp(-FORGOTTEN) * shift
        assert steady_only == pytest.approx(shift, abs=second + floor), name
        assert shifted == pytest.approx(second, abs=third + floor), name
        assert second < 0.3 * shift, "the series falls: the sweep is slow"
