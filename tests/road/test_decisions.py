"""What `rig check` says of claims before anything is measured: whether they can be decided, and by
how many repeats.
"""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from rig.campaign.preflight.decisions import Decision
from rig.campaign.preflight.outlook import decided, preflight
from rig.campaign.resolve import campaign_of
from rig.catalog.rig_file import load_rig
from rig.cli.app import app
from rig.protocol import shipped
from rig.protocol.load import load_protocol

TEXT = """\
schema: rig/protocol/1
name: decided
scene: {grains: {material: stainless, diameter: 8 mm, fill: 85 %}, layers: {rows: 8}}
acquire: {settle: 4 cycles, record: 4 cycles}
vary: {drive.acceleration: [3 m/s^2, 3.1 m/s^2, 4 m/s^2]}
repeats: 2
expect:
  - {claim: within the certificates, offset_within: [11 %, 13 %]}
  - {claim: wide, offset_within: [-50 %, 100 %]}
  - {claim: far away, offset_within: [100 %, 200 %]}
  - {claim: the largest level, optimum: drive.acceleration, value: 4 m/s^2}
  - {claim: not the largest, optimum: drive.acceleration, value: 3 m/s^2}
  - {claim: a small step, rise: drive.acceleration, from: 3 m/s^2, to: 3.1 m/s^2}
"""


def told(source: str | Path, sets: tuple[str, ...] = ()) -> list[Decision]:
    protocol = load_protocol(source, sets)
    campaign = campaign_of(protocol, load_rig(protocol.rig))
    return decided(campaign, list(preflight(campaign, 1)))


def test_claims_are_decided_by_the_repeats_that_they_need():
    """Certificates alone leave U = 1.6 %: no repeats tell an offset within 1 %. A level 3 % above
    another takes 10 % more, which two refills that scatter by as much do not tell and more do."""
    found = {one.claim: one for one in told(TEXT)}
    assert found["within the certificates"].repeats is None
    assert found["within the certificates"].verdict == "undecided"
    assert found["within the certificates"].why.startswith("U = ")
    clear = {name: (found[name].verdict, found[name].repeats) for name in list(found)[1:5]}
    assert clear == {
        "wide": ("holds", 2),
        "far away": ("does not hold", 2),
        "the largest level": ("holds", 2),
        "not the largest": ("does not hold", 2),
    }
    small = found["a small step"]
    assert small.verdict == "undecided"
    assert small.repeats is not None
    enough = {one.claim: one for one in told(TEXT, (f"repeats={small.repeats}",))}["a small step"]
    assert (enough.verdict, enough.repeats) == ("holds", small.repeats)


def test_check_says_it(tmp_path: Path):
    path = tmp_path / "decided.yaml"
    path.write_text(TEXT, encoding="utf-8")
    done = CliRunner().invoke(app, ["check", str(path)], env={"COLUMNS": "200"})
    assert done.exit_code == 0
    assert "not by 100" in done.stdout


@pytest.mark.slow
@pytest.mark.parametrize("name", shipped.names())
def test_every_shipped_claim_can_be_decided(name: str):
    assert [one for one in told(name) if one.repeats is None] == []
