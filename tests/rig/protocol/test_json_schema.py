"""The published schemas beside our own readers, judged by the library jsonschema, which knows
nothing of them.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from jsonschema import Draft202012Validator
from strategies import scenes
from test_protocol_mistakes import LEAST, test_one_mistake
from typer.testing import CliRunner

from analysis.report.json_schema import REPORT, report_schema
from daq.documents.classes import paths_of
from daq.documents.shapes import deviations
from rig.cli.app import app
from rig.documents.yaml_reader import read_yaml
from rig.errors import InputError
from rig.protocol.claims import KINDS
from rig.protocol.grid import expand
from rig.protocol.load import dump_protocol, load_protocol, protocol_schema, protocol_template
from rig.protocol.spec import Protocol, Scene

ROOT = Path(__file__).parents[3]
SCHEMA = Draft202012Validator(protocol_schema())
SHIPPED = [*sorted((ROOT / "protocols").rglob("*.yaml"))]


def data_of(text: str) -> Any:
    return read_yaml(text, "protocol", []).plain()


def complaints(text: str) -> list[str]:
    return [f"{error.json_path}: {error.message}" for error in SCHEMA.iter_errors(data_of(text))]


def test_the_schemas_are_schemas() -> None:
    Draft202012Validator.check_schema(protocol_schema())
    Draft202012Validator.check_schema(dict(report_schema()))


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_every_shipped_protocol_fits_as_written_and_in_full(path: Path) -> None:
    assert complaints(path.read_text(encoding="utf-8")) == []
    assert complaints(dump_protocol(load_protocol(path))) == []


def test_the_template_fits() -> None:
    assert complaints(protocol_template()) == []


@settings(max_examples=20, deadline=None)
@given(scenes("single_mass"))
def test_what_the_reader_takes_the_schema_takes(scene: Scene) -> None:
    assert complaints(dump_protocol(Protocol(name="drawn", scene=scene))) == []


SPELLINGS = [
    "scene: {cavity: {length: 15 cm, width: '  .15 m ', height: 1.5e2mm}}",
    "scene: {grains: {fill: 85%, diameter: 0.004}}",
    "scene: {grains: {material: lead}, cavity: {material: null, density: 2.7 g/cm3}}",
    "scene: {cavity: {material: {density: 2.7 g/cm3, poisson_ratio: {value: 33, unit: '%', status: sourced}}}}",
    "vary: {scene.grains.material: [lead, {name: x, density: 3000}]}",
    "scene: {single_mass: {gap: none, velocity: -1 mm/s}}",
    "scene: {losses: []}",
    "scene: {dashpot: {c: 5 N*s/m}}",
    "scene: {layers: {rows: 8.0}}",
    "acquire: {coupling: AC, ranges: auto}",
    "acquire: {coupling: IEPE, ranges: {force: 10 V, acceleration: null}}",
    "acquire: {samples_per_cycle: 600, settle: 10 cycles, record: 1e1 cycles}",
    "repeats: 3",
    "repeats: {n: 3, refill: false}",
    "fidelity: auto\ntolerance: 2 %",
    "vary: {zip.ends: {scene.grains.fill: [0.5, 60 %], drive.frequency: [20 Hz, 0.03 kHz]}}",
    "vary: {scene.grains: [{fill: 0.5}, {fill: 0.6}]}",
    "faults: [{kind: spike, channel: force, start: 3 cycles, size: -50 %}, {kind: stuck, channel: force, start: 0}]",
    "deliberate_error: {skew: 2 samples}",
    "expect: [{claim: it peaks, optimum: scene.grains.fill, value: [80 %, 90 %], at: {drive.acceleration: 5}}]",
    "expect: [{claim: about 7, offset_within: [5 %, 0.09], per: scene.grains.material, imposed: put in}]",
]


@pytest.mark.parametrize("text", SPELLINGS)
def test_every_spelling_that_the_reader_takes(text: str) -> None:
    load_protocol(LEAST + text + "\n")
    assert complaints(LEAST + text + "\n") == []


def mistakes() -> Iterator[str]:
    """The bad protocols that the reader's own tests hold."""
    (mark,) = (mark for mark in test_one_mistake.pytestmark if mark.name == "parametrize")
    return (text for text, _ in mark.args[1])


LEFT_TO_CHECK = (
    "mode: shaker",
    "fidelity",
    "tolerance: 1 %",
    "diameter: 200 mm",
    "fill: 0.1 %",
    "diameter: 1 um",
    "guide",
    "bed: grains",
    "- grains",
    "friction: 0.3",
    "start: 6 mm",
    "gap: 500 mm",
    "{axis: vertical}",
    "frequency: 5 kHz",
    "frequency: 1e-6",
    "samples_per_cycle: 400",
    "record: 10000000",
    "stainles}",
    "INV3118",
    "force: 352C33",
    "[layers], drive.frequency",
    "[{}], scene",
    "- 10.0",
    "rig: ",
    "repeats: 10000",
    "'150'",
    "mHz",
    "1.5 cycles",
    ".nan",
)
"""What a schema cannot say: fields that do not fit each other, catalog names, sizes of numbers in
text, no JSON.
"""


def test_the_schema_refuses_what_the_reader_refuses() -> None:
    """Over every mistake of the reader's own tests, but for those that need several fields, a
    catalog or a file.
    """
    refused, left = [], []
    for text in mistakes():
        whole = f"{LEAST}{text}\n"
        with pytest.raises(InputError):
            load_protocol(whole)
        (refused if complaints(whole) else left).append(text)
    assert [text for text in left if not any(part in text for part in LEFT_TO_CHECK)] == []
    assert len(refused) > 40


MUTATIONS = [
    ("scene", "sceen"),
    ("fill: 85 %", "fill: 850"),
    ("20 Hz", "20 kg"),
    ("20 Hz", "-20 Hz"),
    ("20 Hz", "0 Hz"),
    ("bed: layers", "bed: layer"),
    ("losses: [noise, air]", "losses: [noise, noise]"),
    ("seed: 2015", "seed: -1"),
    ("n: 4", "n: 0"),
    ("n: 4", "n: 2.5"),
    ("refill: true", "refill: 1"),
    ("optimum: scene", "optimum: sceen"),
    ("margin: 2 %", "margin: -2 %"),
    ("[0 %, 14 %]", "[0 %]"),
    ("from: 0 %", "form: 0 %"),
    ("name: fill_rate", "name: fill rate"),
    ("rig/protocol/1", "rig/protocol/2"),
    ("150 mm", "150"),
    ("[2 m/s^2, 3 m/s^2, 4 m/s^2, 5 m/s^2]", "2 m/s^2"),
    ("rise: scene.grains.fill", "riise: scene.grains.fill"),
    ("axis: horizontal", "axis: sideways"),
    ("mode: prescribed", "mode: srevo"),
    ("settle: 10", "settle: no"),
]


@pytest.mark.parametrize(("right", "wrong"), MUTATIONS)
def test_a_mutated_protocol_fails_in_both(right: str, wrong: str) -> None:
    text = (ROOT / "protocols" / "fill_rate.yaml").read_text(encoding="utf-8")
    mutated = text.replace(right, wrong)
    assert mutated != text
    with pytest.raises(InputError):
        load_protocol(mutated)
    assert complaints(mutated)


def test_every_field_and_every_kind_of_claim_is_in_the_schema() -> None:
    """So that an editor offers them: each path under scene, drive and acquire is an axis, each kind
    a key.
    """
    schema = protocol_schema()
    axes = schema["properties"]["vary"]["properties"]
    parts = {
        path
        for path in paths_of(Protocol)
        if path.partition(".")[0] in ("scene", "drive", "acquire")
    }
    assert set(axes) == parts
    assert set(KINDS) <= set(schema["properties"]["expect"]["items"]["properties"])
    for reference in axes.values():
        found: Any = schema
        for name in reference["items"]["$ref"].removeprefix("#/").split("/"):
            found = found[name]
        assert found


def test_defaults_are_the_protocols_own() -> None:
    """A protocol with every default of the schema written out is the protocol with none of them."""
    schema = protocol_schema()

    def filled(part: dict[str, Any]) -> Any:
        if "$ref" in part:
            return filled(schema["$defs"][part["$ref"].rpartition("/")[2]])
        if "default" in part:
            return part["default"]
        if "anyOf" in part:
            return filled(part["anyOf"][0])
        return {
            name: filled(inner) for name, inner in part["properties"].items() if name != "density"
        }

    data = {name: filled(schema["properties"][name]) for name in ("scene", "drive", "acquire")}
    written = load_protocol(json.dumps({"schema": "rig/protocol/1", "name": "least", **data}))
    assert expand(written) == expand(load_protocol(LEAST))


def test_the_command_prints_and_writes(tmp_path: Path) -> None:
    call = CliRunner().invoke
    for kind, schema in (("protocol", protocol_schema()), ("report", report_schema())):
        assert json.loads(call(app, ["schema", kind]).stdout) == schema
        path = tmp_path / f"{kind}.json"
        assert call(app, ["schema", kind, "--out", str(path)]).exit_code == 0
        assert json.loads(path.read_text(encoding="utf-8")) == schema
    assert call(app, ["schema", "protocol", "--out", str(tmp_path / "report.json")]).exit_code == 2
    wrong = call(app, ["schema", "protocoll"])
    assert wrong.exit_code == 2
    assert "did you mean 'protocol'?" in wrong.stderr


def report_complaints(report: Any) -> list[str]:
    """What jsonschema and our own check of shapes say of a report; they agree."""
    found = [
        error.json_path for error in Draft202012Validator(dict(report_schema())).iter_errors(report)
    ]
    assert bool(found) == bool(list(deviations(report, REPORT)))
    return found


def test_a_report_of_anything_else_is_refused() -> None:
    assert report_complaints({})
    assert report_complaints([])
