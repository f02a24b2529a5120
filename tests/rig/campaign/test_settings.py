"""Values that the paper does not state are listed as assumed, with those that a protocol uses."""

import pytest

from rig.campaign.open_settings import OPEN, assumed_settings, material_values
from rig.catalog.contact_materials import CONTACTS, ELASTIC
from rig.catalog.rig_file import load_rig
from rig.protocol import shipped
from rig.protocol.grid import conditions
from rig.protocol.load import load_protocol

TEXT = "schema: rig/protocol/1\nname: x\nvary: {drive.frequency: [20 Hz, 25 Hz]}\n"


def test_every_open_setting_is_listed_with_its_values() -> None:
    found = {row["path"]: row for row in assumed_settings(conditions(load_protocol(TEXT)))}
    assert set(found) == {path for path, _, _ in OPEN}
    assert found["drive.frequency"]["value"] == "20, 25"
    assert found["drive.frequency"]["unit"] == "Hz"
    assert found["scene.cavity.wall"]["value"] == 0.005
    assert {row["status"] for row in found.values()} == {"assumed"}


def values_of(text: str) -> dict[str, float]:
    protocol = load_protocol(f"schema: rig/protocol/1\nname: x\n{text}\n")
    found = material_values(conditions(protocol), load_rig(protocol.rig))
    return {value.path: value.value for value in found}


@pytest.mark.parametrize("name", shipped.names())
def test_a_shipped_protocol_lists_no_material(name: str) -> None:
    """Its report has the bytes that it had before materials were listed."""
    protocol = load_protocol(name)
    assert material_values(conditions(protocol), load_rig(protocol.rig)) == ()


def test_ones_own_material_is_listed_with_all_that_was_assumed_for_it() -> None:
    found = values_of("scene: {grains: {material: {name: shot, density: 3e3, wall_friction: 0.3}}}")
    assert set(found) == {f"shot.{name}" for name in (*ELASTIC, *CONTACTS)}
    assert (found["shot.density"], found["shot.wall_friction"]) == (3000.0, 0.3)
    assert found["shot.grain_friction"] == load_rig().grain_friction


def test_of_the_catalog_what_the_run_uses() -> None:
    wall = "cavity: {material: pmma}"
    assert values_of(f"scene: {{{wall}}}") == {"pmma.density": 1190.0}
    both = f"grains: {{material: lead}}, {wall}"
    assert set(values_of(f"scene: {{{both}}}")) == {"lead.density", "pmma.density"}
    assert set(values_of(f"scene: {{bed: empty, {both}}}")) == {"pmma.density"}
    replaced = "grains: {material: lead, density: 11e3}"
    assert values_of(f"scene: {{{replaced}}}") == {}
