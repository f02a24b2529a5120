"""The slug's kernel against orbits that are known in closed form, solved here with 40 digits."""

import mpmath as mp
import numpy as np
import pytest

from rig.kernels.slug import Cycles, State, Steady, run, steady, world
from rig.kernels.waveform import Array

SINE = (np.ones(1), np.zeros(1))
THIRD = (np.array([1.0, 0.0, 0.2]), np.array([0.0, 0.0, -0.1]))
REST = State(0, 0.0, 0.0)
NO_LID = np.inf

mp.mp.dps = 40


def settled(
    weight: float = 0.0, gap: float = NO_LID, e: float = 0.0, band: float = 0.0, lower: float = 0.0, start: State = REST
) -> Steady:
    """Mean cycle of a slug on a sine, units of the sine: weight and band are accelerations over its peak."""
    return steady(start, *world(weight, band, lower, gap, e, *SINE), *SINE)


def followed(
    cycles: int, weight: float = 0.0, gap: float = NO_LID, e: float = 0.0, band: float = 0.0, lower: float = 0.0,
    start: State = REST, waveform: tuple[Array, Array] = SINE,
) -> Cycles:  # fmt: skip
    """A slug cycle by cycle."""
    return run(start, *world(weight, band, lower, gap, e, *waveform), *waveform, cycles)


class Flight:
    """A flight over a box that moves as x = sin t: height r and closing speed, from phase `start` at speed u."""

    def __init__(self, level: float, start: mp.mpf, u: mp.mpf | int = 0, height: mp.mpf | int = 0) -> None:
        self.pull = 1 / mp.mpf(level) if level else mp.mpf(0)
        self.start, self.u, self.height = start, u, height

    def r(self, t: mp.mpf) -> mp.mpf:
        moved = mp.sin(self.start + t) - mp.sin(self.start)
        return self.height + (self.u + mp.cos(self.start)) * t - self.pull * t * t / 2 - moved

    def speed(self, t: mp.mpf) -> mp.mpf:
        return self.u + mp.cos(self.start) - self.pull * t - mp.cos(self.start + t)

    def meets(self, height: mp.mpf | float, step: float = 1e-3) -> mp.mpf:
        """First time after the start at which the height is reached, by walking in small steps and bisecting."""
        side = mp.sign(self.r(mp.mpf(step)) - height)
        t = mp.mpf(step)
        while mp.sign(self.r(t + step) - height) == side:
            t += step
        return mp.findroot(lambda s: self.r(s) - height, (t, t + step), solver="anderson", tol=1e-60)


@pytest.mark.parametrize("level", [1.01, 1.1, 1.5, 2.0, 2.5, 3.0, 3.2, 3.29])
def test_a_plastic_slug_leaves_at_sin_1_over_gamma_and_lands_once_a_cycle(level: float) -> None:
    """W = m u^2/2 at the first root of the flight, u the closing speed; it lands while the floor pushes."""
    flight = Flight(level, mp.asin(1 / mp.mpf(level)))
    # the flight from rest is of order (level - 1): start the walk behind the take-off, where it stands clear
    t = flight.meets(0, step=1e-2 if level > 1.05 else 5e-3)
    found = settled(weight=1 / level)
    assert (found.period, found.friction, found.lid) == (1, 0.0, False)
    assert found.collision == pytest.approx(float(flight.speed(t) ** 2 / 2), rel=1e-9)
