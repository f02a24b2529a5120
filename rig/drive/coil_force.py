"""Force derived from the coil current: it includes the inertia and flexure forces of
the armature.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from daq.chain.source import PhysicalSource
from rig.catalog.entries import Exciter
from rig.drive.waveform import Waveform

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Armature:
    """Moving mass (kg) of an exciter, damping (N s/m) and stiffness (N/m) of its flexure."""

    mass: float
    damping: float
    stiffness: float

    @classmethod
    def of(cls, exciter: Exciter) -> "Armature":
        """Return the armature of an exciter; c = 2 zeta sqrt(k m)."""
        stiffness, mass = exciter.flexure_stiffness, exciter.moving_mass
        return cls(
            mass, float(2.0 * exciter.flexure_damping_ratio * np.sqrt(stiffness * mass)), stiffness
        )


class CoilForce:
    """A physical source (force, acceleration) whose force is BL i = F_gauge + m x'' + c x' + k x.

    The armature is assumed to move as the box does, and the exciter body to stand still. x and x'
    are taken at the middle of each interval: they differ from the interval means by (w h)^2/24,
    about 1e-7.
    """

    def __init__(self, source: PhysicalSource, armature: Armature, motion: Waveform) -> None:
        self.names, self.rate = source.names, source.rate
        self._source, self._armature, self._motion = source, armature, motion
        self._next = 0

    def read(self, n: int) -> Array:
        """Return the next n interval means, shape (2, n)."""
        seen = self._source.read(n).copy()
        turns = (np.arange(self._next, self._next + n) + 0.5) * (self._motion.frequency / self.rate)
        position, velocity = self._motion.at(2.0 * np.pi * (turns - np.floor(turns)))
        moved = self._armature
        seen[0] += moved.mass * seen[1] + moved.damping * velocity + moved.stiffness * position
        self._next += n
        return seen
