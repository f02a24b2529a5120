"""Protocol settings that the paper does not state, and materials: assumed values, listed in every
report with those of the rig file.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from operator import attrgetter
from typing import Any

from rig.catalog.contact_materials import CONTACTS, ELASTIC, material_of
from rig.catalog.entries import CatalogValue, Material, Rig
from rig.protocol.spec import Condition, Scene
from rig.units import unit_of

OPEN = (
    (
        "scene.axis",
        "",
        "the paper does not say; eq 5 shears horizontal layers, Fig. 4 starts a chain at a side wall",
    ),
    ("scene.cavity.wall", "length", "the paper gives carbon steel and no thickness"),
    (
        "scene.layers.clearance",
        "",
        "clearance in units of eq 4's slip: the paper's thinnest to thickest distance",
    ),
    ("scene.layers.spread", "", "relative spread of the clearance over the rows of a layer"),
    ("scene.layers.rows", "", "strata per layer; physically width over diameter"),
    ("drive.frequency", "frequency", "the paper gives none"),
    (
        "drive.mode",
        "",
        "the paper does not say; prescribed is an ideal waveform, shaker has the exciter in the loop",
    ),
)
"""Path, dimension, reason of the assumption."""

WITHOUT_GRAINS = ("empty", "dashpot", "loop_back")
WITH_CONTACTS = ("grains", "column")
"""Beds that need no material, and beds that need more of it than its density."""


def assumed_settings(conditions: Sequence[Condition]) -> list[dict[str, Any]]:
    """Return the assumed settings with their values over all conditions, in the form of the rig
    file's values.
    """
    return [
        {
            "path": path,
            "value": _over_all(path, conditions),
            "unit": unit_of(dimension) if dimension else "",
            "status": "assumed",
            "source": why,
        }
        for path, dimension, why in OPEN
    ]


def _over_all(path: str, conditions: Sequence[Condition]) -> Any:
    """Return the value of a setting, or all its values in one text."""
    found = list(dict.fromkeys(map(attrgetter(path), conditions)))
    return (
        found[0]
        if len(found) == 1
        else ", ".join(f"{v:g}" if isinstance(v, float) else str(v) for v in found)
    )


def material_values(conditions: Sequence[Condition], rig: Rig) -> tuple[CatalogValue, ...]:
    """Return the values of the conditions' materials under paths such as "lead.density".

    Of one's own materials every value; of those of the catalog the values that the bed and the box
    use, unless they are sourced. Coefficients of contact that one's own grains leave out are listed
    as the rig's.
    """
    found: dict[CatalogValue, None] = {}
    for condition in conditions:
        found |= dict.fromkeys(_grain_values(condition.scene, rig))
        found |= dict.fromkeys(_wall_values(condition.scene))
    return tuple(found)


def _grain_values(scene: Scene, rig: Rig) -> Iterator[CatalogValue]:
    if scene.bed in WITHOUT_GRAINS:
        return
    named = scene.grains.material
    used = (*ELASTIC, *CONTACTS) if scene.bed in WITH_CONTACTS else ("density",)
    yield from _listed(named, used, scene.grains.density)
    if isinstance(named, Material):
        stated = {value.path: value for value in rig.values}
        for name in CONTACTS:
            if getattr(named, name) is None:
                source = f"not stated; that of the rig {rig.name}"
                yield replace(stated[name], path=f"{named.name}.{name}", source=source)


def _wall_values(scene: Scene) -> Iterator[CatalogValue]:
    if scene.cavity.material is not None:
        used = ELASTIC if scene.bed in WITH_CONTACTS else ("density",)
        yield from _listed(scene.cavity.material, used, scene.cavity.density)


def _listed(
    named: str | Material, used: Sequence[str], density: float | None
) -> Iterator[CatalogValue]:
    """Yield the values to list of one material; a density that the scene replaces is none of them."""
    material = material_of(named)
    for value in material.values:
        own = isinstance(named, Material) or (value.path in used and value.status != "sourced")
        if own and not (value.path == "density" and density != value.value):
            yield replace(value, path=f"{material.name}.{value.path}")
