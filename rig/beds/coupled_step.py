"""Bed models for closed-loop (shaker-coupled) runs, where the bed reacts on the box: bonded mass,
viscous damping, sliding rows.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from rig.beds.bed import Array
from rig.beds.column import rows_of
from rig.beds.janssen_stack import Filling, bed_mass
from rig.beds.single_mass import single_mass
from rig.catalog.entries import Rig
from rig.protocol.spec import Scene

LEAST_CLEARANCE = 1e-9
"""Clearance, m, below which a row is treated as bonded to the box."""
ENDLESS = 1e3
"""Position, m, of a wall that the model does not have: far enough never to be reached."""


def _none() -> Array:
    return np.zeros(0)


@dataclass(frozen=True)
class TwoWay:
    """A bed as the shaker-coupled stand takes it, SI units.

    bonded : mass that moves with the box permanently, kg
    damping : coefficient of a dashpot between box and ground, N s/m
    row_mass, restitution : mass of each row, kg, and its coefficient of restitution at the end
        walls
    band, clearance : friction of each row against the box divided by its mass, m/s^2, and its
        clearance, m, shape (rows,)
    pull : acceleration of the rows along the drive axis due to gravity, m/s^2; the support of the
        box carries their weight
    start, velocity : initial position of the rows from the wall at 0, m, and initial velocity
        relative to the box, m/s
    """

    bonded: float = 0.0
    damping: float = 0.0
    row_mass: float = 0.0
    restitution: float = 0.0
    band: Array = field(default_factory=_none)
    clearance: Array = field(default_factory=_none)
    pull: float = 0.0
    start: float = 0.0
    velocity: float = 0.0

    @property
    def mass(self) -> float:
        """Mass of the grains, kg."""
        return self.bonded + self.row_mass * self.band.size


def _rows(scene: Scene, rig: Rig, filling: Filling) -> TwoWay:
    bed = rows_of(scene, rig, filling)
    band = np.tile(bed.threshold, bed.clearance.shape[1])
    clearance, start = bed.clearance.T.ravel(), 0.0
    if np.isinf(clearance).any():
        # Rows without end walls start half way between walls that they never reach.
        clearance, start = np.full(clearance.size, 2.0 * ENDLESS), ENDLESS
    free = clearance > LEAST_CLEARANCE
    # A row without clearance cannot slide: its mass belongs to the box.
    # A row without clearance cannot slide: its mass belongs to the box.
    bonded = bed.carried_mass + bed.row_mass * float(np.count_nonzero(~free))
    return TwoWay(
        bonded, 0.0, bed.row_mass, bed.restitution, band[free], clearance[free], start=start
    )


def _single_mass(scene: Scene, rig: Rig, filling: Filling) -> TwoWay:
    """Return the single mass as one row. Walls at infinity become walls at `ENDLESS`."""
    one = single_mass(scene, rig, filling)
    low = max(one.low, -ENDLESS)
    clearance = min(one.high, ENDLESS) - low
    if one.mass == 0.0 or clearance <= LEAST_CLEARANCE:
        return TwoWay(bonded=one.mass)
    return TwoWay(
        row_mass=one.mass,
        restitution=one.restitution,
        band=np.array([one.friction]),
        clearance=np.array([clearance]),
        pull=-one.weight,
        start=one.start - low,
        velocity=one.velocity,
    )


TWO_WAY: dict[str, Callable[[Scene, Rig, Filling], TwoWay]] = {
    "empty": lambda _scene, _rig, _filling: TwoWay(),
    "loop_back": lambda _scene, _rig, _filling: TwoWay(),
    "locked": lambda scene, _rig, filling: TwoWay(bonded=bed_mass(scene, filling.packing)),
    "dashpot": lambda scene, _rig, _filling: TwoWay(damping=scene.dashpot.c),
    "layers": _rows,
    "column": _rows,
    "single_mass": _single_mass,
}
"""Maps the name of a bed to its factory: (scene, rig, filling) -> bed for the
shaker-coupled stand.
"""
