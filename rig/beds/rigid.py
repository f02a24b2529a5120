"""Beds without internal motion: empty, locked, and a dashpot of known coefficient."""

from dataclasses import dataclass, field

import numpy as np

from rig.beds.bed import Reaction
from rig.drive.waveform import Sampling, viscous_energy


@dataclass
class LockedBed:
    """A mass bonded to the box: exactly no loss. An empty box is the same with zero mass."""

    mass: float
    sampling: Sampling
    _cycles: int = field(default=0, init=False)

    @property
    def kinetic_at_start(self) -> float:
        """Kinetic energy of the bonded mass when the motion starts, J."""
        return 0.5 * self.mass * self.sampling.motion.start_velocity**2

    def advance(self, cycles: int) -> Reaction:
        """Advance by whole cycles; the momentum is the mass times the box velocity."""
        velocity = self.sampling.edges(self._cycles, cycles).velocity[1:]
        self._cycles += cycles
        none = np.zeros(cycles)
        return Reaction(
            self.mass * velocity,
            none,
            none,
            none,
            none,
            np.full(cycles, self.kinetic_at_start),
            repeats=1,
        )


@dataclass
class DashpotBed:
    """A viscous damper between the box and the ground: force on the box -c v, W = pi c w X^2 for a
    sine.
    """

    coefficient: float
    sampling: Sampling
    _cycles: int = field(default=0, init=False)

    @property
    def mass(self) -> float:
        """A dashpot has no mass."""
        return 0.0

    @property
    def kinetic_at_start(self) -> float:
        """A dashpot stores no kinetic energy."""
        return 0.0

    def advance(self, cycles: int) -> Reaction:
        """Advance by whole cycles; the impulse of -c v is -c times the displacement."""
        position = self.sampling.edges(self._cycles, cycles).position[1:]
        self._cycles += cycles
        none = np.zeros(cycles)
        loss = np.full(cycles, viscous_energy(self.coefficient, self.sampling.motion))
        return Reaction(self.coefficient * position, loss, none, none, loss, none, repeats=1)
