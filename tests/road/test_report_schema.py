"""Reports of real runs fit the published schema, whatever the run was."""

import json
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator
from small_protocol import SMALL

from analysis import Report
from analysis.report.json_schema import REPORT, report_schema
from daq.documents.shapes import deviations
from rig import load_protocol, run

ROOT = Path(__file__).parents[2]
FEW = ("repeats=2", "acquire.record=20 cycles")


def cases() -> dict[str, tuple[str | Path, tuple[str, ...], tuple[str, ...]]]:
    """Protocol, values set and axes: nulls, claims, a deliberate error, a chosen fidelity, the exciter in
    the loop.
    """
    protocols = ROOT / "protocols"
    fills = ("scene.grains.fill=[0, 0.5, 0.9]", "drive.acceleration=[3, 5]")
    return {
        "small": (SMALL, (), ()),
        "claims": (protocols / "fill_rate.yaml", FEW, fills),
        "deliberate_error": (protocols / "gallery" / "skew.yaml", FEW, ()),
        "fidelity": (
            SMALL,
            ("fidelity=auto", "tolerance=5 %"),
            ("scene.bed=[layers]", "drive.acceleration=[3]"),
        ),
        "shaker": (
            SMALL,
            ("drive.mode=shaker", *FEW),
            ("scene.bed=[locked]", "drive.acceleration=[2]"),
        ),
    }


@pytest.mark.parametrize("name", cases())
def test_a_report_fits(name: str, tmp_path: Path) -> None:
    source, sets, varies = cases()[name]
    run(load_protocol(source, sets, varies), tmp_path)
    report = json.loads((tmp_path / "report.json").read_text(encoding="utf-8"))
    assert [
        error.message for error in Draft202012Validator(dict(report_schema())).iter_errors(report)
    ] == []
    assert list(deviations(report, REPORT)) == []
    assert json.dumps(Report.of(report).document()) == json.dumps(report)
    del report["conditions"][0]["W_exp"]
    assert list(Draft202012Validator(dict(report_schema())).iter_errors(report))
    assert list(deviations(report, REPORT)) == ["conditions[0].W_exp is missing"]
