"""Names of the first edition are errors that tell today's, wherever a user writes them."""

from pathlib import Path

import pytest

from rig import load_protocol, load_rig
from rig.documents.former_names import FORMER_NAMES, FORMER_PROTOCOLS, FORMER_RIGS
from rig.errors import InputError
from rig.importing.mapping import read_mapping

HEAD = "schema: rig/protocol/1\nname: x\n"


@pytest.mark.parametrize(
    ("text", "sets", "varies", "new"),
    [
        ("drive: {mode: servo}\n", (), (), "prescribed"),
        ("drive: {mode: coupled}\n", (), (), "shaker"),
        ("scene: {bed: slug}\n", (), (), "single_mass"),
        ("scene: {slug: {restitution: 0}}\n", (), (), "single_mass"),
        ("scene: {layers: {play: 1}}\n", (), (), "clearance"),
        ("mistake: {skew: 1}\n", (), (), "deliberate_error"),
        ("acquire: {allow_undersampled: true}\n", (), (), "paper_rule"),
        ("vary: {scene.layers.play: [1, 2]}\n", (), (), "scene.layers.clearance"),
        ("vary: {scene.bed: [slug, locked]}\n", (), (), "single_mass"),
        (
            "vary: {zip: {scene.slug.gap: [1 mm], drive.acceleration: [1]}}\n",
            (),
            (),
            "scene.single_mass.gap",
        ),
        ("", ("drive.mode=servo",), (), "prescribed"),
        ("", ("scene.layers.play=1",), (), "clearance"),
        ("", ("scene.slug.gap=1 mm",), (), "single_mass"),
        ("", ("mistake.skew=1",), (), "deliberate_error"),
        ("", (), ("scene.bed=[slug, layers]",), "single_mass"),
        ("", (), ("scene.layers.play=[1, 2]",), "clearance"),
        ("rig: default\n", (), (), "paper"),
    ],
)
def test_an_old_name_in_a_protocol_is_an_error_that_states_the_new_one(
    text: str, sets: tuple[str, ...], varies: tuple[str, ...], new: str
) -> None:
    with pytest.raises(InputError, match=rf"renamed: write '[a-z.]*{new}'"):
        load_protocol(HEAD + text, sets, varies)


def test_an_old_name_in_a_rig_file_is_an_error_that_states_the_new_one(tmp_path: Path) -> None:
    file = tmp_path / "rig.yaml"
    file.write_text("schema: rig/rig/1\nname: mine\nrefill_play: 0.1\n")
    with pytest.raises(InputError, match="renamed: write 'refill_clearance'"):
        load_rig(file)


def test_an_old_name_in_a_mapping_is_an_error_that_states_the_new_one(tmp_path: Path) -> None:
    file = tmp_path / "map.yaml"
    file.write_text(
        "schema: rig/map/1\nname: lab\nforce: {channel: '1'}\nacceleration: {channel: '2'}\n"
        "scene: {bed: slug}\n"
    )
    with pytest.raises(InputError, match="renamed: write 'single_mass'"):
        read_mapping(file)


@pytest.mark.parametrize(("old", "new"), FORMER_PROTOCOLS.items())
def test_an_old_protocol_name_is_an_error_that_states_the_new_one(old: str, new: str) -> None:
    for source in (old, f"protocols/{old}.yaml", f"{old}.yaml"):
        with pytest.raises(InputError, match=rf"renamed: write '[a-z.]*{new}'"):
            load_protocol(source)


def test_every_new_name_is_there() -> None:
    """And no old one is taken by something else."""
    assert not FORMER_NAMES.keys() & set(FORMER_NAMES.values())
    for old, new in FORMER_RIGS.items():
        assert load_rig(new).name == new
        with pytest.raises(InputError, match=rf"renamed: write '[a-z.]*{new}'"):
            load_rig(old)
    for new in FORMER_PROTOCOLS.values():
        assert load_protocol(new).name == new
