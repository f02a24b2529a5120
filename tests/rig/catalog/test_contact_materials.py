"""What contacts need of materials: whose number is taken, and that each says where it comes from."""

from dataclasses import replace

import pytest

from rig.catalog.contact_materials import CONTACTS, ELASTIC, contact_materials
from rig.catalog.entries import Material
from rig.catalog.entries_by_name import material, names
from rig.catalog.rig_file import load_rig
from rig.catalog.stated_values import own_material
from rig.protocol.spec import Cavity, Grains, Scene

RIG = load_rig()


def scene(grains: str | Material, wall: str | Material | None = None) -> Scene:
    return Scene(cavity=Cavity(material=wall), grains=Grains(material=grains))


@pytest.mark.parametrize("name", names("material"))
def test_contacts_are_the_materials_or_the_rigs(name: str) -> None:
    """A material states all four coefficients or none: a mixture would be nobody's contact."""
    grain, found = material(name), contact_materials(scene(name), RIG)
    own = [getattr(grain, one) for one in CONTACTS]
    assert own.count(None) in (0, 4)
    taken = [getattr(grain if own[0] is not None else RIG, one) for one in CONTACTS]
    pairs = (found.between_grains, found.at_wall)
    assert [x for pair in pairs for x in (pair.restitution, pair.friction)] == taken


@pytest.mark.parametrize("name", names("material"))
def test_a_coefficient_that_is_assumed_has_its_uncertainty(name: str) -> None:
    for value in material(name).values:
        if value.path in CONTACTS and value.status == "assumed":
            assert value.source.startswith("+-"), value


def test_every_number_has_one_origin_with_its_value() -> None:
    for grains, wall in (("glass", "pmma"), ("stainless", None), ("sand", "steel")):
        found = contact_materials(scene(grains, wall), RIG)
        numbers = {
            **{f"grains.{name}": getattr(found.grains, name) for name in ELASTIC},
            **{f"wall.{name}": getattr(found.wall, name) for name in ELASTIC},
            "between_grains.restitution": found.between_grains.restitution,
            "between_grains.friction": found.between_grains.friction,
            "at_wall.restitution": found.at_wall.restitution,
            "at_wall.friction": found.at_wall.friction,
        }
        assert {value.path: value.value for value in found.values} == numbers
        assert len(found.values) == len(numbers)


def test_a_density_of_the_scene_takes_the_materials_place() -> None:
    light = replace(
        scene("lead", "steel"),
        grains=Grains(material="lead", density=10900.0),
        cavity=Cavity(material="steel", density=7800.0),
    )
    found = contact_materials(light, RIG)
    assert (found.grains.density, found.wall.density) == (10900.0, 7800.0)
    assert found.grains.youngs_modulus == material("lead").youngs_modulus
    origins = {value.path: value.status for value in found.values}
    assert origins["grains.density"] == origins["wall.density"] == "assumed"


def test_a_box_without_material_is_the_rigs_steel() -> None:
    heavy = replace(RIG, wall_density=8000.0)
    found = contact_materials(scene("lead"), heavy)
    assert found.wall.density == 8000.0
    assert found.wall.youngs_modulus == material("steel").youngs_modulus


def test_a_rig_with_other_coefficients_rules_where_the_material_is_silent() -> None:
    rough = replace(RIG, grain_friction=0.4, wall_friction=0.6)
    assert contact_materials(scene("stainless"), rough).between_grains.friction == 0.4
    assert contact_materials(scene("glass"), rough).at_wall == (
        contact_materials(scene("glass"), RIG).at_wall
    )
    own = own_material("x", {"density": material("lead").values[0]})
    assert contact_materials(scene(own), rough).at_wall.friction == 0.6
