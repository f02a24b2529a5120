"""Protocols: what a file means, the grid, command-line edits, and seeds that hang on content."""

import dataclasses
from pathlib import Path

import pytest

from rig.errors import InputError
from rig.protocol.grid import conditions as conditions_of
from rig.protocol.load import dump_protocol, load_protocol, protocol_template, read_protocol
from rig.protocol.spec import Drive, Grains, Protocol, Repeats, Scene, Vary

LEAST = "schema: rig/protocol/1\nname: least\n"
CONTRACT = """
schema: rig/protocol/1
rig: paper
name: fill_rate
question: Does the energy dissipated per cycle peak at 90 % fill?
scene:
  cavity: {length: 150 mm, width: 150 mm, height: 400 mm, wall: 5 mm}
  axis: horizontal
  grains: {material: stainless, diameter: 4 mm, fill: 85 %}
  bed: layers
  losses: [noise, air]
  support: none
  layers: {clearance: 1, spread: 0.5, rows: 8, side_walls: false}
drive: {mode: prescribed, frequency: 20 Hz, acceleration: 5 m/s^2}
acquire: {analyzer: INV-3118, samples_per_cycle: 500, settle: 10 cycles, record: 40 cycles, sensors: {force: 208C03, acceleration: 352C33}}
vary:
  scene.grains.fill: [0 %, 10 %, 30 %, 50 %, 70 %, 80 %, 85 %, 90 %, 95 %, 100 %]
  drive.acceleration: [2 m/s^2, 3 m/s^2, 4 m/s^2, 5 m/s^2]
repeats: {n: 4, refill: true}
seed: 2015
faults: []
"""


def seeds(protocol: Protocol) -> dict[tuple[float, float], str]:
    return {
        (c.scene.grains.fill, c.drive.acceleration): c.seed_key for c in conditions_of(protocol)
    }


def test_the_protocol_of_the_contract() -> None:
    protocol = load_protocol(CONTRACT)
    fills = (0.0, 0.1, 0.3, 0.5, 0.7, 0.8, 0.85, 0.9, 0.95, 1.0)
    levels = (2.0, 3.0, 4.0, 5.0)
    assert protocol == Protocol(
        name="fill_rate",
        rig="paper",
        question="Does the energy dissipated per cycle peak at 90 % fill?",
        vary=(
            Vary(("scene.grains.fill",), tuple((fill,) for fill in fills)),
            Vary(("drive.acceleration",), tuple((level,) for level in levels)),
        ),
    )
    conditions = conditions_of(protocol)
    assert [c.id for c in conditions[:2]] == ["c01", "c02"]
    assert [(c.scene.grains.fill, c.drive.acceleration) for c in conditions] == [
        (f, a) for f in fills for a in levels
    ]
    assert all(c.scene.grains.density == 7900.0 for c in conditions)


def test_the_least_protocol_is_the_defaults() -> None:
    assert load_protocol(LEAST) == Protocol(name="least")
    assert len(conditions_of(Protocol(name="least"))) == 1


def test_template_is_the_defaults_and_one_axis() -> None:
    protocol = load_protocol(protocol_template())
    assert dataclasses.replace(protocol, vary=()) == Protocol(
        name="my_experiment", question=protocol.question
    )
    assert protocol.vary
    commented = [line for line in protocol_template().splitlines() if "#" in line]
    assert len(commented) > 15


def test_repeats_may_be_a_plain_number() -> None:
    assert load_protocol(f"{LEAST}repeats: 7\n").repeats == Repeats(n=7)
    assert load_protocol(f"{LEAST}repeats: 7\n", sets=["repeats.refill=false"]).repeats == Repeats(
        n=7, refill=False
    )


def test_values_under_zip_vary_together() -> None:
    protocol = load_protocol(
        f"{LEAST}vary:\n  scene.bed: [layers, locked]\n"
        "  zip: {scene.grains.diameter: [2 mm, 4 mm], drive.acceleration: [3, 5]}\n"
        "  zip.more: {drive.frequency: [10, 20], scene.layers.clearance: [0.5, 1]}\n"
    )
    seen = [
        (c.scene.bed, c.scene.grains.diameter, c.drive.acceleration)
        for c in conditions_of(protocol)[::2]
    ]
    assert seen == [
        (bed, d, a) for bed in ("layers", "locked") for d, a in ((0.002, 3.0), (0.004, 5.0))
    ]
    assert load_protocol(dump_protocol(protocol)) == protocol


def test_an_axis_may_hold_lists_and_whole_parts() -> None:
    protocol = load_protocol(
        f"{LEAST}vary:\n  scene.losses: [[noise], [noise, air], []]\n"
        "  scene.grains: [{material: heavy}, {material: alumina, fill: 50 %}]\n"
    )
    assert [c.scene.losses for c in conditions_of(protocol)[::2]] == [
        ("noise",),
        ("noise", "air"),
        (),
    ]
    assert conditions_of(protocol)[1].scene.grains == Grains("alumina", 0.004, 0.5, 3400.0)
    assert load_protocol(dump_protocol(protocol)) == protocol


def test_density_from_the_catalog_unless_given() -> None:
    text = f"{LEAST}scene: {{grains: {{material: heavy, density: 15.7 g/cm3}}}}\n"
    assert conditions_of(load_protocol(text))[0].scene.grains.density == 15700.0
    assert (
        conditions_of(load_protocol(text, sets=["scene.grains.density=null"]))[
            0
        ].scene.grains.density
        == 18400.0
    )


def test_seeds_hang_on_content() -> None:
    """More values, other losses, support, instruments, waveform: the bed of a condition stays the
    same bed.
    """
    before = seeds(load_protocol(CONTRACT))
    assert len(set(before.values())) == len(before)
    more = load_protocol(
        CONTRACT, varies=["scene.grains.fill=[0.2, 0.85, 0.9]", "drive.acceleration=[1, 5]"]
    )
    assert seeds(more)[0.85, 5.0] == before[0.85, 5.0]
    for change in (
        "scene.losses=[]",
        "scene.support=cords",
        "drive.imperfection=none",
        "acquire.analyzer=ideal",
        "acquire.record=80 cycles",
        "scene.grains.density=7.9 g/cm3",
        "seed=1",
    ):
        assert seeds(load_protocol(CONTRACT, sets=[change])) == before, change
    for change in (
        "scene.grains.material=heavy",
        "scene.layers.rows=9",
        "drive.frequency=21 Hz",
        "scene.bed=locked",
    ):
        assert not set(seeds(load_protocol(CONTRACT, sets=[change])).values()) & set(
            before.values()
        ), change


def test_seeds_do_not_depend_on_how_a_number_is_typed() -> None:
    typed = Protocol("x", drive=Drive(frequency=20, acceleration=5))
    assert conditions_of(typed)[0].seed_key == conditions_of(Protocol("x"))[0].seed_key


def test_set_replaces_and_ends_an_axis() -> None:
    protocol = load_protocol(
        CONTRACT,
        sets=["scene.grains.fill=50 %", "scene.single_mass.gap=none", "scene.cavity.wall=4 mm"],
    )
    assert [axis.paths for axis in protocol.vary] == [("drive.acceleration",)]
    assert (
        protocol.scene.grains.fill,
        protocol.scene.single_mass.gap,
        protocol.scene.cavity.wall,
    ) == (
        0.5,
        "none",
        0.004,
    )
    assert protocol.scene.cavity.length == 0.15


def test_vary_replaces_in_place_or_adds_at_the_end() -> None:
    protocol = load_protocol(
        CONTRACT, varies=["scene.grains.fill=[0.5,0.9]", "scene.bed=[layers, locked]"]
    )
    assert [axis.paths[0] for axis in protocol.vary] == [
        "scene.grains.fill",
        "drive.acceleration",
        "scene.bed",
    ]
    assert protocol.vary[0].rows == ((0.5,), (0.9,))
    zipped = f"{LEAST}vary: {{zip: {{scene.grains.diameter: [2 mm, 4 mm], drive.acceleration: [3, 5]}}}}\n"
    changed = load_protocol(zipped, varies=["drive.acceleration=[1, 2]"])
    assert changed.vary[0].rows == ((0.002, 1.0), (0.004, 2.0))
    assert load_protocol(zipped, sets=["vary.drive.acceleration=[1, 2]"]) == changed
    assert load_protocol(zipped, sets=["drive.acceleration=1"]).vary[0].paths == (
        "scene.grains.diameter",
    )


def test_seed_and_rig_from_the_command_line(tmp_path: Path) -> None:
    mine = tmp_path / "mine.yaml"
    mine.write_text("schema: rig/rig/1\n")
    protocol = load_protocol(CONTRACT, seed=7, rig=str(mine))
    assert (protocol.seed, protocol.rig) == (7, str(mine))


def test_a_rig_path_starts_from_the_protocols_folder(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_text("schema: rig/rig/1\n")
    (tmp_path / "protocol.yaml").write_text(f"{LEAST}rig: mine.yaml\n")
    assert load_protocol(tmp_path / "protocol.yaml").rig == str(tmp_path / "mine.yaml")


def test_the_text_is_kept_verbatim(tmp_path: Path) -> None:
    path = tmp_path / "protocol.yaml"
    path.write_text(CONTRACT)
    loaded = read_protocol(str(path), sets=["seed=1"])
    assert (loaded.text, loaded.path, loaded.protocol.seed) == (CONTRACT, path, 1)
    assert load_protocol(CONTRACT) == load_protocol(path)


def test_aliases_are_expanded() -> None:
    protocol = load_protocol(
        f"{LEAST}vary:\n  scene.grains.fill: &v [0.1, 0.2]\n  scene.layers.clearance: *v\n"
    )
    assert protocol.vary[0].rows == protocol.vary[1].rows


def test_a_protocol_built_in_python_is_checked_too() -> None:
    protocol = Protocol(
        "x", scene=Scene(grains=Grains(fill=1.2)), vary=(Vary(("drive.frequncy",), ((1.0,),)),)
    )
    with pytest.raises(InputError) as caught:
        conditions_of(protocol)
    assert [mistake.field for mistake in caught.value.mistakes] == [
        "scene.grains.fill",
        "vary.drive.frequncy",
    ]
