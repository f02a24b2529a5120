"""What a bed answers: the momentum that it takes from the box in programmed motion, and its energy account."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Reaction:
    """The bed over some whole cycles of the drive.

    momentum: impulse that the box has given the bed up to each sampling edge, N s, shape (edges,).
    The force on the box, averaged between two edges, is minus the increment over the interval's
    length: an impact counts whole in the interval in which it falls, and nothing is sampled at
    points. The impulse that carries the bed's weight along the axis is left out: it grows for ever,
    and the stand knows it.

    work: of the box on the bed in each cycle, J, shape (cycles,), found at the contacts

    friction, collision, viscous: losses in the bed in each cycle, J, shape (cycles,)

    kinetic: energy of the bed at the end of each cycle, J, shape (cycles,): kinetic, and potential
    where it has weight along the axis

    repeats: period in cycles with which these and all following cycles come again to the last bit,
    on a grid that repeats with the cycle; 0 for none, or not known
    """

    momentum: Array
    work: Array
    friction: Array
    collision: Array
    viscous: Array
    kinetic: Array
    repeats: int = 0


class Bed(Protocol):
    """A bed in programmed motion, advanced cycle by cycle in constant memory."""

    @property
    def mass(self) -> float:
        """Mass of the grains, kg."""

    @property
    def kinetic_at_start(self) -> float:
        """Energy of the bed when the motion starts, J, counted as in `Reaction.kinetic`."""

    def advance(self, cycles: int) -> Reaction:
        """The next whole cycles of the drive."""
