"""Shapes as JSON Schema (draft 2020-12), so that tools of others can check what `daq.documents.shapes.deviations`
checks."""

import math
from typing import Any

from daq.documents.shapes import LARGEST, Choice, Each, Either, Keys, List, Null, Number, Shape, Text, YesNo

__all__ = ["json_schema"]


def json_schema(shape: Shape) -> dict[str, Any]:
    """The schema of a shape. Lists that must be equally long (`Keys.as_long`) have no word in JSON Schema."""
    match shape:
        case Null():
            return {"type": "null"}
        case YesNo():
            return {"type": "boolean"}
        case Number():
            return _number(shape)
        case Text():
            words: dict[str, Any] = {"enum": [*shape.words, *([None] if shape.null else [])]}
            return words if shape.words else {"type": ["string", "null"] if shape.null else "string"}
        case List():
            most = {} if math.isinf(shape.most) else {"maxItems": shape.most}
            return {"type": "array", "items": json_schema(shape.item), "minItems": shape.least} | most
        case Each():
            return {"type": "object", "additionalProperties": json_schema(shape.item)}
        case Either():
            return {"anyOf": [json_schema(shape.first), json_schema(shape.second)]}
        case Choice():
            return {"oneOf": [_case(shape.key, word, keys) for word, keys in shape.shapes.items()]}
        case Keys():
            return _keys(shape)


def _number(shape: Number) -> dict[str, Any]:
    kind = "integer" if shape.whole else "number"
    found: dict[str, Any] = {"type": [kind, "null"] if shape.null else kind}
    if shape.least > -LARGEST:
        found["exclusiveMinimum" if shape.above else "minimum"] = shape.least
    return found | ({"maximum": shape.most} if shape.most < LARGEST else {})


def _keys(shape: Keys) -> dict[str, Any]:
    every = {**shape.required, **shape.optional}
    return {
        "type": ["object", "null"] if shape.null else "object",
        "properties": {name: json_schema(part) for name, part in every.items()},
        "required": list(shape.required),
    }


def _case(key: str, word: str, keys: Keys) -> dict[str, Any]:
    found = _keys(keys)
    return found | {"properties": found["properties"] | {key: {"const": word}}, "required": [key, *found["required"]]}
