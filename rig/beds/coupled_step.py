"""Beds in a box that they move: what of them is bonded to it, what damps it, and the rows that slide in it."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rig.beds.bed import Array
from rig.beds.janssen_stack import Filling, bed_mass, stack
from rig.beds.single_mass import slug
from rig.catalog.entries import Rig
from rig.protocol.spec import Scene

LEAST_PLAY = 1e-9
ENDLESS = 1e3
"""Rows with less room than the first, m, are bonded; the second stands for a wall that is not there."""


def _none() -> Array:
    return np.zeros(0)


@dataclass(frozen=True)
class TwoWay:
    """A bed as the coupled drive takes it, SI.

    bonded : mass that moves with the box for good
    damping : of a dashpot between box and ground, N s/m
    row_mass, restitution : of every row, at the end walls
    band, play : friction of each row against the box as an acceleration, and its free play, shape (rows,)
    pull : acceleration that gravity gives the rows along the drive axis; what carries the box carries their weight
    start, velocity : where the rows begin, m from the wall at 0, and how fast, m/s against the box
    """

    bonded: float = 0.0
    damping: float = 0.0
    row_mass: float = 0.0
    restitution: float = 0.0
    band: Array = field(default_factory=_none)
    play: Array = field(default_factory=_none)
    pull: float = 0.0
    start: float = 0.0
    velocity: float = 0.0

    @property
    def mass(self) -> float:
        """Mass of the grains, kg."""
        return self.bonded + self.row_mass * self.band.size


def _layers(scene: Scene, rig: Rig, filling: Filling) -> TwoWay:
    bed = stack(scene, rig, filling)
    band = np.tile(bed.threshold, bed.play.shape[1])
    play = bed.play.T.ravel()
    free = play > LEAST_PLAY
    bonded = bed.carried_mass + bed.row_mass * float(np.count_nonzero(~free))
    return TwoWay(bonded, 0.0, bed.row_mass, bed.restitution, band[free], play[free])


def _slug(scene: Scene, rig: Rig, filling: Filling) -> TwoWay:
    one = slug(scene, rig, filling)
    low = max(one.low, -ENDLESS)
    play = min(one.high, ENDLESS) - low
    if one.mass == 0.0 or play <= LEAST_PLAY:
        return TwoWay(bonded=one.mass)
    return TwoWay(
        row_mass=one.mass,
        restitution=one.restitution,
        band=np.array([one.friction]),
        play=np.array([play]),
        pull=-one.weight,
        start=one.start - low,
        velocity=one.velocity,
    )


TWO_WAY: dict[str, Callable[[Scene, Rig, Filling], TwoWay]] = {
    "empty": lambda _scene, _rig, _filling: TwoWay(),
    "loop_back": lambda _scene, _rig, _filling: TwoWay(),
    "locked": lambda scene, _rig, filling: TwoWay(bonded=bed_mass(scene, filling.packing)),
    "dashpot": lambda scene, _rig, _filling: TwoWay(damping=scene.dashpot.c),
    "layers": _layers,
    "slug": _slug,
}
"""Bed by name: (scene, rig, filling) -> the bed for the coupled drive."""
