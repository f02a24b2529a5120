"""The 1/f part of a channel's noise, for transducers that state spot densities; the front end adds
the white part.
"""

import math
from collections.abc import Sequence

import numpy as np

from daq.chain.channel import SPOTS
from daq.chain.source import FloatArray
from daq.compiled import njit

__all__ = ["Flicker", "sections"]


def sections(spots: Sequence[float]) -> FloatArray:
    """Return power densities s_i (unit^2/Hz) of first-order sections s_i / (1 + (f / f_i)^2), f_i =
    1, 10, 100 Hz.

    Together with white noise of the last spot's density they pass through all spots. One section
    per decade follows a 1/f law to within half a decibel; below 1 Hz the density is constant.
    Raises ValueError where the spots do not fall fast or steadily enough for sections of positive
    power.
    """
    f = np.array(SPOTS[:-1])
    excess = np.square(spots[:-1]) - spots[-1] ** 2
    powers = np.linalg.solve(1 / (1 + (f[:, None] / f[None, :]) ** 2), excess)
    if not (powers >= 0).all():
        raise ValueError(
            f"noise densities {tuple(spots)} at {SPOTS} Hz are no sum of falling sections"
        )
    return np.asarray(powers)


class Flicker:
    """A channel's noise above its white floor, sample by sample at the output rate (Hz).

    spots: densities at `SPOTS`, converted to the channel's volts by `scale`. Each section is a
    first-order autoregression that starts in its steady state and draws its own numbers from the
    channel's generator, block by block.
    """

    def __init__(
        self, spots: Sequence[float], scale: float, rate: float, rng: np.random.Generator
    ) -> None:
        corner = np.array(SPOTS[:-1])
        self._keep = np.array([math.exp(-2 * math.pi * value / rate) for value in SPOTS[:-1]])
        # Variance of a section: the integral of s / (1 + (f/f_i)^2) over f > 0 is s f_i pi/2.
        self._sigma = scale * np.sqrt(sections(spots) * math.pi / 2 * corner)
        self._rng = rng
        self._state = self._sigma * rng.standard_normal(corner.size)

    def add(self, volts: FloatArray) -> None:
        """Add the noise of the next samples to `volts`, in place."""
        gauss = self._rng.standard_normal((self._keep.size, volts.size))
        _add_sections(volts, gauss, self._keep, self._sigma, self._state)


@njit(cache=True, nogil=True)
def _add_sections(
    volts: FloatArray, gauss: FloatArray, keep: FloatArray, sigma: FloatArray, state: FloatArray
) -> None:
    """Add the sum of all sections: x_i <- keep_i x_i + sigma_i sqrt(1 - keep_i^2) g, g standard
    normal.
    """
    for k in range(keep.size):
        x, step = state[k], sigma[k] * math.sqrt(1 - keep[k] ** 2)
        for i in range(volts.size):
            x = keep[k] * x + step * gauss[k, i]
            volts[i] += x
        state[k] = x
