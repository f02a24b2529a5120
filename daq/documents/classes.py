"""Frozen dataclasses as JSON documents: the shape that a class states, and the way there and back.

A field is a key. Its shape follows from the annotation: `float` is a number, `int` a whole one,
`tuple[X, ...]` a list, `Mapping[str, X]` a mapping with free keys, another dataclass a mapping with
its own; `| None` allows null. A shape of `daq.documents.shapes` as a mark says more:
`Annotated[float | None, Number(0.0)]`. A field with a default is optional. A key that Python
reserves has a field with an underscore behind it: `from_`.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from functools import cache
from types import NoneType, UnionType
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin, get_type_hints

from daq.documents.shapes import (
    Each,
    Either,
    Keys,
    List,
    Null,
    Number,
    Shape,
    Text,
    YesNo,
    deviations,
)

__all__ = [
    "LEFT_OUT",
    "AtLeast",
    "DocumentError",
    "built",
    "finite",
    "from_document",
    "shape_of",
    "to_document",
]

T = TypeVar("T")
Way = Callable[[Any], Any]

LEFT_OUT = "left out of the document where it is the default"
"""Mark of an optional key that is not written where nothing is known; so it is never null."""


@dataclass(frozen=True, slots=True)
class AtLeast:
    """Mark of a list: as many values as this at least."""

    count: int


class DocumentError(ValueError):
    """A document is not what a class wants; the message names the place, what was found and what is
    allowed.
    """


@dataclass(frozen=True, slots=True)
class ValueKind:
    """What an annotation says of a value: its shape, what writes and reads it (None: it stays as it
    is), what takes numbers out of it that are not finite (None: there are none)."""

    shape: Shape
    write: Way | None = None
    read: Way | None = None
    finite: Way | None = None


@dataclass(frozen=True, slots=True)
class FieldKey:
    """A field of a class and its key in the document."""

    name: str
    key: str
    kind: ValueKind
    required: bool
    default: Any
    left_out: bool


def shape_of(cls: type) -> Keys:
    """Return the shape of a class's documents."""
    known = keys_of(cls)
    return Keys(
        {item.key: item.kind.shape for item in known if item.required},
        {item.key: item.kind.shape for item in known if not item.required},
    )


def to_document(value: Any) -> dict[str, Any]:
    """Return the document of an instance, keys in the order of its fields; numbers that are not
    finite are null.
    """
    document = {}
    for item in keys_of(type(value)):
        found = getattr(value, item.name)
        if item.left_out and found == item.default:
            continue
        write = item.kind.write
        document[item.key] = found if write is None or found is None else write(found)
    return document


def from_document(cls: type[T], document: Any, path: str = "") -> T:
    """Return the instance that a document describes; keys that the class does not know are passed
    over.

    path: of the document, for messages. DocumentError with the first deviation.
    """
    for sentence in deviations(document, shape_of(cls), path):
        raise DocumentError(sentence)
    return built(cls, document)


def built(cls: type[T], document: Mapping[str, Any]) -> T:
    """Return the instance of a document that was checked."""
    values = {}
    for item in keys_of(cls):
        if item.key in document:
            found, read = document[item.key], item.kind.read
            values[item.name] = found if read is None or found is None else read(found)
    return cls(**values)


def finite(value: T) -> T:
    """Return an instance with None for every number that is not finite, where its field allows
    None: JSON has none.
    """
    changed = {}
    for item in keys_of(type(value)):
        if item.kind.finite is not None:
            found = getattr(value, item.name)
            kept = None if found is None else item.kind.finite(found)
            if kept is not found:
                changed[item.name] = kept
    return replace(value, **changed) if changed else value  # type: ignore[type-var]


def keys_of(cls: Any) -> tuple[FieldKey, ...]:
    """Return the fields of a dataclass as keys."""
    return _keys_of(cls)


@cache
def _keys_of(cls: Any) -> tuple[FieldKey, ...]:
    hints = get_type_hints(cls, include_extras=True)
    found = []
    for field in fields(cls):
        made = field.default if field.default_factory is MISSING else field.default_factory()
        left_out = get_origin(hints[field.name]) is Annotated and LEFT_OUT in get_args(
            hints[field.name]
        )
        kind = _kind(hints[field.name])
        found.append(
            FieldKey(field.name, field.name.rstrip("_"), kind, made is MISSING, made, left_out)
        )
    return tuple(found)


_PLAIN: Mapping[Any, Shape] = {int: Number(whole=True), str: Text(), bool: YesNo()}


def _kind(hint: Any) -> ValueKind:
    """What an annotation says."""
    origin, parts = get_origin(hint), get_args(hint)
    if hint is float:
        return ValueKind(Number(), _finite_or_none)
    if isinstance(hint, type) and hint in _PLAIN:
        return ValueKind(_PLAIN[hint])
    if isinstance(hint, type) and is_dataclass(hint):
        return ValueKind(
            shape_of(hint), to_document, lambda document: built(hint, document), finite
        )
    if origin is Annotated:
        return _marked(parts[0], parts[1:])
    if origin in (Union, UnionType):
        return _union(parts)
    if origin is tuple:
        return _list(parts)
    if origin is not None and issubclass(origin, Mapping):
        return _each(_kind(parts[1]))
    raise TypeError(f"{hint} has no place in a document")


def _marked(hint: Any, marks: tuple[Any, ...]) -> ValueKind:
    """What an annotation with marks says: a shape in place of its own, a length, or that it is
    never null.
    """
    kind, members = _kind(hint), get_args(hint)
    nullable = NoneType in members and LEFT_OUT not in marks
    shape = kind.shape
    if NoneType in members and not nullable:
        shape = _union(tuple(part for part in members if part is not NoneType)).shape
    for mark in marks:
        if isinstance(mark, Shape):
            shape = _or_null(mark) if nullable else mark
        elif isinstance(mark, AtLeast) and isinstance(shape, List):
            shape = replace(shape, least=mark.count)
    return replace(kind, shape=shape)


def _union(parts: tuple[Any, ...]) -> ValueKind:
    """Of one annotation or None, or of plain values and lists of them, which their types tell
    apart.
    """
    kinds = [_kind(part) for part in parts if part is not NoneType]
    shape = kinds[0].shape
    for kind in kinds[1:]:
        shape = Either(shape, kind.shape)
    if NoneType in parts:
        shape = _or_null(shape)
    if len(kinds) > 1:
        return ValueKind(
            shape, _plain_written, _plain_read, _finite_or_none if NoneType in parts else None
        )
    (kind,) = kinds
    return replace(
        kind, shape=shape, finite=_finite_or_none if kind.write is _finite_or_none else kind.finite
    )


def _plain_written(value: Any) -> Any:
    return _numbers(value) if isinstance(value, tuple) else _finite_or_none(value)


def _plain_read(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _or_null(shape: Shape) -> Shape:
    if isinstance(shape, Number | Text | Keys):
        return replace(shape, null=True)
    if isinstance(shape, Either) and isinstance(shape.first, Number | Text):
        return Either(_or_null(shape.first), shape.second)
    return Either(Null(), shape)


def _list(parts: tuple[Any, ...]) -> ValueKind:
    """A tuple, of any length (`tuple[X, ...]`) or of a certain one (`tuple[X, X]`)."""
    item = _kind(parts[0])
    size = (0, math.inf) if parts[-1] is Ellipsis else (len(parts), len(parts))
    shape = List(item.shape, *size)
    write, read, clean = item.write, item.read, item.finite
    if write is _finite_or_none:
        return ValueKind(shape, _numbers, tuple)
    return ValueKind(
        shape,
        list
        if write is None
        else lambda values: [None if value is None else write(value) for value in values],
        tuple
        if read is None
        else lambda values: tuple([None if value is None else read(value) for value in values]),
        None if clean is None else lambda values: _unless_same(values, tuple(map(clean, values))),
    )


def _each(item: ValueKind) -> ValueKind:
    write, read = item.write, item.read
    return ValueKind(
        Each(item.shape),
        dict
        if write is None
        else lambda values: {key: write(value) for key, value in values.items()},
        dict
        if read is None
        else lambda values: {key: read(value) for key, value in values.items()},
    )


def _unless_same(values: tuple[Any, ...], changed: tuple[Any, ...]) -> tuple[Any, ...]:
    return values if all(map(lambda one, other: one is other, values, changed)) else changed


def _finite_or_none(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _numbers(values: tuple[float, ...]) -> list[float | None]:
    return (
        list(values) if math.isfinite(sum(values)) else [_finite_or_none(value) for value in values]
    )
