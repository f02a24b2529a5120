"""Predictions of W_T that apply to any bed of grains in a scene: as printed, layers, column.

Each is computed at the levels of a table, with its own uncertainty, or says why it is not stated.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from rig.beds.column import column_bed
from rig.beds.janssen_stack import layer_count
from rig.catalog.entries import Rig
from rig.drive.waveform import Waveform
from rig.protocol.spec import BEDS_OF_GRAINS, Condition, Scene
from rig.theory.chain import grains_in_row
from rig.theory.column import column_total, outside, relative_uncertainty
from rig.theory.column_table import OutsideTable, column_coefficients
from rig.theory.friction import friction_energy_per_slip, janssen_length
from rig.theory.total import ModelEnergy, as_printed_collision

__all__ = [
    "VARIANTS",
    "Variant",
    "as_printed_variant",
    "column_variant",
    "event_resolved",
    "variants",
]

VARIANTS = ("as_printed", "layers", "column")


@dataclass(frozen=True)
class Variant:
    """One prediction of a condition.

    W_T : J per cycle at each level of the table, None if it is not stated; W_f, W_c : its parts,
        None if it has none
    why : reason that it is not stated, "" if it is
    u_rel, u_levels, u_settling : relative standard uncertainties as in `OwnPrediction`
    u_stated : relative standard uncertainty of the formula itself, against resolved grains
    """

    W_T: tuple[float, ...] | None
    W_f: tuple[float, ...] | None = None
    W_c: tuple[float, ...] | None = None
    why: str = ""
    u_rel: float = 0.0
    u_levels: float = 0.0
    u_settling: float = 0.0
    u_stated: float = 0.0


def variants(
    condition: Condition, rig: Rig, levels: Sequence[float], layers: Callable[[], Variant]
) -> dict[str, Variant]:
    """Return every variant of a condition by name, at levels about the set one (m/s^2).

    layers : computes the layers variant, where it applies
    """
    scene = condition.scene
    if scene.bed not in BEDS_OF_GRAINS:
        none = Variant(None, why=f"no grains move against each other in bed {scene.bed}")
        return dict.fromkeys(VARIANTS, none)
    column = column_variant(condition, rig, levels)
    if scene.axis != "horizontal":
        why = f"the axis is {scene.axis}, and the slip-impact layers are for horizontal drive"
        return {"as_printed": Variant(None, why=why), "layers": Variant(None, why=why),
                "column": column}  # fmt: skip
    frequency = condition.drive.frequency
    speeds = (Waveform(frequency, level).velocity_unit for level in levels)
    printed = Variant(tuple(as_printed_variant(scene, rig, speed) for speed in speeds))
    return {"as_printed": printed, "layers": layers(), "column": column}


def as_printed_variant(scene: Scene, rig: Rig, velocity: float) -> float:
    """Return W_T of the model as printed (variant as printed), J per cycle: eq 5 with one slip per
    layer, plus the first chain wave at both walls.
    """
    layers = layer_count(scene)
    density = scene.grains.density
    if scene.bed not in BEDS_OF_GRAINS or layers == 0 or density is None:
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
    count = grains_in_row(cavity.length, grains.diameter)
    return friction + as_printed_collision(
        layer_mass, count, rig.restitution_grains, rig.restitution_wall, velocity
    )


def event_resolved(
    totals: Sequence[ModelEnergy],
    u_rel: float,
    u_levels: float,
    u_settling: float = 0.0,
    u_stated: float = 0.0,
) -> Variant:
    """Return a variant of event-resolved energies at each level."""
    return Variant(
        W_T=tuple(total.total for total in totals),
        W_f=tuple(total.friction for total in totals),
        W_c=tuple(total.collision for total in totals),
        u_rel=u_rel,
        u_levels=u_levels,
        u_settling=u_settling,
        u_stated=u_stated,
    )


def column_variant(condition: Condition, rig: Rig, levels: Sequence[float]) -> Variant:
    """Return the column of a scene. It is stated, or not, by the set level."""
    scene, drive = condition.scene, condition.drive
    if scene.grains.fill == 0.0:
        return Variant((0.0,) * len(levels))
    if not rig.gravity > 0.0:
        return Variant(None, why="there is no gravity, and the column hangs on it")
    bed, level = column_bed(scene, rig.packing_shaken), drive.acceleration / rig.gravity
    try:
        coefficients = column_coefficients(rig.grain_friction, rig.wall_friction)
    except OutsideTable as error:
        return Variant(None, why=str(error))
    at_set = column_total(bed, coefficients, drive.acceleration, drive.frequency, rig.gravity)
    why = outside(bed, float(at_set.flow), level, rig.wall_friction, scene.axis)
    if why:
        return Variant(None, why="; ".join(why))
    found = column_total(bed, coefficients, levels, drive.frequency, rig.gravity).W_T
    return Variant(tuple(found.tolist()), u_stated=relative_uncertainty(level))
