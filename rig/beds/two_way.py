"""Beds in a box that they move: what of them is bonded to it, what damps it, and the rows that slide in it."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rig.beds.bed import Array
from rig.beds.stack import Filling, bed_mass, stack
from rig.catalog.entries import Rig
from rig.scene import Scene

LEAST_PLAY = 1e-9
"""Rows with less room than this, m, are bonded."""


def _none() -> Array:
    return np.zeros(0)


@dataclass(frozen=True)
class TwoWay:
    """A bed as the coupled drive takes it, SI.

    bonded : mass that moves with the box for good
    damping : of a dashpot between box and ground, N s/m
    row_mass, restitution : of every row, at the end walls
    band, play : friction of each row against the box as an acceleration, and its free play, shape (rows,)
    pull : acceleration that gravity gives the rows along the drive axis
    """

    bonded: float = 0.0
    damping: float = 0.0
    row_mass: float = 0.0
    restitution: float = 0.0
    band: Array = field(default_factory=_none)
    play: Array = field(default_factory=_none)
    pull: float = 0.0

    @property
    def mass(self) -> float:
        """Mass of the grains, kg."""
        return self.bonded + self.row_mass * self.band.size


def _layers(scene: Scene, rig: Rig, filling: Filling) -> TwoWay:
    bed = stack(scene, rig, filling)
    band = np.repeat(bed.threshold, bed.play.shape[1])
    play = bed.play.ravel()
    free = play > LEAST_PLAY
    bonded = bed.carried_mass + bed.row_mass * float(np.count_nonzero(~free))
    return TwoWay(bonded, 0.0, bed.row_mass, bed.restitution, band[free], play[free])


TWO_WAY: dict[str, Callable[[Scene, Rig, Filling], TwoWay]] = {
    "empty": lambda _scene, _rig, _filling: TwoWay(),
    "locked": lambda scene, _rig, filling: TwoWay(bonded=bed_mass(scene, filling.packing)),
    "dashpot": lambda scene, _rig, _filling: TwoWay(damping=scene.dashpot.c),
    "layers": _layers,
}
"""Bed by name: (scene, rig, filling) -> the bed for the coupled drive."""
