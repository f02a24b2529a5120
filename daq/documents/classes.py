"""Frozen dataclasses as documents: their annotations are the grammar.

`keys_of` and `shape_of` make the shape of a document from a class. Documents that people write are
closed (`keys_of`): they have the fields of their class and no others, they are read into an
instance of it, and a number counts as text where a text is asked for. JSON documents that programs
write are free (`shape_of`): they may have further keys and are strict about types; `to_document`
and `from_document` convert them from instances and back.

An annotation is a type, or `Annotated[type, mark, ...]`, where a mark is a shape of
`daq.documents.shapes` or of a caller (`rig.units.Quantity`), `AtLeast` or `LEFT_OUT`. A field is a
key: `float` is a number, `int` a whole one, `tuple[X, ...]` a list, `tuple[X, X]` a list of two,
`Mapping[str, X]` a mapping with free keys, another dataclass a mapping with its own keys; `| None`
allows null. A field with a default is optional.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from functools import cache, partial
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from daq.documents.shapes import (
    Anything,
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
    "keys_of",
    "paths_of",
    "shape_at",
    "shape_of",
    "to_document",
]

T = TypeVar("T")
Conversion = Callable[[Any], Any]

LEFT_OUT = "left out of the document where it is the default"
"""Mark of an optional key that is not written where nothing is known; so it is never null."""

UNIONS = (Union, UnionType)


@dataclass(frozen=True, slots=True)
class AtLeast:
    """Mark of a list: its smallest number of values."""

    count: int


class DocumentError(ValueError):
    """A document does not have the shape of its class. The message names the place, the value found
    and what is allowed.
    """


@dataclass(frozen=True, slots=True)
class Conversions:
    """Conversions of the values of one annotation; None leaves them unchanged.

    write : from a value to its part of the document
    read : from a checked part of a document to the value
    finite : from a value to the same value with None for numbers that are not finite
    """

    write: Conversion | None = None
    read: Conversion | None = None
    finite: Conversion | None = None


@dataclass(frozen=True, slots=True)
class FieldKey:
    """A field of a class, its key in the document, and the conversions of its values.

    default : of the field, MISSING for none
    left_out : whether the key is not written where the value is the default
    """

    name: str
    key: str
    convert: Conversions
    default: Any
    left_out: bool


def keys_of(kind: type) -> Keys:
    """Return the shape of a class's closed documents, read into an instance of it.

    A plain value stands for each field of a class whose fields, two or more, are all alike.
    """
    return _keys_of(kind, free=False)


def shape_of(cls: type) -> Keys:
    """Return the shape of a class's free documents."""
    return _keys_of(cls, free=True)


def shape_at(kind: type, path: str) -> Shape | None:
    """Return the shape at a dotted path inside a dataclass, None where there is no such field."""
    shape: Shape | None = keys_of(kind)
    for name in path.split("."):
        shape = shape.every().get(name) if isinstance(shape, Keys) else None
    return shape


def paths_of(kind: type, prefix: str = "") -> Iterator[str]:
    """Yield every dotted path of a dataclass, groups before their parts."""
    for name, shape in keys_of(kind).every().items():
        yield f"{prefix}{name}"
        if isinstance(shape, Keys) and isinstance(shape.kind, type) and not shape.null:
            yield from paths_of(shape.kind, f"{prefix}{name}.")


def to_document(value: Any) -> dict[str, Any]:
    """Return the document of an instance, keys in the order of its fields; numbers that are not
    finite are null.
    """
    document = {}
    for item in _fields_of(type(value)):
        found = getattr(value, item.name)
        if item.left_out and found == item.default:
            continue
        write = item.convert.write
        document[item.key] = found if write is None or found is None else write(found)
    return document


def from_document(cls: type[T], document: Any, path: str = "") -> T:
    """Return the instance that a document describes; keys that the class does not have are ignored.

    path : of the document, for messages

    Raises DocumentError with the first deviation from the shape of the class.
    """
    for sentence in deviations(document, shape_of(cls), path):
        raise DocumentError(sentence)
    return built(cls, document)


def built(cls: type[T], document: Mapping[str, Any]) -> T:
    """Return the instance of a document that has been checked."""
    values = {}
    for item in _fields_of(cls):
        if item.key in document:
            found, read = document[item.key], item.convert.read
            values[item.name] = found if read is None or found is None else read(found)
    return cls(**values)


def finite(value: T) -> T:
    """Return an instance with None for every number that is not finite, where its field allows
    None.
    """
    changed = {}
    for item in _fields_of(type(value)):
        if item.convert.finite is not None:
            found = getattr(value, item.name)
            kept = None if found is None else item.convert.finite(found)
            if kept is not found:
                changed[item.name] = kept
    return replace(value, **changed) if changed else value  # type: ignore[type-var]


def _fields_of(cls: Any) -> tuple[FieldKey, ...]:
    """Return the fields of a dataclass as keys of its documents."""
    return _found_fields(cls)  # `cache` itself is not typed for a variable type


@cache
def _found_fields(cls: Any) -> tuple[FieldKey, ...]:
    hints = get_type_hints(cls, include_extras=True)
    found = []
    for field in fields(cls):
        hint = hints[field.name]
        made = field.default if field.default_factory is MISSING else field.default_factory()
        left_out = get_origin(hint) is Annotated and LEFT_OUT in get_args(hint)
        found.append(FieldKey(field.name, _key_of(field.name), _conversions(hint), made, left_out))
    return tuple(found)


def _conversions(hint: Any) -> Conversions:
    """Return the conversions of an annotation's values."""
    if get_origin(hint) is Annotated:
        return _conversions(get_args(hint)[0])
    origin, parts = get_origin(hint), get_args(hint)
    if hint is float:
        return Conversions(_finite_or_none)
    if isinstance(hint, type) and is_dataclass(hint):
        return Conversions(to_document, partial(built, hint), finite)
    if origin in UNIONS:
        return _of_union(parts)
    if origin is tuple:
        return _of_tuple(_conversions(parts[0]))
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return _of_mapping(_conversions(parts[1]))
    return Conversions()


def _of_union(parts: tuple[Any, ...]) -> Conversions:
    """Return the conversions of one type or None, or of plain values and lists of them, which are
    distinguished by their types.
    """
    options = [_conversions(part) for part in parts if part is not NoneType]
    if len(options) > 1:
        clean = _finite_or_none if NoneType in parts else None
        return Conversions(_plain_written, _plain_read, clean)
    (only,) = options
    return replace(only, finite=_finite_or_none) if only.write is _finite_or_none else only


def _of_tuple(item: Conversions) -> Conversions:
    write, read, clean = item.write, item.read, item.finite
    if write is _finite_or_none:
        return Conversions(_numbers, tuple)

    def written(values: tuple[Any, ...]) -> list[Any]:
        if write is None:
            return list(values)
        return [None if value is None else write(value) for value in values]

    def made(values: list[Any]) -> tuple[Any, ...]:
        if read is None:
            return tuple(values)
        return tuple([None if value is None else read(value) for value in values])

    def cleaned(values: tuple[Any, ...]) -> tuple[Any, ...]:
        assert clean is not None
        changed = tuple(map(clean, values))
        # The same object where nothing changed, so that `finite` copies no instance in vain.
        same = all(map(lambda one, other: one is other, values, changed))
        return values if same else changed

    return Conversions(written, made, None if clean is None else cleaned)


def _of_mapping(item: Conversions) -> Conversions:
    write, read = item.write, item.read

    def written(values: Mapping[str, Any]) -> dict[str, Any]:
        return {key: value if write is None else write(value) for key, value in values.items()}

    def made(values: Mapping[str, Any]) -> dict[str, Any]:
        return {key: value if read is None else read(value) for key, value in values.items()}

    return Conversions(written, made)


def _plain_written(value: Any) -> Any:
    return _numbers(value) if isinstance(value, tuple) else _finite_or_none(value)


def _plain_read(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


def _finite_or_none(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _numbers(values: tuple[float, ...]) -> list[float | None]:
    if math.isfinite(sum(values)):  # so is every one of them
        return list(values)
    return [_finite_or_none(value) for value in values]


@cache
def _keys_of(kind: type, free: bool) -> Keys:
    hints = get_type_hints(kind, include_extras=True)
    required: dict[str, Shape] = {}
    optional: dict[str, Shape] = {}
    for item in fields(kind):
        needed = item.default is MISSING and item.default_factory is MISSING
        key = _key_of(item.name) if free else item.name
        (required if needed else optional)[key] = _shape_of(hints[item.name], free)
    if free:
        return Keys(required, optional)
    first, *others = (required | optional).values()
    alike = bool(others) and all(shape == first for shape in others)
    alone = tuple(item.name for item in fields(kind)) if alike else ()
    return Keys(required, optional, closed=True, kind=kind, alone=alone)


def _key_of(name: str) -> str:
    """Return the key of a field in a free document: `from` for the field `from_`, because Python
    reserves the word.
    """
    return name.rstrip("_")


def _shape_of(annotation: Any, free: bool) -> Shape:
    """Return the shape of an annotation. Raises TypeError for a type without one."""
    base, *marks = get_args(annotation) if get_origin(annotation) is Annotated else (annotation,)
    members = get_args(base) if get_origin(base) in UNIONS else (base,)
    options = [member for member in members if member is not NoneType]
    null = len(options) < len(members) and LEFT_OUT not in marks
    words: tuple[str, ...] = ()
    for option in options:
        words += get_args(option) if get_origin(option) is Literal else ()

    marked = next((mark for mark in marks if isinstance(mark, Shape)), None)
    if marked is not None:
        # A mark may take what the type says into itself: Quantity("length") on `float | None`.
        fitted = getattr(marked, "fitted", None)
        if fitted is not None:
            found: Shape = fitted(whole=int in options, null=null, words=words)
            return found
        return _or_null(marked) if null else marked

    shape: Shape
    if words:
        shape = Text(words, as_written=not free)
    else:
        shape, *others = (_of_type(option, free) for option in options)
        for other in others:
            shape = Either(shape, other)
    for mark in marks:
        if isinstance(mark, AtLeast) and isinstance(shape, List):
            shape = replace(shape, least=mark.count)
    return _or_null(shape) if null else shape


def _of_type(hint: Any, free: bool) -> Shape:
    """Return the shape of a type without marks and without null."""
    plain: Mapping[Any, Shape] = {
        bool: YesNo(),
        str: Text(as_written=not free),
        int: Number(whole=True),
        float: Number(),
        Any: Anything(),
    }
    origin, parts = get_origin(hint), get_args(hint)
    if isinstance(hint, type) and is_dataclass(hint):
        return _keys_of(hint, free)
    if origin is tuple:
        size = (0, math.inf) if parts[-1] is Ellipsis else (len(parts), len(parts))
        return List(_shape_of(parts[0], free), *size)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return Each(_shape_of(parts[1], free))
    if hint not in plain:
        raise TypeError(f"{hint} has no place in a document")
    return plain[hint]


def _or_null(shape: Shape) -> Shape:
    """Return a shape that allows null as well."""
    if isinstance(shape, Number | Text | Keys):
        return replace(shape, null=True)
    if isinstance(shape, Either) and isinstance(shape.first, Number | Text):
        return Either(_or_null(shape.first), shape.second)
    return Either(Null(), shape)
