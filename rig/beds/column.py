"""Bed `column`: layers as Coulomb blocks that slide on each other without end walls, thresholds
rising with depth.
"""

import math

import numpy as np

from rig.beds.janssen_stack import Filling, Stack, bed_mass, layer_count, stack
from rig.catalog.entries import Rig
from rig.errors import InputError, Mistake
from rig.protocol.spec import Scene
from rig.theory.column import ColumnBed
from rig.theory.column_table import OutsideTable, block_profile


def column_bed(scene: Scene, packing: float) -> ColumnBed:
    """Return the bed of a scene as the column takes it; `packing` : bulk fraction of the grains."""
    cavity, grains = scene.cavity, scene.grains
    return ColumnBed(
        cavity.length,
        cavity.width,
        cavity.height,
        grains.diameter,
        grains.fill,
        bed_mass(scene, packing),
    )


def column_stack(scene: Scene, rig: Rig, filling: Filling) -> Stack:
    """Return the layers of one filling as one row each, with thresholds g y_i.

    A row has no end walls: the walls' push is in its threshold already. A filling changes the mass
    alone. Raises InputError for friction outside the table of coefficients.
    """
    layers = layer_count(scene)
    bed = column_bed(scene, filling.packing)
    try:
        profile = block_profile(rig.grain_friction, rig.wall_friction)
    except OutsideTable as error:
        allowed = "friction in the rig file that the table has, or another bed"
        raise InputError(Mistake("scene", "scene.bed", f"bed column: {error}", allowed)) from error
    return Stack(
        threshold=rig.gravity * profile.levels(bed.depths, bed.length, bed.width),
        clearance=np.full((layers, 1), math.inf),
        row_mass=bed.mass / max(layers, 1),
        carried_mass=0.0,
        restitution=0.0,
    )


def rows_of(scene: Scene, rig: Rig, filling: Filling) -> Stack:
    """Return the sliding rows of a filling: of bed `column`, or of the layers variant. Raises
    InputError where there are none.
    """
    make = column_stack if scene.bed == "column" else stack
    return make(scene, rig, filling)
