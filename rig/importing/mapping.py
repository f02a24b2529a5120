"""Mapping files, which state the meaning of the columns in a laboratory's own records. They are read
as strictly as protocols: every mistake is reported.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal

from daq.documents.classes import keys_of, paths_of
from daq.documents.json_schema import document_schema
from daq.documents.notes import Node, Notes
from daq.documents.shapes import List, Shape, Then, one_of
from rig.catalog.own_materials import OwnMaterials
from rig.catalog.rig_file import DEFAULT
from rig.documents.former_names import FORMER_NAMES
from rig.documents.yaml_reader import read_document, read_file, read_yaml
from rig.protocol.spec import Scene
from rig.units import GRAVITY, Quantity

SCHEMA = "rig/map/1"
FORMATS = ("csv", "uff58", "sep005", "tdms", "mat", "hdf5", "wav")
FORCE_UNITS: Mapping[str, float] = {
    "N": 1.0,
    "kN": 1e3,
    "mN": 1e-3,
    "lbf": 4.4482216152605,
    "kgf": GRAVITY,
    "V": 1.0,
    "mV": 1e-3,
}
ACCELERATION_UNITS: Mapping[str, float] = {
    "m/s^2": 1.0,
    "mm/s^2": 1e-3,
    "cm/s^2": 1e-2,
    "in/s^2": 0.0254,
    "ft/s^2": 0.3048,
    "g": GRAVITY,
    "mg": 1e-3 * GRAVITY,
    "V": 1.0,
    "mV": 1e-3,
}
"""Size of each unit in N or m/s^2; volts need a sensitivity. Of each the first is taken where neither
mapping nor file states one.
"""

TIME_UNITS: Mapping[str, float] = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}

VOLTS = ("V", "mV")
ASSUMED_U = 0.01
"""Relative expanded uncertainty (k = 2) of a sensitivity where the mapping states none: a usual
certificate's.
"""

Sign = Annotated[int, Quantity("number", -1, 1)]
Share = Annotated[float, Quantity("number", 0.0, 1.0)]
Stated = Annotated[float | None, Quantity("number", 0.0, 1.0)]
Duration = Annotated[float, Quantity("time", 0.0, 1e9)]
Delay = Annotated[float, Quantity("time", -1.0, 1.0)]
Pole = Annotated[float | Literal["none"], Quantity("time", 0.0, 1e9, above=True)]
Mass = Annotated[float, Quantity("mass", 0.0, 1e6)]


@dataclass(frozen=True)
class Column:
    """Fields that the columns of force and acceleration have in common. `sign`: -1 if the file
    counts the other direction as positive. `calibration_U`: relative expanded uncertainty of the
    sensitivity, k = 2, null if not known. `delay`: s by which the channel lags. `scale`: size of 1 in
    the file, in `unit`: whole numbers of a converter need it where the file states none. `overrule`:
    the mapping goes before what the file states of the channel."""

    channel: str
    sign: Sign = 1
    scale: Annotated[float | None, Quantity("number", 0.0, 1e12, above=True)] = None
    overrule: bool = False
    calibration_U: Stated = None
    gain_tolerance: Share = 0.0
    time_constant: Pole = "none"
    time_constant_spread: Share = 0.1
    delay: Delay = 0.0
    delay_tolerance: Duration = 0.0
    model: str = "not stated"
    serial: str = "not stated"
    direction: str = "+drive"
    calibration_date: str = "not stated"


@dataclass(frozen=True)
class ForceColumn(Column):
    """Column of the force. `sign`: -1 if the file has the force on the gauge's other side. `noise`:
    N rms; null estimates it from the record. `range`: N. `sensitivity`: for a column in volts. `unit`:
    null takes the file's, or newtons where it states none."""

    unit: Annotated[str | None, one_of(*FORCE_UNITS)] = None
    sensitivity: Annotated[float | None, Quantity("force sensitivity", 0.0, 1e6, above=True)] = None
    noise: Annotated[float | None, Quantity("force", 0.0, 1e9)] = None
    range: Annotated[float | None, Quantity("force", 0.0, 1e9, above=True)] = None


@dataclass(frozen=True)
class AccelerationColumn(Column):
    """Column of the acceleration. `noise`: m/s^2 rms; null estimates it from the record. `range`:
    m/s^2. `sensitivity`: for a column in volts. `unit`: null takes the file's, or m/s^2 where it
    states none."""

    unit: Annotated[str | None, one_of(*ACCELERATION_UNITS)] = None
    sensitivity: Annotated[
        float | None, Quantity("acceleration sensitivity", 0.0, 1e6, above=True)
    ] = None
    noise: Annotated[float | None, Quantity("acceleration", 0.0, 1e9)] = None
    range: Annotated[float | None, Quantity("acceleration", 0.0, 1e9, above=True)] = None


@dataclass(frozen=True)
class TimeColumn:
    """A column of sample times: numbers, times of day or time stamps. `unit`: null takes the file's,
    or seconds where it states none.
    """

    channel: str
    unit: Annotated[str | None, one_of(*TIME_UNITS)] = None


@dataclass(frozen=True)
class CsvText:
    """Format of a text file: delimiter of its columns (a blank stands for any run of blanks), decimal
    sign, and `skip`, the number of lines before the header. What is null is found in the file.
    """

    delimiter: str | None = None
    decimal: str | None = None
    skip: Annotated[int | None, Quantity("number", 0, 1000000)] = None


@dataclass(frozen=True)
class Steady:
    """Limits for a steady record: largest change of the fundamental's amplitude (relative) and of
    its phase (rad).
    """

    level: Share = 0.02
    phase: Annotated[float, Quantity("angle", 0.0, 1.0)] = 0.02


@dataclass(frozen=True)
class Known:
    """Facts about a condition that the records do not contain; each may be left out.
    `acceleration`: the level that was set. `bed`: `locked` and `empty` make null tests, `dashpot`
    with `dashpot_c` a reference.
    """

    id: str = "c01"
    bed: Annotated[str, one_of("unknown", "empty", "locked", "dashpot", "grains")] = "unknown"
    material: str = "not stated"
    density: Annotated[float | None, Quantity("density", 0.0, 30000.0, above=True)] = None
    diameter: Annotated[float | None, Quantity("length", 0.0, 0.5, above=True)] = None
    fill: Annotated[float | None, Quantity("number", 0.0, 1.0)] = None
    bed_mass: Mass = 0.0
    box_mass: Mass = 0.0
    gauge_mass: Mass = 0.0
    moving_mass: Mass = 0.0
    acceleration: Annotated[float | None, Quantity("acceleration", 0.0, 10000.0, above=True)] = None
    dashpot_c: Annotated[float | None, Quantity("damping", 0.0, 1e9)] = None


@dataclass(frozen=True)
class RunFile:
    """One record: its file, in the folder given on the command line, its condition, and the time
    left out at its start.
    """

    file: str
    condition: Known = Known()
    settle: Annotated[float | None, Quantity("time", 0.0, 1e9)] = None


@dataclass(frozen=True)
class RecordMap:
    """A mapping. `rate`: Hz; null takes it from the file or its time column. `frequency`: of the
    drive, Hz; null finds it in the record. `settle`: s left out at the start. `length`: s used
    after that; null uses all. `scene`: if stated, W_T is predicted for it.
    """

    name: str
    force: ForceColumn
    acceleration: AccelerationColumn
    schema: str = SCHEMA
    question: str = ""
    format: Annotated[str, one_of("", *FORMATS)] = ""
    csv: CsvText = CsvText()
    rate: Annotated[float | None, Quantity("rate", 0.0, 1e9, above=True)] = None
    time: TimeColumn | None = None
    frequency: Annotated[float | None, Quantity("frequency", 0.0, 1e6, above=True)] = None
    settle: Duration = 0.0
    length: Annotated[float | None, Quantity("time", 0.0, 1e9, above=True)] = None
    steady: Steady = Steady()
    condition: Known = Known()
    rig: str = DEFAULT
    scene: Scene | None = None
    runs: tuple[RunFile, ...] = ()


@dataclass(frozen=True)
class LoadedMap:
    """A mapping, its text, its file, and where each field was written."""

    mapping: RecordMap
    text: str
    path: Path
    places: Mapping[str, str] = field(default_factory=dict)


def read_mapping(path: Path) -> LoadedMap:
    """Return the mapping in a file. Raises InputError with every mistake."""
    text = read_file(path)
    notes = Notes(
        known=tuple(paths_of(RecordMap)), renamed=FORMER_NAMES, meaning=OwnMaterials(path.parent)
    )
    root = _with_common(read_yaml(text, str(path), notes.mistakes))
    return LoadedMap(read_document(mapping_shape(), root, notes), text, path, notes.places)


def mapping_schema() -> dict[str, Any]:
    """Return the JSON Schema of a mapping file; checks against the record are left to `rig import`."""
    return document_schema(mapping_shape(), f"Mapping of a laboratory's own records, {SCHEMA}")


def mapping_shape() -> Then:
    """Return the shape of a mapping file."""
    whole = keys_of(RecordMap)
    schema = one_of(SCHEMA)
    volts = {"required": ["unit"], "properties": {"unit": {"enum": list(VOLTS)}}}
    stated = {"required": ["sensitivity"], "properties": {"sensitivity": {"not": {"type": "null"}}}}
    rule = {
        "properties": {"sign": {"not": {"const": 0}}},
        "if": volts,
        "then": stated,
        "else": {"not": stated},
    }
    columns = {
        name: Then(whole.required[name], _check_column, rule) for name in ("force", "acceleration")
    }
    others: dict[str, Shape] = {
        "csv": Then(whole.optional["csv"], _check_csv),
        "runs": List(keys_of(RunFile), what="mappings with file"),
    }
    optional = {
        key: others.get(key, shape) for key, shape in whole.optional.items() if key != "schema"
    }
    known = replace(
        whole, required={"schema": schema, **whole.required, **columns}, optional=optional
    )
    both = {"required": ["rate", "time"], "properties": {"rate": {"not": {"type": "null"}}}}
    return Then(known, _check, {"not": both})


def _with_common(root: Node) -> Node:
    """Return the tree with the mapping's own `condition` merged into that of each run, whose own
    values go first.
    """
    if not isinstance(root.value, dict) or not {"runs", "condition"} <= root.value.keys():
        return root
    runs, common = root.value["runs"], root.value["condition"]
    if not isinstance(runs.value, tuple):
        return root
    merged = Node(runs.where, tuple(_with(run, common) for run in runs.value))
    return Node(root.where, {**root.value, "runs": merged}, key_places=root.key_places)


def _with(run: Node, common: Node) -> Node:
    """Return a run with the common values of its condition."""
    if not isinstance(common.value, dict) or not isinstance(run.value, dict):
        return run
    own = run.value.get("condition", Node(run.where, {}))
    if not isinstance(own.value, dict):
        return run
    merged = Node(
        own.where, {**common.value, **own.value}, key_places={**common.key_places, **own.key_places}
    )
    places = {**run.key_places, "condition": own.where}
    return Node(run.where, {**run.value, "condition": merged}, key_places=places)


def _check_column(
    column: ForceColumn | AccelerationColumn, _node: Node, path: str, notes: Notes
) -> ForceColumn | AccelerationColumn:
    """Note a sign of 0, and a sensitivity that is missing or has no use."""
    if column.sign == 0:
        notes.reject(notes.place_of(f"{path}.sign"), f"{path}.sign", "0", "1 or -1")
    if not notes.spoilt(path) and (column.unit in VOLTS) != (column.sensitivity is not None):
        found = f"the unit {column.unit} {'without' if column.sensitivity is None else 'with'} a sensitivity"
        allowed = "a sensitivity for V and mV, and for these only"
        notes.reject(notes.place_of(f"{path}.sensitivity"), f"{path}.sensitivity", found, allowed)
    return column


def _check_csv(csv: CsvText, node: Node, path: str, notes: Notes) -> CsvText:
    """Note delimiters and decimal signs that are not single, different characters."""
    stated = [sign for sign in (csv.delimiter, csv.decimal) if sign is not None]
    if any(len(sign) != 1 for sign in stated) or csv.delimiter == csv.decimal is not None:
        notes.reject(node.where, path, "delimiter and decimal", "one character each, not the same")
    elif csv.decimal not in (None, ".", ","):
        notes.reject(node.where, f"{path}.decimal", repr(csv.decimal), "a point or a comma")
    return csv


def _check(mapping: RecordMap, _node: Node, _path: str, notes: Notes) -> RecordMap:
    """Note a rate beside a time column."""
    if mapping.rate is not None and mapping.time is not None:
        notes.reject(notes.place_of("rate"), "rate", "a rate beside a time column", "one of them")
    return mapping
