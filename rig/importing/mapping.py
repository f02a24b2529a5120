"""Mapping files: what the columns of a laboratory's own record mean. Read as strictly as protocols,
every mistake.
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
FORMATS = ("csv", "uff58", "sep005", "tdms", "mat", "hdf5")
FORCE_UNITS: Mapping[str, float] = {
    "N": 1.0,
    "kN": 1e3,
    "mN": 1e-3,
    "lbf": 4.4482216152605,
    "V": 1.0,
    "mV": 1e-3,
}
ACCELERATION_UNITS: Mapping[str, float] = {
    "m/s^2": 1.0,
    "mm/s^2": 1e-3,
    "g": GRAVITY,
    "V": 1.0,
    "mV": 1e-3,
}
"""Size of each unit in N or m/s^2; volts need a sensitivity."""

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
    """What force and acceleration have in common. sign: -1 where the file counts the other
    direction. calibration_U: relative, k = 2, None for not known. delay: s by which the channel
    comes late."""

    channel: str
    sign: Sign = 1
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
    """Where the force is. sign: -1 where the file counts the force that acts on the gauge's other
    side. noise: N rms, None: from the record."""

    unit: Annotated[str, one_of(*FORCE_UNITS)] = "N"
    sensitivity: Annotated[float | None, Quantity("force sensitivity", 0.0, 1e6, above=True)] = None
    noise: Annotated[float | None, Quantity("force", 0.0, 1e9)] = None
    range: Annotated[float | None, Quantity("force", 0.0, 1e9, above=True)] = None


@dataclass(frozen=True)
class AccelerationColumn(Column):
    """Where the acceleration is; noise in m/s^2 rms."""

    unit: Annotated[str, one_of(*ACCELERATION_UNITS)] = "m/s^2"
    sensitivity: Annotated[
        float | None, Quantity("acceleration sensitivity", 0.0, 1e6, above=True)
    ] = None
    noise: Annotated[float | None, Quantity("acceleration", 0.0, 1e9)] = None
    range: Annotated[float | None, Quantity("acceleration", 0.0, 1e9, above=True)] = None


@dataclass(frozen=True)
class TimeColumn:
    """A column of sample times."""

    channel: str
    unit: Annotated[str, one_of("s", "ms", "us")] = "s"


@dataclass(frozen=True)
class CsvText:
    """How a text file writes numbers; skip: lines before the header."""

    delimiter: str = ","
    decimal: str = "."
    skip: Annotated[int, Quantity("number", 0, 1000000)] = 0


@dataclass(frozen=True)
class Steady:
    """Limits of the stationarity gate: change of the fundamental's amplitude (relative) and phase
    (rad).
    """

    level: Share = 0.02
    phase: Annotated[float, Quantity("angle", 0.0, 1.0)] = 0.02


@dataclass(frozen=True)
class Known:
    """What is known of a condition beside the records; all of it may be left out. acceleration: the
    level that was set.

    bed: `locked` and `empty` make null tests, `dashpot` with `dashpot_c` a reference.
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
    """One record: its file, beside the mapping file, and the condition that it belongs to."""

    file: str
    condition: Known = Known()
    settle: Annotated[float | None, Quantity("time", 0.0, 1e9)] = None


@dataclass(frozen=True)
class RecordMap:
    """A mapping. rate: Hz, None: from the file or its time column. frequency: Hz, None: found in
    the record. settle: s left out at the start; length: s used after that, None for all. scene:
    predicts W_T where it is written.
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
    """A mapping, its text and its file."""

    mapping: RecordMap
    text: str
    path: Path
    places: Mapping[str, str] = field(default_factory=dict)


def read_mapping(path: Path) -> LoadedMap:
    """The mapping in a file. Raises InputError with every mistake in it."""
    text = read_file(path)
    notes = Notes(
        known=tuple(paths_of(RecordMap)), renamed=FORMER_NAMES, meaning=OwnMaterials(path.parent)
    )
    root = _with_common(read_yaml(text, str(path), notes.mistakes))
    return LoadedMap(read_document(mapping_shape(), root, notes), text, path, notes.places)


def mapping_schema() -> dict[str, Any]:
    """JSON Schema of a mapping file; what hangs on the record itself is left to `rig import`."""
    return document_schema(mapping_shape(), f"Mapping of a laboratory's own records, {SCHEMA}")


def mapping_shape() -> Then:
    """The shape of a mapping file."""
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
    """The tree whose runs have what the mapping's own `condition` says and they do not."""
    if not isinstance(root.value, dict) or not {"runs", "condition"} <= root.value.keys():
        return root
    runs, common = root.value["runs"], root.value["condition"]
    if not isinstance(runs.value, tuple):
        return root
    merged = Node(runs.where, tuple(_with(run, common) for run in runs.value))
    return Node(root.where, {**root.value, "runs": merged}, key_places=root.key_places)


def _with(run: Node, common: Node) -> Node:
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
    if column.sign == 0:
        notes.reject(notes.place_of(f"{path}.sign"), f"{path}.sign", "0", "1 or -1")
    if not notes.spoilt(path) and (column.unit in VOLTS) != (column.sensitivity is not None):
        found = f"the unit {column.unit} {'without' if column.sensitivity is None else 'with'} a sensitivity"
        allowed = "a sensitivity for V and mV, and for these only"
        notes.reject(notes.place_of(f"{path}.sensitivity"), f"{path}.sensitivity", found, allowed)
    return column


def _check_csv(csv: CsvText, node: Node, path: str, notes: Notes) -> CsvText:
    if {len(csv.delimiter), len(csv.decimal)} != {1} or csv.delimiter == csv.decimal:
        notes.reject(node.where, path, "delimiter and decimal", "one character each, not the same")
    return csv


def _check(mapping: RecordMap, _node: Node, _path: str, notes: Notes) -> RecordMap:
    if mapping.rate is not None and mapping.time is not None:
        notes.reject(notes.place_of("rate"), "rate", "a rate beside a time column", "one of them")
    return mapping
