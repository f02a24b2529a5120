"""Frozen dataclasses as shapes: their annotations are the grammar of the documents that people
write.

An annotation is a type, or `Annotated[type, mark]` where the mark is a shape of
`daq.documents.shapes` or of a caller (`rig.units.Quantity`). Such documents are closed: they have
the fields of their class and no others.
"""

from __future__ import annotations

import types
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass, replace
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin, get_type_hints

from daq.documents.shapes import Anything, Each, Keys, List, Number, Shape, Text, YesNo

__all__ = ["keys_of", "paths_of", "shape_at", "shape_of"]


@cache
def keys_of(kind: type) -> Keys:
    """The shape of a dataclass. Where all of its fields, two or more, are alike, a plain value
    stands for each.
    """
    hints = get_type_hints(kind, include_extras=True)
    shapes = {item.name: shape_of(hints[item.name]) for item in fields(kind)}
    needed = [f.name for f in fields(kind) if f.default is MISSING and f.default_factory is MISSING]
    alike = len(shapes) > 1 and all(
        shape == shapes[fields(kind)[0].name] for shape in shapes.values()
    )
    return Keys(
        {name: shapes[name] for name in needed},
        {name: shape for name, shape in shapes.items() if name not in needed},
        closed=True,
        kind=kind,
        alone=tuple(shapes) if alike else (),
    )


def shape_of(annotation: Any) -> Shape:
    """The shape of an annotation."""
    base, *marks = get_args(annotation) if get_origin(annotation) is Annotated else (annotation,)
    options = get_args(base) if get_origin(base) in (Union, types.UnionType) else (base,)
    null = types.NoneType in options
    (first, *_) = (option for option in options if option is not types.NoneType)
    words = tuple(
        word for option in options for word in get_args(option) if get_origin(option) is Literal
    )
    if marks:
        shape: Shape = marks[0]
        fitted = getattr(shape, "fitted", None)
        return shape if fitted is None else fitted(whole=int in options, null=null, words=words)
    if isinstance(first, type) and is_dataclass(first):
        return replace(keys_of(first), null=True) if null else keys_of(first)
    if get_origin(first) is tuple:
        return List(shape_of(get_args(first)[0]))
    if get_origin(first) is Mapping or first is Mapping:
        return Each(shape_of(get_args(first)[1]))
    plain: Mapping[Any, Shape] = {
        bool: YesNo(),
        str: Text(null=null, as_written=True),
        int: Number(whole=True, null=null),
        float: Number(null=null),
        Any: Anything(),
    }
    return Text(words, null=null, as_written=True) if words else plain[first]


def shape_at(kind: type, path: str) -> Shape | None:
    """The shape at a dotted path inside a dataclass, None where there is no such field."""
    shape: Shape | None = keys_of(kind)
    for name in path.split("."):
        shape = shape.every().get(name) if isinstance(shape, Keys) else None
    return shape


def paths_of(kind: type, prefix: str = "") -> Iterator[str]:
    """Every dotted path of a dataclass, groups before their parts."""
    for name, shape in keys_of(kind).every().items():
        yield f"{prefix}{name}"
        if isinstance(shape, Keys) and isinstance(shape.kind, type) and not shape.null:
            yield from paths_of(shape.kind, f"{prefix}{name}.")
