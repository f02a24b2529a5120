"""The published schema of mapping files beside our own reader, judged by the library jsonschema."""

from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from daq.documents.classes import paths_of
from rig.documents.yaml_reader import read_yaml
from rig.errors import InputError
from rig.importing.mapping import RecordMap, mapping_schema, read_mapping

ROOT = Path(__file__).parents[3]
SCHEMA = Draft202012Validator(mapping_schema())
HEAD = "schema: rig/map/1\nname: x\n"
LEAST = HEAD + "force: {channel: F}\nacceleration: {channel: a}\n"
IN_THE_DOCS = (
    (ROOT / "docs" / "your-own-data.md")
    .read_text(encoding="utf-8")
    .split("```yaml\n")[1]
    .split("```")[0]
)

TAKEN = [
    LEAST,
    IN_THE_DOCS.replace('time: {channel: "t [s]"}', "rate: 5120 Hz"),
    (ROOT / "examples" / "your_own_data" / "map.yaml").read_text(encoding="utf-8"),
    HEAD
    + "force: {channel: 1, unit: mV, sensitivity: 2.25 mV/N, sign: -1}\nacceleration: {channel: 2, unit: g}\n",
    HEAD
    + "force: {channel: F, time_constant: 2 s, delay: -20 us}\nacceleration: {channel: a, time_constant: none}\n",
    LEAST + "rate: 5.12 kHz\nfrequency: 20 Hz\nlength: 10 s\nsteady: {level: 1 %}\n",
    LEAST
    + "time: {channel: t, unit: ms}\ncsv: {delimiter: ';', decimal: ',', skip: 3}\nformat: csv\n",
    LEAST
    + "condition: {bed: locked, bed_mass: 30 kg}\nruns: [{file: a.csv}, {file: b, condition: {id: b}}]\n",
    LEAST + "scene: {grains: {material: stainless, diameter: 4 mm, fill: 85 %}}\n",
]

REFUSED = [
    HEAD,
    LEAST.replace("map/1", "map/9"),
    HEAD + "force: {chanel: F}\nacceleration: {channel: a}\n",
    HEAD + "force: {channel: F, unit: V}\nacceleration: {channel: a}\n",
    HEAD + "force: {channel: F, sensitivity: 2 mV/N}\nacceleration: {channel: a}\n",
    HEAD + "force: {channel: F, sign: 0}\nacceleration: {channel: a}\n",
    HEAD + "force: {channel: F, sign: 2}\nacceleration: {channel: a}\n",
    HEAD + "force: {channel: F}\nacceleration: {channel: a, unit: m/s}\n",
    HEAD + "force: {channel: F, calibration_U: -1 %}\nacceleration: {channel: a}\n",
    LEAST + "rate: 5120 Hz\ntime: {channel: t}\n",
    LEAST + "rate: 5120 kg\n",
    LEAST + "runs: [{fil: b.csv}]\n",
    LEAST + "runs: {file: b.csv}\n",
    LEAST + "condition: {bed: sand}\n",
    LEAST + "scene: {bed: sand}\n",
    LEAST + "format: xls\n",
]


def mistakes(text: str) -> list[str]:
    return [error.message for error in SCHEMA.iter_errors(read_yaml(text, "map", []).plain())]


def test_it_is_a_schema() -> None:
    Draft202012Validator.check_schema(mapping_schema())


@pytest.mark.parametrize("text", TAKEN)
def test_what_the_reader_takes_the_schema_takes(tmp_path: Path, text: str) -> None:
    (tmp_path / "map.yaml").write_text(text, encoding="utf-8")
    read_mapping(tmp_path / "map.yaml")
    assert mistakes(text) == []


@pytest.mark.parametrize("text", REFUSED)
def test_what_the_schema_refuses_the_reader_refuses(tmp_path: Path, text: str) -> None:
    (tmp_path / "map.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError):
        read_mapping(tmp_path / "map.yaml")
    assert mistakes(text)


def test_every_field_is_offered() -> None:
    schema = mapping_schema()
    assert set(schema["properties"]) == {
        path for path in paths_of(RecordMap) if "." not in path
    } | {"schema", "name"}
    for kind in (
        "ForceColumn",
        "AccelerationColumn",
        "Known",
        "RunFile",
        "TimeColumn",
        "CsvText",
        "Steady",
        "Scene",
    ):
        assert schema["$defs"][kind]["additionalProperties"] is False
