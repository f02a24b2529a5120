"""The grains as slip-impact layers: geometry, packing and friction of one filling of the box."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rig.catalog.entries import Rig
from rig.errors import InputError, Mistake
from rig.protocol.spec import Scene
from rig.theory.chain import COLLAPSE, LONGEST_ROW, TooManyHits, grains_in_row, row_restitution
from rig.theory.friction import janssen_length, layer_capacity, side_wall_capacity, slip_distance

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Filling:
    """Properties that differ between refills: shaken bulk fraction, clearance factor and row
    positions.

    `position` is the position u in [0, 1] of a row within its stratum of the clearance
    distribution: one number for all rows, or an array (layers, rows).
    """

    packing: float
    clearance: float
    position: float | Array = 0.5


@dataclass(frozen=True)
class Stack:
    """The layers that can slide, top first, and the mass that rides with the box.

    threshold : box acceleration at which each mobile layer starts to slide, m/s^2, shape (layers,)
    clearance : clearance of each row, m, shape (layers, rows)
    row_mass : mass of one row, kg
    carried_mass : mass of the layers that have no room to move, kg
    restitution : coefficient of restitution of a row's centre of mass at an end wall
    """

    threshold: Array
    clearance: Array
    row_mass: float
    carried_mass: float
    restitution: float

    @property
    def mass(self) -> float:
        """Mass of the whole bed, kg."""
        return self.carried_mass + self.row_mass * self.clearance.size


def nominal(scene: Scene, rig: Rig) -> Filling:
    """Return the filling that W_T assumes: nominal packing and clearance, rows in the middle of
    their strata.
    """
    return Filling(rig.packing_shaken, scene.layers.clearance)


def refill(scene: Scene, rig: Rig, rng: np.random.Generator) -> Filling:
    """Return one random refill: packing, clearance and row positions with the rig file's assumed
    scatter.
    """
    packing = rig.packing_shaken * (1.0 + rig.refill_packing * rng.standard_normal())
    clearance = scene.layers.clearance * max(
        1.0 + rig.refill_clearance * rng.standard_normal(), 0.0
    )
    return Filling(packing, clearance, rng.random((layer_count(scene), scene.layers.rows)))


def layer_count(scene: Scene) -> int:
    """Return the number of layers one grain high, round(w H/d); a bed thinner than half a grain is
    one layer.
    """
    depth = scene.grains.fill * scene.cavity.height
    return 0 if depth == 0.0 else max(round(depth / scene.grains.diameter), 1)


def bed_mass(scene: Scene, packing: float) -> float:
    """Return the mass of the grains, kg: they fill the fraction w of the cavity's height at the
    bulk fraction `packing`.
    """
    cavity = scene.cavity
    return (
        packing * _density(scene) * cavity.length * cavity.width * cavity.height * scene.grains.fill
    )


def mobile_share(fill: float, packing_shaken: float, packing_loose: float) -> float:
    """Return the fraction of the layers that have room to flow, chi in [0, 1].

    Flow needs the loose fraction phi_f. All layers move up to w* = phi_f/phi_b; above it only the
    fraction (1 - w)/((phi_b/phi_f - 1) w), counted from the top; none at w = 1.
    """
    swelling = packing_shaken / packing_loose
    if fill * swelling <= 1.0:
        return 1.0
    return min((1.0 - fill) / ((swelling - 1.0) * fill), 1.0)


def stack(scene: Scene, rig: Rig, filling: Filling) -> Stack:
    """Return the layers of one filling (docs/model.md, layers variant): thresholds f_i/m, clearances,
    masses and restitution.

    Raises InputError for rows that are too long and too elastic for their rebound to be followed.
    """
    cavity, grains, settings = scene.cavity, scene.grains, scene.layers
    layers = layer_count(scene)
    if layers == 0:
        return Stack(np.zeros(0), np.zeros((0, settings.rows)), 0.0, 0.0, 0.0)
    bulk = filling.packing * _density(scene)
    spacing = grains.fill * cavity.height / layers
    layer_mass = bulk * cavity.length * cavity.width * spacing
    saturation = janssen_length(cavity.length, cavity.width, rig.wall_friction, rig.janssen_ratio)
    capacity = layer_capacity(
        layers,
        spacing,
        cavity.length,
        cavity.width,
        bulk,
        rig.gravity,
        rig.grain_friction,
        saturation,
    )
    if settings.side_walls:
        capacity = capacity + side_wall_capacity(
            layers,
            spacing,
            cavity.length,
            bulk,
            rig.gravity,
            rig.wall_friction,
            rig.janssen_ratio,
            saturation,
        )
    mobile = round(mobile_share(grains.fill, filling.packing, rig.packing_loose) * layers)
    # Stratified sampling of the clearance: each row draws from its own stratum of [1 - spread, 1 +
    # spread].
    # Stratified sampling of the clearance: each row draws from its own stratum of [1 - spread, 1 +
    # spread].
    stratum = np.arange(settings.rows) + np.broadcast_to(filling.position, (layers, settings.rows))
    spread = 1.0 - settings.spread + 2.0 * settings.spread * stratum / settings.rows
    return Stack(
        threshold=capacity[:mobile] / layer_mass,
        clearance=(filling.clearance * slip_distance(grains.diameter) * spread)[:mobile],
        row_mass=layer_mass / settings.rows,
        carried_mass=layer_mass * (layers - mobile),
        restitution=_row_restitution(grains_in_row(cavity.length, grains.diameter), rig),
    )


def _row_restitution(grains: int, rig: Rig) -> float:
    try:
        return row_restitution(grains, rig.restitution_grains, rig.restitution_wall)
    except TooManyHits as error:
        allowed = f"at most {LONGEST_ROW} grains, or a restitution of at most 1 - {COLLAPSE:g}/n, where rows are plastic"
        raise InputError(Mistake("scene", "scene.grains.diameter", str(error), allowed)) from error


def _density(scene: Scene) -> float:
    if scene.grains.density is None:
        raise ValueError("the scene's grains have no density: resolve the material first")
    return scene.grains.density
