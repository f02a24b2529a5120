"""What the model says of a scene: both tiers of W_T and the bound, from scene and rig to plain numbers."""

from dataclasses import dataclass

import numpy as np

from rig.beds.stack import Stack, bed_mass, layer_count, nominal, stack
from rig.catalog.entries import Rig
from rig.scene import Condition, Scene
from rig.stand import box_mass
from rig.theory.friction import friction_energy_per_slip, janssen_length
from rig.theory.total import AVERAGED_CYCLES, Total, closed_tier, paper_collision, plastic_bound

LEVELS = (0.97, 1.0, 1.03)
"""Levels, relative to the set acceleration, at which W_T is computed to be read at the measured acceleration."""

NUMERICAL_ERROR = 1e-3
"""Relative standard uncertainty of W_T's numerics: averaging of rows without a period (tests/physics)."""

NOTHING = Total(0.0, 0.0, 1, 1.0)


@dataclass(frozen=True)
class Prediction:
    """Energy per cycle that the model gives for one condition, J, and what it is made of (masses in kg)."""

    bed_mass: float
    box_mass: float
    layers: int
    carried: bool
    W_f: float
    W_c: float
    W_T: float
    W_T_paper: float
    bound: float
    period: int
    periodic_share: float


def closed(scene: Scene, bed: Stack, acceleration: float, frequency: float, cycles: int = AVERAGED_CYCLES) -> Total:
    """The closed tier of a scene's stack at one acceleration; nothing where the bed does not slide by design."""
    if scene.bed != "layers":
        return NOTHING
    return closed_tier(bed.threshold, bed.play, bed.row_mass, bed.restitution, acceleration, frequency, cycles)


def paper_tier(scene: Scene, rig: Rig, velocity: float) -> float:
    """W_T of the paper tier, J per cycle: eq 5 with one slip per layer, plus the first chain wave at both walls."""
    layers = layer_count(scene)
    density = scene.grains.density
    if scene.bed != "layers" or layers == 0 or density is None:
        return 0.0
    cavity, grains = scene.cavity, scene.grains
    bulk = rig.packing_shaken * density
    friction = friction_energy_per_slip(
        layers,
        grains.diameter,
        cavity.length,
        cavity.width,
        bulk,
        rig.gravity,
        rig.grain_friction,
        janssen_length(cavity.length, cavity.width, rig.wall_friction, rig.janssen_ratio),
    )
    layer_mass = bulk * cavity.width * grains.fill * cavity.height * grains.diameter
    count = int(cavity.length // grains.diameter)
    return friction + paper_collision(layer_mass, count, rig.restitution_grains, rig.restitution_wall, velocity)


def predict(condition: Condition, rig: Rig, cycles: int = AVERAGED_CYCLES) -> Prediction:
    """Both tiers of W_T and the bound for one condition on an exact sine at the set acceleration."""
    scene, drive = condition.scene, condition.drive
    bed = stack(scene, rig, nominal(scene, rig))
    return _prediction(condition, rig, bed, closed(scene, bed, drive.acceleration, drive.frequency, cycles))


def predict_about(condition: Condition, rig: Rig) -> tuple[Prediction, dict[str, list[float]]]:
    """As `predict`, with W_T, W_f and W_c (J) at levels about the set acceleration (m/s^2) beside it.

    The table is how W_T is read at the measured acceleration: plain numbers that another model's may replace.
    """
    scene, drive = condition.scene, condition.drive
    bed = stack(scene, rig, nominal(scene, rig))
    levels = [drive.acceleration * level for level in LEVELS]
    totals = [closed(scene, bed, level, drive.frequency) for level in levels]
    table = {
        "acceleration": levels,
        "W_T": [total.total for total in totals],
        "W_f": [total.friction for total in totals],
        "W_c": [total.collision for total in totals],
    }
    return _prediction(condition, rig, bed, totals[LEVELS.index(1.0)]), table


def _prediction(condition: Condition, rig: Rig, bed: Stack, total: Total) -> Prediction:
    scene, drive = condition.scene, condition.drive
    velocity = drive.acceleration / (2.0 * np.pi * drive.frequency)
    has_grains = scene.bed in ("layers", "locked")
    mass = bed_mass(scene, rig.packing_shaken) if has_grains else 0.0
    return Prediction(
        bed_mass=mass,
        box_mass=box_mass(scene.cavity, rig.wall_density),
        layers=layer_count(scene) if has_grains else 0,
        carried=mass > 0.0 and total.total == 0.0,
        W_f=total.friction,
        W_c=total.collision,
        W_T=total.total,
        W_T_paper=paper_tier(scene, rig, velocity),
        bound=plastic_bound(mass, velocity, bed.restitution) if scene.bed == "layers" else 0.0,
        period=total.period,
        periodic_share=total.periodic_share,
    )
