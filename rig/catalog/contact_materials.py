"""What the contacts in a bed of grains need of the materials of grains and box."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rig.catalog.entries import CatalogValue, Material, Rig
from rig.catalog.entries_by_name import material
from rig.protocol.spec import Scene

WALL = "steel"
"""The catalog entry with the elastic constants of a box whose material is left to the rig."""


ELASTIC = ("density", "youngs_modulus", "poisson_ratio")
_PAIRS = {
    "between_grains": ("restitution_grains", "grain_friction"),
    "at_wall": ("restitution_wall", "wall_friction"),
}
CONTACTS = tuple(name for pair in _PAIRS.values() for name in pair)
"""Numbers of a material: by itself, and in contact."""


@dataclass(frozen=True)
class Solid:
    """A material by itself: density kg/m^3, Young's modulus Pa, Poisson ratio."""

    density: float
    youngs_modulus: float
    poisson_ratio: float


@dataclass(frozen=True)
class PairOfSurfaces:
    """Two surfaces that touch: coefficients of restitution and of friction."""

    restitution: float
    friction: float


@dataclass(frozen=True)
class ContactMaterials:
    """Materials of grains and wall, and how they meet.

    `values` lists each number's origin under its path here: `grains.density`,
    `at_wall.friction` ...
    """

    grains: Solid
    wall: Solid
    between_grains: PairOfSurfaces
    at_wall: PairOfSurfaces
    values: tuple[CatalogValue, ...]


def contact_materials(scene: Scene, rig: Rig) -> ContactMaterials:
    """Return the materials of a scene and the coefficients of their contacts.

    A density that the scene states takes the place of its material's, and a coefficient that the
    grains' material states that of the rig's. The coefficients at the wall are those of the grains'
    material, whatever the box is made of. Raises InputError for a material that is not in the
    catalog.
    """
    grains, wall = material_of(scene.grains.material), _wall(scene, rig)
    own = _with_density(grains.values, scene.grains.density)
    box = _with_density(wall.values, scene.cavity.density)
    given = {value.path: value for value in (*rig.values, *own)}

    def pair(place: str) -> PairOfSurfaces:
        restitution, friction = (_coefficient(grains, rig, name) for name in _PAIRS[place])
        return PairOfSurfaces(restitution, friction)

    origins = [
        *(replace(value, path=f"grains.{value.path}") for value in own if value.path in ELASTIC),
        *(replace(value, path=f"wall.{value.path}") for value in box if value.path in ELASTIC),
        *(
            replace(given[name], path=f"{place}.{word}")
            for place, names in _PAIRS.items()
            for word, name in zip(("restitution", "friction"), names, strict=True)
            if name in given
        ),
    ]
    return ContactMaterials(
        _solid(grains, scene.grains.density),
        _solid(wall, scene.cavity.density),
        pair("between_grains"),
        pair("at_wall"),
        tuple(origins),
    )


def material_of(named: str | Material) -> Material:
    """Return the material that a scene names or holds. Raises InputError for an unknown name."""
    return named if isinstance(named, Material) else material(named)


def _wall(scene: Scene, rig: Rig) -> Material:
    """Return the material of the box: the scene's, or the rig's density with the constants of
    `WALL`.
    """
    if scene.cavity.material is not None:
        return material_of(scene.cavity.material)
    steel = material(WALL)
    density = [
        replace(value, path="density") for value in rig.values if value.path == "wall_density"
    ]
    rest = [value for value in steel.values if value.path != "density"]
    return replace(steel, density=rig.wall_density, values=(*density, *rest))


def _solid(body: Material, density: float | None) -> Solid:
    return Solid(
        body.density if density is None else density, body.youngs_modulus, body.poisson_ratio
    )


def _coefficient(grains: Material, rig: Rig, name: str) -> float:
    own: float | None = getattr(grains, name)
    return float(getattr(rig, name)) if own is None else own


def _with_density(
    values: tuple[CatalogValue, ...], density: float | None
) -> tuple[CatalogValue, ...]:
    """Return the values with the density that a scene states, where it is another."""
    return tuple(
        replace(value, value=density, status="assumed", source="given with the scene")
        if value.path == "density" and density not in (None, value.value)
        else value
        for value in values
    )
