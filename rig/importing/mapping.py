"""Mapping files: what the columns of a laboratory's own record mean. Read as strictly as protocols, every mistake."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

from rig.documents.annotations import OneOf
from rig.documents.decode import Notes, Unreadable, describe, entries_of, fill, grammar, paths_of, value_of, word_of
from rig.documents.nodes import Node
from rig.documents.yaml_reader import read_file, read_yaml
from rig.errors import InputError, in_order
from rig.protocol.spec import Scene
from rig.units import GRAVITY, Quantity

SCHEMA = "rig/map/1"
FORMATS = ("csv", "uff58", "sep005", "tdms", "mat", "hdf5")
FORCE_UNITS: Mapping[str, float] = {"N": 1.0, "kN": 1e3, "mN": 1e-3, "lbf": 4.4482216152605, "V": 1.0, "mV": 1e-3}
ACCELERATION_UNITS: Mapping[str, float] = {"m/s^2": 1.0, "mm/s^2": 1e-3, "g": GRAVITY, "V": 1.0, "mV": 1e-3}
"""Size of each unit in N or m/s^2; volts need a sensitivity."""

VOLTS = ("V", "mV")
ASSUMED_U = 0.01
"""Relative expanded uncertainty (k = 2) of a sensitivity where the mapping states none: a usual certificate's."""

Sign = Annotated[int, Quantity("number", -1, 1)]
Share = Annotated[float, Quantity("number", 0.0, 1.0)]
Stated = Annotated[float | None, Quantity("number", 0.0, 1.0)]
Duration = Annotated[float, Quantity("time", 0.0, 1e9)]
Delay = Annotated[float, Quantity("time", -1.0, 1.0)]
Pole = Annotated[float | Literal["none"], Quantity("time", 0.0, 1e9, above=True)]
Mass = Annotated[float, Quantity("mass", 0.0, 1e6)]


@dataclass(frozen=True)
class Column:
    """What force and acceleration have in common. sign: -1 where the file counts the other direction. calibration_U:
    relative, k = 2, None for not known. delay: s by which the channel comes late."""

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
    """Where the force is. sign: -1 where the file counts the force that acts on the gauge's other side. noise: N rms,
    None: from the record."""

    unit: Annotated[str, OneOf(tuple(FORCE_UNITS))] = "N"
    sensitivity: Annotated[float | None, Quantity("force sensitivity", 0.0, 1e6, above=True)] = None
    noise: Annotated[float | None, Quantity("force", 0.0, 1e9)] = None
    range: Annotated[float | None, Quantity("force", 0.0, 1e9, above=True)] = None


@dataclass(frozen=True)
class AccelerationColumn(Column):
    """Where the acceleration is; noise in m/s^2 rms."""

    unit: Annotated[str, OneOf(tuple(ACCELERATION_UNITS))] = "m/s^2"
    sensitivity: Annotated[float | None, Quantity("acceleration sensitivity", 0.0, 1e6, above=True)] = None
    noise: Annotated[float | None, Quantity("acceleration", 0.0, 1e9)] = None
    range: Annotated[float | None, Quantity("acceleration", 0.0, 1e9, above=True)] = None


@dataclass(frozen=True)
class TimeColumn:
    """A column of sample times."""

    channel: str
    unit: Annotated[str, OneOf(("s", "ms", "us"))] = "s"


@dataclass(frozen=True)
class CsvText:
    """How a text file writes numbers; skip: lines before the header."""

    delimiter: str = ","
    decimal: str = "."
    skip: Annotated[int, Quantity("number", 0, 1000000)] = 0


@dataclass(frozen=True)
class Steady:
    """Limits of the stationarity gate: change of the fundamental's amplitude (relative) and phase (rad)."""

    level: Share = 0.02
    phase: Annotated[float, Quantity("angle", 0.0, 1.0)] = 0.02


@dataclass(frozen=True)
class Known:
    """What is known of a condition beside the records; all of it may be left out. acceleration: the level that was set.

    bed: `locked` and `empty` make null tests, `dashpot` with `dashpot_c` a reference.
    """

    id: str = "c01"
    bed: Annotated[str, OneOf(("unknown", "empty", "locked", "dashpot", "grains"))] = "unknown"
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
    """A mapping. rate: Hz, None: from the file or its time column. frequency: Hz, None: found in the record. settle: s
    left out at the start; length: s used after that, None for all. scene: predicts W_T where it is written.
    """

    name: str
    force: ForceColumn
    acceleration: AccelerationColumn
    schema: str = SCHEMA
    question: str = ""
    format: Annotated[str, OneOf(("", *FORMATS))] = ""
    csv: CsvText = CsvText()
    rate: Annotated[float | None, Quantity("rate", 0.0, 1e9, above=True)] = None
    time: TimeColumn | None = None
    frequency: Annotated[float | None, Quantity("frequency", 0.0, 1e6, above=True)] = None
    settle: Duration = 0.0
    length: Annotated[float | None, Quantity("time", 0.0, 1e9, above=True)] = None
    steady: Steady = Steady()
    condition: Known = Known()
    rig: str = "default"
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
    notes = Notes(known=tuple(paths_of(RecordMap)))
    root = read_yaml(text, str(path), notes.mistakes)
    try:
        mapping = _read(root, notes)
    except Unreadable:
        raise InputError(*in_order(notes.mistakes)) from None
    if notes.mistakes:
        raise InputError(*in_order(notes.mistakes))
    return LoadedMap(mapping, text, path, notes.places)


def _read(root: Node, notes: Notes) -> RecordMap:
    notes.places[""] = root.where
    entries = entries_of(root, "", tuple(grammar(RecordMap)), notes)
    given: dict[str, Any] = {}
    for key in grammar(RecordMap):
        try:
            if key in entries:
                given[key] = _entry(key, entries, notes)
            elif key in ("name", "force", "acceleration", "schema"):
                notes.reject(root.where, key, "nothing", SCHEMA if key == "schema" else f"an entry {key}")
        except Unreadable:
            continue
    if notes.mistakes:
        raise Unreadable("")
    mapping = RecordMap(**given)
    _check(mapping, notes)
    return mapping


def _entry(key: str, entries: Mapping[str, Node], notes: Notes) -> Any:
    node = entries[key]
    notes.places[key] = node.where
    if key == "schema":
        return word_of(node, key, (SCHEMA,), notes)
    if key == "time":
        return fill(TimeColumn, node, key, notes)
    if key == "scene":
        return fill(Scene, node, key, notes)
    if key == "runs":
        if not isinstance(node.value, tuple):
            raise notes.reject(node.where, key, describe(node), "a list of mappings with file")
        common = entries.get("condition")
        return tuple(fill(RunFile, _with(item, common), f"runs[{n}]", notes) for n, item in enumerate(node.value))
    return value_of(grammar(RecordMap)[key], node, key, notes)


def _with(run: Node, common: Node | None) -> Node:
    """A run's node whose condition has what the mapping's own `condition` says and it does not."""
    if common is None or not isinstance(common.value, dict) or not isinstance(run.value, dict):
        return run
    own = run.value.get("condition", Node(run.where, {}))
    if not isinstance(own.value, dict):
        return run
    merged = Node(own.where, {**common.value, **own.value}, key_places={**common.key_places, **own.key_places})
    places = {**run.key_places, "condition": own.where}
    return Node(run.where, {**run.value, "condition": merged}, key_places=places)


def _check(mapping: RecordMap, notes: Notes) -> None:
    """What fits each field and does not fit together."""
    for name, column in (("force", mapping.force), ("acceleration", mapping.acceleration)):
        if column.sign == 0:
            notes.reject(notes.place_of(f"{name}.sign"), f"{name}.sign", "0", "1 or -1")
        if (column.unit in VOLTS) != (column.sensitivity is not None):
            found = f"the unit {column.unit} {'without' if column.sensitivity is None else 'with'} a sensitivity"
            allowed = "a sensitivity for V and mV, and for these only"
            notes.reject(notes.place_of(f"{name}.sensitivity"), f"{name}.sensitivity", found, allowed)
    if mapping.rate is not None and mapping.time is not None:
        notes.reject(notes.place_of("rate"), "rate", "a rate beside a time column", "one of them")
    if len(mapping.csv.delimiter) != 1 or len(mapping.csv.decimal) != 1 or mapping.csv.delimiter == mapping.csv.decimal:
        notes.reject(notes.place_of("csv"), "csv", "delimiter and decimal", "one character each, not the same")
