"""JSON Schema of a mapping file (`rig import --map`), from the grammar that the strict reader reads with.

It refuses nothing that the reader takes; what hangs on the record itself is left to `rig import`.
"""

from __future__ import annotations

from typing import Any

from rig.documents.decode import grammar
from rig.importing.mapping import SCHEMA, VOLTS, AccelerationColumn, ForceColumn, RecordMap, RunFile, TimeColumn
from rig.protocol.json_schema import DRAFT, groups, object_of, of, with_default
from rig.protocol.spec import Scene

COLUMNS = (ForceColumn, AccelerationColumn)
BY_NAME = {"time": TimeColumn, "scene": Scene}
"""Entries that may be left out and are mappings where they are there."""


def mapping_schema() -> dict[str, Any]:
    """The schema of a mapping file."""
    known = grammar(RecordMap)
    properties: dict[str, Any] = {"schema": {"const": SCHEMA}, "name": of(known["name"])}
    for name, annotation in known.items():
        if name in BY_NAME:
            properties[name] = {"$ref": f"#/$defs/{BY_NAME[name].__name__}"}
        elif name == "runs":
            properties[name] = {"type": "array", "items": {"$ref": f"#/$defs/{RunFile.__name__}"}}
        elif name not in properties:
            properties[name] = with_default(RecordMap, name, of(annotation))
    kinds = {
        kind.__name__: object_of(kind) for kind in (*groups(RecordMap), RunFile, TimeColumn, Scene, *groups(Scene))
    }
    for column in COLUMNS:
        kinds[column.__name__] |= _volts(kinds[column.__name__])
    return {
        "$schema": DRAFT,
        "title": f"Mapping of a laboratory's own records, {SCHEMA}",
        "type": "object",
        "properties": properties,
        "required": ["schema", "name", "force", "acceleration"],
        "additionalProperties": False,
        "not": {"required": ["rate", "time"], "properties": {"rate": {"not": {"type": "null"}}}},
        "$defs": kinds,
    }


def _volts(column: dict[str, Any]) -> dict[str, Any]:
    """What goes together in a column: a sensitivity with volts, and with volts only; a sign is 1 or -1."""
    stated = {"required": ["sensitivity"], "properties": {"sensitivity": {"not": {"type": "null"}}}}
    volts = {"required": ["unit"], "properties": {"unit": {"enum": list(VOLTS)}}}
    sign = {**column["properties"]["sign"], "not": {"const": 0}}
    return {"properties": {**column["properties"], "sign": sign}, "if": volts, "then": stated, "else": {"not": stated}}
