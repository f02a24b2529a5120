"""Loss channels against their closed forms and their force against their energy."""

import numpy as np
import pytest

from rig.drive.waveform import Waveform
from rig.losses import Losses, mean_force, quadratic_energy, viscous_energy


def test_viscous_loss_of_a_sine() -> None:
    motion = Waveform(20.0, 5.0)
    assert viscous_energy(7.0, motion) == pytest.approx(np.pi * 7.0 * motion.omega * motion.length_unit**2, rel=1e-13)


def test_quadratic_loss_of_a_sine() -> None:
    """8/3 k w^2 X^3; |v|^3 has a jump in its third derivative: midpoint error O(n^-4) at 4096 points."""
    motion = Waveform(20.0, 5.0)
    exact = 8.0 / 3.0 * 7.0 * motion.omega**2 * motion.length_unit**3
    assert quadratic_energy(7.0, motion) == pytest.approx(exact, rel=1e-10)


@pytest.mark.parametrize("losses", [Losses(noise=50.0), Losses(air=3000.0), Losses(50.0, 3000.0)])
def test_mean_force_does_the_work_of_its_channel(losses: Losses) -> None:
    motion = Waveform(20.0, 5.0, (1.0, 0.0, 0.1), (0.0, 0.0, 0.05))
    n = 4096
    position, velocity = motion.at(2 * np.pi * np.arange(n + 1) / n)
    interval = 1.0 / (20.0 * n)
    force = mean_force(losses, position, velocity, interval)
    done = -float(np.sum(force * np.diff(position)))
    expected = viscous_energy(losses.noise, motion) + quadratic_energy(losses.air, motion)
    # means of F and v multiply: (w h)^2/12 relative per harmonic, 2e-7 for the first, 2e-6 for the third
    assert done == pytest.approx(expected, rel=3e-6)
