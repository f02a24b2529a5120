"""The interface of a bed in prescribed motion: momentum taken from the box, and an
energy account.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Reaction:
    """Reaction of the bed over a number of whole cycles of the drive.

    momentum : cumulative impulse that the box has given the bed up to each sampling edge, N s,
        shape (edges,). The mean force on the box between two edges is minus the increment divided
        by the interval: an impact counts in full in the interval in which it falls, and nothing is
        sampled at points. The impulse that carries the bed's weight along the axis is left out,
        because it grows without limit; the stand adds the weight.
    work : work of the box on the bed in each cycle, J, shape (cycles,), found at the contacts
    friction, collision, viscous : losses in the bed in each cycle, J, shape (cycles,)
    kinetic : energy of the bed at the end of each cycle, J, shape (cycles,): kinetic, plus
        potential where the bed has weight along the axis
    repeats : period in cycles with which these and all following cycles recur bit for bit, on a
        sampling grid that repeats with the cycle; 0 if there is none, or none is known
    """

    momentum: Array
    work: Array
    friction: Array
    collision: Array
    viscous: Array
    kinetic: Array
    repeats: int = 0


class Bed(Protocol):
    """A bed in prescribed motion, advanced cycle by cycle in constant memory."""

    @property
    def mass(self) -> float:
        """Mass of the grains, kg."""

    @property
    def kinetic_at_start(self) -> float:
        """Energy of the bed when the motion starts, J, counted as in `Reaction.kinetic`."""

    def advance(self, cycles: int) -> Reaction:
        """Advance by `cycles` whole cycles of the drive and return the reaction over them."""
