"""The single mass protocols end to end: what is read from the records is the exact solution, and
the report says so.
"""

from pathlib import Path

import pytest

from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.protocol.load import load_protocol

FOLDER = Path(__file__).parents[2] / "protocols"


@pytest.mark.parametrize("name", ["single_mass_vertical", "single_mass_zero_gravity"])
def test_the_single_mass_follows_its_exact_solution(name: str, tmp_path: Path) -> None:
    """All claims hold, no limit is exceeded, and each condition that is comparable agrees within
    its U.
    """
    protocol = load_protocol(FOLDER / f"{name}.yaml")
    report = run(
        campaign_of(protocol, load_rig(protocol.rig), (FOLDER / f"{name}.yaml").read_text()),
        tmp_path,
    ).document()
    assert {claim["verdict"] for claim in report["claims"]} == {"holds"}
    assert (report["verdict"], report["flags"]) == ("passes", [])
    assert report["ledger"]["closure_max"] < 1e-12
    scores = [row["E_n"] for row in report["conditions"] if row["offset"] is not None]
    assert len(scores) >= 5
    # U is for 95 %; the scale of the instruments is one draw for all
    assert max(map(abs, scores)) < 1.5
