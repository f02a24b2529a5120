"""The report as report.json: made from the classes, read back exactly, refused with the place where
it is damaged.
"""

import json
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from page_report import demo_report

from analysis import AnalysisError, Report, compare, read_report, write_report
from analysis.report.json_schema import COMPARED, REPORT, comparison_schema, report_schema
from analysis.results.comparison_rows import Comparison
from daq.documents.shapes import Each, Either, Keys, List, Shape, deviations

DEMO = demo_report()
DOCUMENT = DEMO.document()
TEXT = json.dumps(DOCUMENT)


def test_there_and_back_is_the_identity() -> None:
    found = Report.of(json.loads(TEXT))
    assert found == DEMO
    assert json.dumps(found.document()) == TEXT  # keys in their order, too


def test_the_schema_of_the_classes_accepts_it() -> None:
    assert list(deviations(DOCUMENT, REPORT)) == []
    assert list(Draft202012Validator(dict(report_schema())).iter_errors(DOCUMENT)) == []
    other = [replace(row, W_exp=1.1 * row.W_exp) for row in DEMO.conditions]
    compared = compare(DEMO, replace(DEMO, conditions=tuple(other))).document()
    assert list(deviations(compared, COMPARED)) == []
    assert list(Draft202012Validator(dict(comparison_schema())).iter_errors(compared)) == []
    assert Comparison.of(json.loads(json.dumps(compared))).document() == compared


def places(
    value: Any, shape: Shape, path: tuple[str | int, ...] = ()
) -> Iterator[tuple[str | int, ...]]:
    """Where required keys stand in a document; of a list the first place."""
    match shape:
        case Keys() if isinstance(value, dict):
            for key, part in {**shape.required, **shape.optional}.items():
                if key in shape.required:
                    yield (*path, key)
                if key in value:
                    yield from places(value[key], part, (*path, key))
        case List() if isinstance(value, list) and value:
            yield from places(value[0], shape.item, (*path, 0))
        case Each() if isinstance(value, dict) and value:
            name = next(iter(value))
            yield from places(value[name], shape.item, (*path, name))
        case Either():
            yield from places(value, shape.second, path)


PLACES = sorted(places(DOCUMENT, REPORT), key=str)


def named(path: tuple[str | int, ...]) -> str:
    told = "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in path)
    return told.removeprefix(".")


def test_there_are_many_places() -> None:
    """Conditions, their runs and budgets, the agreement and its line, nulls, references, waveforms
    among them.
    """
    assert len(PLACES) > 150


@given(st.sampled_from(PLACES))
def test_a_missing_key_is_refused_with_its_place(path: tuple[str | int, ...]) -> None:
    damaged = json.loads(TEXT)
    inner = damaged
    for step in path[:-1]:
        inner = inner[step]
    del inner[path[-1]]
    with pytest.raises(AnalysisError) as caught:
        Report.of(damaged)
    assert str(caught.value) == f"report.json: {named(path)} is missing"


@given(st.sampled_from(PLACES))
def test_a_value_of_a_wrong_kind_is_refused_with_its_place(path: tuple[str | int, ...]) -> None:
    damaged = json.loads(TEXT)
    inner = damaged
    for step in path[:-1]:
        inner = inner[step]
    inner[path[-1]] = "a" if isinstance(inner[path[-1]], bool) else True
    with pytest.raises(AnalysisError) as caught:
        Report.of(damaged)
    assert str(caught.value).startswith(f"report.json: {named(path)} is ")


def test_a_report_is_read_back_from_its_folder(tmp_path: Path) -> None:
    write_report(DEMO, tmp_path, figures=False)
    assert read_report(tmp_path) == read_report(tmp_path / "report.json") == DEMO
    (tmp_path / "report.json").write_text(TEXT[:-1])
    with pytest.raises(AnalysisError, match="is no JSON"):
        read_report(tmp_path)
    (tmp_path / "report.json").write_text(json.dumps({**DOCUMENT, "verdict": "maybe", "later": 1}))
    with pytest.raises(
        AnalysisError, match=r"report\.json: verdict is 'maybe', expected one of passes, fails"
    ):
        read_report(tmp_path)


def test_keys_of_later_versions_are_passed_over() -> None:
    assert Report.of({**DOCUMENT, "later": {"x": 1}}) == DEMO


def test_older_reports_lack_what_came_later() -> None:
    later = ("comparisons", "failures", "support", "waveforms")
    found = Report.of({name: value for name, value in DOCUMENT.items() if name not in later})
    assert (found.comparisons, found.failures, found.support, found.waveforms) == ((), (), (), None)


def test_no_number_in_it_is_without_end() -> None:
    row = replace(DEMO.conditions[0], nu=math.inf, M_eff=math.nan)
    text = json.dumps(replace(DEMO, conditions=(row,)).document(), allow_nan=False)
    assert json.loads(text)["conditions"][0]["nu"] is None
