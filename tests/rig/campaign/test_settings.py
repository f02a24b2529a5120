"""Values that the paper does not state are listed as assumed, with those that a protocol uses."""

from rig.campaign.open_settings import OPEN, assumed_settings
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
