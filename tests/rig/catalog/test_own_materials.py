"""Materials of one's own: written in the protocol or in a file beside it, carried by the protocol from then on."""

from dataclasses import replace
from pathlib import Path

import pytest

from rig.catalog.entries import Material
from rig.catalog.entries_by_name import material, names
from rig.catalog.own_materials import read_materials
from rig.catalog.stated_values import NOT_STATED
from rig.errors import InputError
from rig.protocol.grid import conditions
from rig.protocol.load import dump_protocol, load_protocol
from rig.protocol.spec import Scene

HEAD = "schema: rig/protocol/1\nname: own\n"
BALLS = "scene: {grains: {material: {density: 11.3 g/cm3, youngs_modulus: 16 GPa, wall_friction: 0.3}}}\n"
METALS = """\
schema: rig/catalog/1
my_lead:
  label: shot of the workshop
  density: {value: 11.2, unit: g/cm3, status: sourced, source: weighed in water}
brass: {density: 8.5 g/cm3}
"""


def grains_of(text: str) -> Material:
    found = load_protocol(text).scene.grains.material
    assert isinstance(found, Material)
    return found


def mistake_of(text: str | Path, *sets: str) -> str:
    with pytest.raises(InputError) as caught:
        load_protocol(text, sets)
    return str(caught.value)


def beside(folder: Path, text: str, catalog: str = METALS, file: str = "materials.yaml") -> Path:
    """Return the path of a protocol with a catalog file beside it."""
    (folder / file).write_text(catalog)
    (folder / "protocol.yaml").write_text(HEAD + text)
    return folder / "protocol.yaml"


def test_values_in_the_protocol_are_si_numbers_with_their_origin() -> None:
    found = grains_of(HEAD + BALLS)
    assert (found.name, found.density, found.youngs_modulus) == ("own", 11300.0, 16e9)
    assert (found.wall_friction, found.grain_friction, found.restitution_grains) == (
        0.3,
        None,
        None,
    )
    origins = {value.path: (value.value, value.source) for value in found.values}
    assert origins["density"] == (11300.0, "given with the scene")
    assert {value.status for value in found.values} == {"assumed"}


def test_an_elastic_constant_that_is_left_out_is_assumed_and_says_so() -> None:
    found = grains_of(HEAD + "scene: {grains: {material: {density: 3 g/cm3}}}\n")
    assert set(found.values[1:]) == set(NOT_STATED.values())
    assert found.poisson_ratio == NOT_STATED["poisson_ratio"].value
    assert all("not stated" in value.source for value in found.values[1:])


@pytest.mark.parametrize(
    "text",
    [
        BALLS,
        "scene: {cavity: {material: {name: oak, density: 0.7 g/cm3}}}\n",
        "scene: {grains: {material: lead}, cavity: {material: pmma, density: 1.2 g/cm3}}\n",
        "vary: {scene.grains.material: [lead, {name: a, density: 3e3}, {name: b, density: 4e3}]}\n",
        "vary: {scene.cavity: [{material: titanium}, {material: {density: 2 g/cm3}}]}\n",
        "scene: {grains: {material: {density: {value: 8, unit: g/cm3, status: sourced, source: ours}}}}\n",
    ],
)
def test_they_survive_the_file(text: str) -> None:
    protocol = load_protocol(HEAD + text)
    again = load_protocol(dump_protocol(protocol))
    assert again == protocol
    assert dump_protocol(again) == dump_protocol(protocol)
    assert conditions(again) == conditions(protocol)


def test_a_file_beside_the_protocol_and_the_same_values_within_it(tmp_path: Path) -> None:
    """A dump needs the file no more."""
    protocol = load_protocol(beside(tmp_path, "scene: {grains: {material: my_lead}}\n"))
    found = protocol.scene.grains.material
    assert found == read_materials(tmp_path / "materials.yaml")["my_lead"]
    assert (str(found), getattr(found, "label", "")) == ("my_lead", "shot of the workshop")
    (tmp_path / "materials.yaml").unlink()
    assert load_protocol(dump_protocol(protocol)) == protocol


def test_names_in_an_axis_a_claim_and_on_the_command_line(tmp_path: Path) -> None:
    path = beside(
        tmp_path,
        "vary: {scene.grains.material: [my_lead, stainless]}\n"
        "expect: [{claim: heavier takes more, order: scene.grains.material, values: [stainless, my_lead]}]\n",
    )
    protocol = load_protocol(path)
    assert [one.scene.grains.density for one in conditions(protocol)] == [11200.0, 7900.0]
    assert protocol.expect[0].values == ("stainless", "my_lead")
    assert load_protocol(dump_protocol(protocol)) == protocol
    one = load_protocol(path, ["scene.grains.material=brass"])
    assert [c.scene.grains.density for c in conditions(one)] == [8500.0]
    assert (
        conditions(load_protocol(path, ["scene.cavity.material=brass"]))[0].scene.cavity.density
        == 8500
    )


def test_ones_own_comes_before_the_catalogs(tmp_path: Path) -> None:
    own = "schema: rig/catalog/1\nlead: {density: 10.9 g/cm3}\n"
    path = beside(tmp_path, "scene: {grains: {material: lead}}\n", own)
    assert conditions(load_protocol(path))[0].scene.grains.density == 10900.0
    bare = conditions(load_protocol(HEAD + "scene: {grains: {material: lead}}\n"))[0]
    assert bare.scene.grains.density == material("lead").density != 10900.0


def test_another_catalog_file(tmp_path: Path) -> None:
    path = beside(tmp_path, "scene: {grains: {material: metals.yaml:brass}}\n", file="metals.yaml")
    assert str(load_protocol(path).scene.grains.material) == "brass"
    assert (
        "2 materials in 'metals.yaml'; allowed: metals.yaml:my_lead, metals.yaml:brass"
        in mistake_of(path, "scene.grains.material=metals.yaml")
    )
    assert "did you mean 'brass'?" in mistake_of(path, "scene.grains.material=metals.yaml:bras")
    assert "no file 'metal.yaml'" in mistake_of(path, "scene.grains.material=metal.yaml")
    path = beside(
        tmp_path,
        "scene: {grains: {material: mine.yaml}}\n",
        "schema: rig/catalog/1\nx: {density: 3e3}\n",
        "mine.yaml",
    )
    assert str(load_protocol(path).scene.grains.material) == "x"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("scene: {grains: {material: leed}}", "protocol:3: scene.grains.material: found 'leed'"),
        ("scene: {grains: {material: leed}}", "did you mean 'lead'?"),
        ("scene: {cavity: {material: aluminum}}", "did you mean 'aluminium'?"),
        ("vary: {scene.cavity.material: [steel, titan]}", "did you mean 'titanium'?"),
        ("scene: {grains: {material: {densty: 3}}}", "material.densty: found the key 'densty'"),
        ("scene: {grains: {material: {densty: 3}}}", "did you mean 'density'?"),
        ("scene: {grains: {material: {youngs_modulus: 3 GPa}}}", "found no density"),
        ("scene: {grains: {material: {density: 3 kg}}}", "material.density: found '3 kg'"),
        ("scene: {grains: {material: {density: -3}}}", "above 0 kg/m^3"),
        ("scene: {grains: {material: {density: 3e3, poisson_ratio: 0.6}}}", "at most 0.5"),
        ("scene: {grains: {material: {density: 3e3, name: ''}}}", "at most 40 letters"),
        ("scene: {grains: {material: [lead]}}", "found a list"),
        ("scene: {grains: {material: null}}", "found nothing"),
        (
            "vary: {scene.grains.material: [{density: 3e3}, {density: 4e3}]}",
            "another material named 'own'",
        ),
        (
            "scene: {grains: {material: lead}, cavity: {material: {name: lead, density: 11e3}}}",
            "another material named 'lead'",
        ),
    ],
)
def test_mistakes(text: str, told: str) -> None:
    assert told in mistake_of(f"{HEAD}{text}\n")


def test_a_name_that_neither_file_nor_catalog_has(tmp_path: Path) -> None:
    path = beside(tmp_path, "scene: {grains: {material: my_led}}\n")
    found = mistake_of(path)
    assert "found 'my_led'; allowed: my_lead, brass, alumina" in found
    assert "did you mean 'my_lead'?" in found


def test_every_mistake_of_the_file_beside_it_once(tmp_path: Path) -> None:
    broken = "schema: rig/catalog/2\na: {densiti: 3}\nb: {density: 3 m}\n"
    path = beside(tmp_path, "vary: {scene.grains.material: [a, b]}\n", broken)
    places = [line.split(": found")[0].rpartition("/")[2] for line in mistake_of(path).splitlines()]
    assert places == [
        "materials.yaml:1: schema",
        "materials.yaml:2: a.densiti",
        "materials.yaml:2: a",
        "materials.yaml:3: b.density",
    ]


def test_the_seed_knows_a_material_by_its_name() -> None:
    """Other elastic constants change no bed, as with a material of the catalog that gets others."""
    plain = conditions(load_protocol(HEAD + "scene: {grains: {material: {density: 3e3}}}\n"))[0]
    stiff = conditions(
        load_protocol(HEAD + "scene: {grains: {material: {density: 3e3, youngs_modulus: 3 GPa}}}\n")
    )[0]
    other = conditions(
        load_protocol(HEAD + "scene: {grains: {material: {name: x, density: 3e3}}}\n")
    )[0]
    assert plain.seed_key == stiff.seed_key != other.seed_key
    assert plain.scene != stiff.scene


def test_a_box_of_the_rigs_material_reseeds_nothing() -> None:
    (bare,) = conditions(load_protocol(HEAD))
    (said,) = conditions(load_protocol(HEAD + "scene: {cavity: {material: null, density: null}}\n"))
    (steel,) = conditions(load_protocol(HEAD + "scene: {cavity: {material: steel}}\n"))
    assert bare == said
    assert bare.seed_key != steel.seed_key
    assert bare.scene.cavity == replace(steel.scene.cavity, material=None, density=None)


def test_the_catalogs_materials_are_there_by_name() -> None:
    """Each is a wall and a ball; the scene keeps the name."""
    for name in names("material"):
        text = f"scene: {{grains: {{material: {name}}}, cavity: {{material: {name}}}}}\n"
        (one,) = conditions(load_protocol(HEAD + text))
        scene: Scene = one.scene
        assert scene.grains.material == scene.cavity.material == name
        assert scene.grains.density == scene.cavity.density == material(name).density
