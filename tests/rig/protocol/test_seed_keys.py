"""Seeds hang on content under frozen names: every shipped protocol keeps the beds that it had."""

import json
from dataclasses import fields, is_dataclass
from pathlib import Path

from rig.documents.former_names import FORMER_PROTOCOLS
from rig.protocol import shipped
from rig.protocol.grid import conditions
from rig.protocol.load import load_protocol
from rig.protocol.seed_keys import LATER, NO_CONTENT, SCENE
from rig.protocol.spec import Scene

WRITTEN_DOWN = json.loads(
    (Path(__file__).parents[2] / "data" / "seed_keys.json").read_text(encoding="utf-8")
)
"""Protocol -> condition -> its key, as they were when the names of `rig.protocol.seed_keys` were
frozen.
"""


def leaves(part: object, prefix: str = "") -> set[str]:
    """The path of every field in a group that is no group itself."""
    if not is_dataclass(part):
        return {prefix}
    inside = ((item.name, getattr(part, item.name)) for item in fields(part))
    return {
        path
        for name, value in inside
        for path in leaves(value, f"{prefix}.{name}" if prefix else name)
    }


def test_shipped_protocols_keep_their_conditions_and_seeds() -> None:
    """A protocol that is shipped later has no keys here."""
    today = {FORMER_PROTOCOLS.get(name, name): keys for name, keys in WRITTEN_DOWN.items()}
    assert set(today) <= set(shipped.names())
    for name, keys in today.items():
        assert {one.id: one.seed_key for one in conditions(load_protocol(name))} == keys, name


def test_every_field_of_a_scene_seeds_or_is_left_out_on_purpose() -> None:
    seeding = {*SCENE.values(), *(path for path, _ in LATER.values())}
    assert seeding | set(NO_CONTENT) == leaves(Scene())
    assert not seeding & set(NO_CONTENT)
