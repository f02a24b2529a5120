"""JSON Schema (draft 2020-12) of a protocol, made from the grammar that the strict reader reads with.

It refuses nothing that the reader takes. What hangs on several fields at once (levels in the grid, fits of bed and
axis) or on the size of a text's number beyond its sign is left to `rig check`.
"""

from __future__ import annotations

import types
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, Literal, Union, get_args, get_origin

from rig.documents.decode import annotation_at, grammar, paths_of, plain, quantity_in, unpacked, words_in
from rig.protocol.claims import ALWAYS, KINDS, LEVEL, NAMES, single_paths
from rig.protocol.faults import SIZES, Fault
from rig.protocol.load import NAME, REQUIRED
from rig.protocol.spec import SCHEMA, Protocol
from rig.protocol.vary import PARTS, ZIP
from rig.units import UNITS, Quantity

DRAFT = "https://json-schema.org/draft/2020-12/schema"
_TEXT = {"type": ["string", "number"]}
"""Text: a plain number stands for itself, as in model names."""

_ANY = r"[-+]?(?:\d+\.?\d*|\.\d+)"
_NOT_NEGATIVE = r"(?:\+?(?:\d+\.?\d*|\.\d+)|-(?:0+\.?0*|\.0+))"
_POSITIVE = r"\+?(?=[\d.]*[1-9])(?:\d+\.?\d*|\.\d+)"


def protocol_schema() -> dict[str, Any]:
    """The schema of a protocol file."""
    known = grammar(Protocol)
    properties: dict[str, Any] = {"schema": {"const": SCHEMA}, "name": _name()}
    for name in known:
        properties.setdefault(name, {})
    for name in (*PARTS, "rig", "question", "seed", "mistake", "fidelity", "tolerance"):
        properties[name] = with_default(Protocol, name, of(known[name]))
    whole = of(grammar(known["repeats"])["n"])
    properties["repeats"] = {"anyOf": [whole, {"$ref": "#/$defs/Repeats"}], "default": 4}
    properties["vary"] = _axes()
    properties["faults"] = {"type": "array", "items": _fault()}
    properties["expect"] = {"type": "array", "items": _claim()}
    kinds = {kind.__name__: object_of(kind) for kind in groups(Protocol)}
    return {
        "$schema": DRAFT,
        "title": f"Protocol of the particle-damper rig, {SCHEMA}",
        "type": "object",
        "properties": properties,
        "required": list(REQUIRED),
        "additionalProperties": False,
        "$defs": kinds,
    }


def of(annotation: Any) -> dict[str, Any]:
    """The schema of a value as `rig.documents.decode.value_of` takes it."""
    base, extras = unpacked(annotation)
    if isinstance(base, type) and is_dataclass(base):
        known = grammar(base)
        alike = len(known) > 1 and len(set(map(str, known.values()))) == 1
        group = {"$ref": f"#/$defs/{base.__name__}"}
        return {"anyOf": [group, of(next(iter(known.values())))]} if alike else group
    if base is bool:
        return {"type": "boolean"}
    if get_origin(base) is Literal:
        return {"enum": list(get_args(base))}
    if base is str:
        words = words_in(extras)
        return {"enum": list(words)} if words else dict(_TEXT)
    if get_origin(base) is tuple:
        return {"type": "array", "items": {"enum": list(words_in(extras))}, "uniqueItems": True}
    options = get_args(base) if get_origin(base) in (Union, types.UnionType) else (base,)
    words = tuple(word for option in options for word in get_args(option))
    forms = _numbers(quantity_in(extras), whole=int in options)
    forms += [{"enum": list(words)}] if words else []
    forms += [{"type": "null"}] if types.NoneType in options else []
    return {"description": str(quantity_in(extras)), "anyOf": forms}


def _numbers(quantity: Quantity, *, whole: bool = False) -> list[dict[str, Any]]:
    """A plain number in its range, or text with a unit; of the text's number the sign is checked."""
    plain_number: dict[str, Any] = {"type": "integer" if whole else "number"}
    if abs(quantity.least) != float("inf"):
        plain_number["exclusiveMinimum" if quantity.above else "minimum"] = quantity.least
    if abs(quantity.most) != float("inf"):
        plain_number["maximum"] = quantity.most
    positive = quantity.least > 0 or (quantity.least == 0 and quantity.above)
    digits = _POSITIVE if positive else _NOT_NEGATIVE if quantity.least == 0 else _ANY
    units = "|".join(_escaped(unit) for unit in sorted(UNITS[quantity.dimension], key=len, reverse=True))
    pattern = rf"^\s*{digits}(?:[eE][-+]?\d+)?\s*(?:{units})\s*$"
    return [plain_number, {"type": "string", "pattern": pattern, "maxLength": 64}]


def _escaped(unit: str) -> str:
    """A unit as a regular expression that JavaScript and Python read alike."""
    return "".join(r"\s+" if c == " " else f"\\{c}" if c in "^*/()" else c for c in unit)


def object_of(kind: type) -> dict[str, Any]:
    """The schema of a dataclass: its fields and no others, with their defaults."""
    known = grammar(kind)
    found: dict[str, Any] = {"type": "object", "description": " ".join((kind.__doc__ or "").split())}
    found["properties"] = {name: with_default(kind, name, of(annotation)) for name, annotation in known.items()}
    needed = [f.name for f in fields(kind) if f.default is MISSING and f.default_factory is MISSING]
    return found | ({"required": needed} if needed else {}) | {"additionalProperties": False}


def with_default(kind: type, name: str, schema: dict[str, Any]) -> dict[str, Any]:
    """The schema with the field's default; a group's stand at its own fields."""
    default = next(item.default for item in fields(kind) if item.name == name)
    if default is MISSING or is_dataclass(default):
        return schema
    return schema | {"default": plain(grammar(kind)[name], default)}


def groups(kind: type) -> Iterator[type]:
    """Every dataclass inside another, by way of plain fields."""
    for annotation in grammar(kind).values():
        if isinstance(annotation, type) and is_dataclass(annotation):
            yield annotation
            yield from groups(annotation)


def _name() -> dict[str, Any]:
    words = {"type": "string", "pattern": f"^{NAME.pattern}$"}
    return {"description": REQUIRED["name"], "anyOf": [words, {"type": "number", "minimum": 0}]}


def _axes() -> dict[str, Any]:
    """Lists of values by path; under zip, zip.2 and so on the paths that vary together."""
    lists = {path: {"type": "array", "minItems": 1, "items": _at(path)} for path in _varied()}
    group = {"type": "object", "minProperties": 1, "properties": {p: {"$ref": f"#/properties/vary/properties/{p}"}
             for p in lists}, "additionalProperties": False}  # fmt: skip
    return {
        "description": "The grid: every combination of the values, the last axis fastest.",
        "type": "object",
        "properties": lists,
        "patternProperties": {f"^{ZIP.pattern}$": group},
        "additionalProperties": False,
    }


def _varied() -> Iterator[str]:
    return (path for path in paths_of(Protocol) if path.partition(".")[0] in PARTS)


def _at(path: str) -> dict[str, Any]:
    """A reference to the schema of a dotted path."""
    owner, _, name = path.rpartition(".")
    if not owner:
        return {"$ref": f"#/properties/{name}"}
    return {"$ref": f"#/$defs/{annotation_at(Protocol, owner).__name__}/properties/{name}"}  # type: ignore[union-attr]


def _fault() -> dict[str, Any]:
    """A fault, its size as its kind wants it."""

    def size(kind: str) -> dict[str, Any]:
        if kind not in SIZES:
            return {"properties": {"size": {"enum": [0, "0"]}}}
        forms = _numbers(SIZES[kind], whole=kind == "clock_slip")
        return {"properties": {"size": {"anyOf": forms, "not": {"const": 0}}}, "required": ["size"]}

    kinds = get_args(grammar(Fault)["kind"])
    rules = [{"if": {"properties": {"kind": {"const": kind}}, "required": ["kind"]}, "then": size(kind)}
             for kind in kinds]  # fmt: skip
    return object_of(Fault) | {"allOf": rules}


def _claim() -> dict[str, Any]:
    """A claim: one kind, and what goes with that kind."""
    paths = {"enum": list(single_paths())}
    limit = {"anyOf": _numbers(Quantity("number", -1.0, 100.0))}
    words = {"anyOf": [{"type": "string", "pattern": r"\S"}, {"type": "number"}]}
    value = {"not": {"type": "object"}}
    properties: dict[str, Any] = dict.fromkeys(ALWAYS, words) | dict.fromkeys(KINDS, paths)
    properties |= {"nonlinear": {"const": LEVEL}}
    properties |= {"offset_within": {"type": "array", "items": limit, "minItems": 2, "maxItems": 2}, "per": paths}
    properties |= {key: value for keys in KINDS.values() for key in keys} | {"per": paths, "over": paths}
    properties["margin"] = {"anyOf": _numbers(Quantity("number", 0.0, 1.0, above=True))}
    properties["at"] = {"type": "object", "propertyNames": paths, "additionalProperties": value}
    return {
        "type": "object",
        "properties": properties,
        "required": ["claim"],
        "additionalProperties": False,
        "oneOf": [{"required": [kind]} for kind in KINDS],
        "allOf": [_needs(kind, keys) for kind, keys in KINDS.items()],
    }


def _needs(kind: str, keys: tuple[str, ...]) -> Mapping[str, Any]:
    """What a claim of a kind needs, and the keys that it may have."""
    then = {"required": list(NAMES.get(kind, ())), "propertyNames": {"enum": [*ALWAYS, kind, *keys]}}
    return {"if": {"required": [kind]}, "then": then}
