"""What the shipped rig file was identified for: the ratio of the density protocol, with and without
its losses.
"""

from pathlib import Path

import pytest

from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.protocol.load import load_protocol

PROTOCOL = Path(__file__).resolve().parents[2] / "protocols" / "density.yaml"


@pytest.mark.parametrize(
    ("sets", "ratio", "margin"),
    [((), 1.07, 0.005), (("scene.losses=[]",), 1.0, 0.01)],
    ids=["losses", "none"],
)
def test_the_ratio_is_put_in_by_the_losses_alone(
    tmp_path: Path, sets: tuple[str, ...], ratio: float, margin: float
) -> None:
    """Margins as promised for the shipped rig file and seed; another seed scatters by 0.027
    (docs/decisions/0004).
    """
    protocol = load_protocol(PROTOCOL, sets)
    report = run(
        campaign_of(protocol, load_rig(protocol.rig), PROTOCOL.read_text()), tmp_path
    ).document()
    assert report["agreement"]["ratio"] == pytest.approx(ratio, abs=margin)
