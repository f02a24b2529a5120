"""The shipped protocols: complete, strict, and judged on what they claim."""

import json
from pathlib import Path
from typing import Any

import pytest

from rig.campaign.claim_cases import cases
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.protocol.grid import conditions
from rig.protocol.load import dump_protocol, load_protocol

FOLDER = Path(__file__).parents[2] / "protocols"
FILES = sorted(FOLDER.glob("*.yaml"))
NAMED = {"acceleration", "density", "fill_rate", "frequency", "nulls", "size"}
FEW = ("repeats.n=2", "acquire.record=20 cycles")


def report_of(name: str, out: Path, *sets: str, varies: tuple[str, ...] = ()) -> dict[str, Any]:
    text = (FOLDER / f"{name}.yaml").read_text()
    protocol = load_protocol(FOLDER / f"{name}.yaml", sets, varies)
    report = run(campaign_of(protocol, load_rig(protocol.rig), text), out, workers=2).document()
    assert json.loads((out / "report.json").read_text())["claims"] == report["claims"]
    return report


def test_the_named_protocols_are_there() -> None:
    assert {path.stem for path in FILES} >= NAMED


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_each_is_whole(path: Path) -> None:
    """It says what is asked and what the paper says (a sweep states no energy to claim anything
    of), survives the file, and every claim has all its conditions."""
    text = path.read_text()
    protocol = load_protocol(path)
    assert text.startswith("# ")
    assert protocol.name == path.stem
    assert protocol.question.endswith("?")
    assert load_protocol(dump_protocol(protocol)) == protocol
    claims = cases(protocol, conditions(protocol))
    assert claims or any(condition.drive.sweep_to for condition in conditions(protocol))
    for claim in claims:
        assert claim["cases"], claim["claim"]
        for case in claim["cases"]:
            labels = [level["value"] for level in case["levels"]]
            assert set(claim["values"]) <= set(labels), claim["claim"]


def test_denser_grains_dissipate_more(tmp_path: Path) -> None:
    """W goes as the density: 3.4, 7.9, 18.4; each step is a factor of 2.3 against a scatter of a
    tenth.
    """
    report = report_of(
        "density", tmp_path, *FEW, varies=("drive.acceleration=[1 m/s^2, 2 m/s^2, 3 m/s^2]",)
    )
    order, best, curve, *_ = report["claims"]
    assert (order["verdict"], best["verdict"], best["found"]) == ("holds", "holds", "heavy")
    assert {case["found"] for case in order["cases"]} == {"alumina < stainless < heavy"}
    assert curve["verdict"] == "holds"


def test_one_best_size_for_all_accelerations_is_contradicted(tmp_path: Path) -> None:
    report = report_of(
        "size_acceleration", tmp_path, *FEW, varies=("drive.acceleration=[2 m/s^2, 6 m/s^2]",)
    )
    (claim,) = report["claims"]
    assert claim["verdict"] == "does not hold"
    low, high = claim["cases"]
    assert low["verdict"] == "does not hold"
    assert high["verdict"] != "does not hold"
    assert "W_T is largest at 2 mm" in low["why"]
    assert "W_T is largest at 5 mm" in high["why"]
    assert report["verdict"] == "passes"


def test_fill_and_the_empty_box(tmp_path: Path) -> None:
    """Losses of the box stay when the grains are gone; without such losses the empty box is nearly
    zero.
    """
    fills = ("scene.grains.fill=[0, 30 %, 90 %, 100 %]",)
    lossy = report_of("fill_rate", tmp_path / "a", *FEW, varies=fills)
    bare = report_of("fill_rate", tmp_path / "b", *FEW, "scene.losses=[]", varies=fills)
    for report in (lossy, bare):
        best, _, rise, fall, *_ = report["claims"]
        assert [best["found"], best["verdict"], rise["verdict"], fall["verdict"]] == [
            "0.90",
            "holds",
            "holds",
            "holds",
        ]
    assert lossy["claims"][4]["verdict"] == "does not hold"
    assert bare["claims"][4]["verdict"] == "holds"


def test_nulls_and_references_hold(tmp_path: Path) -> None:
    report = report_of("nulls", tmp_path, *FEW)
    assert [(null["null"], null["verdict"]) for null in report["nulls"]] == [
        ("locked", "holds"), ("loop-back", "holds"),
    ]  # fmt: skip
    assert [row["reference"] for row in report["references"]] == [
        "signs", "rigid mass", "rigid mass", "dashpot", "phase",
    ]  # fmt: skip
    assert all(row["verdict"] == "holds" for row in report["references"])
    assert report["verdict"] == "passes"


def test_a_claim_about_what_was_taken_away_is_undecided(tmp_path: Path) -> None:
    report = report_of("nulls", tmp_path, *FEW, "scene.bed=empty")
    assert [claim["verdict"] for claim in report["claims"]] == ["undecided"]
