"""Strict reading: a tree of places and values into frozen dataclasses, every mistake noted, and back to plain data.

The dataclasses' annotations are the grammar (rig.units.Quantity, rig.documents.annotations.OneOf, Literal, nested
dataclasses).
"""

from __future__ import annotations

import types
from collections.abc import Collection, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from functools import cache
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

from rig.documents.annotations import OneOf
from rig.documents.nodes import Node
from rig.errors import Mistake, nearest, quote
from rig.units import Quantity, UnitError, format_quantity, parse_quantity, suggest_unit

SMALLEST = 1e-60
"""Smallest number but 0, SI: products of a few such are numbers still."""

T = TypeVar("T")


class Unreadable(Exception):
    """A value that was noted as a mistake and has no meaning."""


@dataclass
class Notes:
    """What a reading leaves beside its result: the mistakes, the paths whose value failed, the place of each path.
    `known` are all paths of the whole, so that a key in the wrong place can be sent to the right one."""

    mistakes: list[Mistake] = field(default_factory=list)
    failed: set[str] = field(default_factory=set)
    places: dict[str, str] = field(default_factory=dict)
    known: tuple[str, ...] = ()

    def reject(self, where: str, path: str, found: str, allowed: str, hint: str = "") -> Unreadable:
        """Note a mistake; the caller raises what this returns where it cannot go on."""
        self.mistakes.append(Mistake(where, path, found, allowed, hint))
        self.failed.add(path)
        return Unreadable(path)

    def place_of(self, path: str) -> str:
        """Where a path, or the nearest mapping around it, was written; "" for what nobody wrote."""
        while path not in self.places and "." in path:
            path = path.rpartition(".")[0]
        return self.places.get(path, self.places.get("", ""))


def grammar(kind: Any) -> Mapping[str, Any]:
    """Field name -> annotation of a dataclass."""
    return _grammar(kind)


@cache
def _grammar(kind: Any) -> Mapping[str, Any]:
    hints = get_type_hints(kind, include_extras=True)
    return {item.name: hints[item.name] for item in fields(kind)}


def annotation_at(kind: type, path: str) -> Any | None:
    """The annotation of a dotted path inside a dataclass, None where there is no such field."""
    annotation: Any = kind
    for name in path.split("."):
        known = grammar(annotation) if is_dataclass(annotation) and isinstance(annotation, type) else {}
        if name not in known:
            return None
        annotation = known[name]
    return annotation


def paths_of(kind: type, prefix: str = "") -> Iterator[str]:
    """Every dotted path of a dataclass, groups before their parts."""
    for name, annotation in grammar(kind).items():
        yield f"{prefix}{name}"
        if isinstance(annotation, type) and is_dataclass(annotation):
            yield from paths_of(annotation, f"{prefix}{name}.")


def describe(node: Node) -> str:
    """What a node holds, for a message."""
    if isinstance(node.value, dict):
        return "a mapping"
    if isinstance(node.value, tuple):
        return "a list"
    if node.value is None:
        return "nothing"
    return quote(node.value) if isinstance(node.value, str) else node.text[:60]


def entries_of(node: Node, path: str, allowed: Collection[str], notes: Notes) -> dict[str, Node]:
    """The entries of a mapping node that are allowed; every other key is a mistake that names the nearest."""
    if not isinstance(node.value, dict):
        raise notes.reject(node.where, path, describe(node), f"a mapping with the keys {', '.join(allowed)}")
    good = {}
    for key, entry in node.value.items():
        if key in allowed:
            good[key] = entry
        else:
            full = f"{path}.{key}" if path else key
            homes = [f"did you mean {home}?" for home in notes.known if home.rpartition(".")[2] == key]
            hint = nearest(key, allowed) or next(iter(homes), "")
            notes.reject(node.key_places[key], full, f"the key {quote(key)}", ", ".join(allowed), hint)
    return good


def fill(kind: type[T], node: Node, path: str, notes: Notes) -> T:
    """A dataclass from a mapping node. Fields not written, or written wrongly and noted, keep their defaults."""
    known = grammar(kind)
    given: dict[str, Any] = {}
    notes.places[path] = node.where
    entries = entries_of(node, path, known, notes)
    for name, entry in entries.items():
        full = f"{path}.{name}" if path else name
        try:
            given[name] = value_of(known[name], entry, full, notes)
        except Unreadable:
            continue
    for item in fields(kind):  # type: ignore[arg-type]
        if item.name not in given and item.default is MISSING and item.default_factory is MISSING:
            if item.name in entries:
                raise Unreadable(f"{path}.{item.name}")  # noted above
            raise notes.reject(node.where, path, f"no {item.name}", f"a mapping with {item.name}")
    return kind(**given)


def value_of(annotation: Any, node: Node, path: str, notes: Notes) -> Any:
    """The value of a node as its annotation wants it; raises Unreadable after noting why not."""
    notes.places[path] = node.where
    base, extras = unpacked(annotation)
    if isinstance(base, type) and is_dataclass(base):
        return fill(base, _for_each(base, node), path, notes)
    if base is bool:
        if not isinstance(node.value, bool):
            raise notes.reject(node.where, path, describe(node), "true or false")
        return node.value
    if get_origin(base) is Literal:
        return word_of(node, path, get_args(base), notes)
    if base is str:
        return word_of(node, path, words_in(extras), notes)
    if get_origin(base) is tuple:
        return _words_of(node, path, words_in(extras), notes)
    return _number_of(base, quantity_in(extras), node, path, notes)


def _for_each(kind: type, node: Node) -> Node:
    """A plain value in the place of a group of two fields or more that are all alike stands for each of them."""
    known = grammar(kind)
    alike = len(known) > 1 and len(set(map(str, known.values()))) == 1
    if not alike or isinstance(node.value, dict | tuple) or node.value is None:
        return node
    return Node(node.where, dict.fromkeys(known, node), key_places=dict.fromkeys(known, node.where))


def word_of(node: Node, path: str, words: tuple[str, ...], notes: Notes) -> str:
    """The text of a node, one of `words` unless that is empty. A number is taken as written: model names may be one."""
    value = node.text if isinstance(node.value, int | float) and not isinstance(node.value, bool) else node.value
    if not isinstance(value, str):
        raise notes.reject(node.where, path, describe(node), ", ".join(words) or "text")
    if words and value not in words:
        raise notes.reject(node.where, path, quote(value), ", ".join(words), nearest(value, words))
    return value


def _words_of(node: Node, path: str, words: tuple[str, ...], notes: Notes) -> tuple[str, ...]:
    if not isinstance(node.value, tuple):
        raise notes.reject(node.where, path, describe(node), f"a list of {', '.join(words)}")
    found: list[str] = []
    for item in node.value:
        word = word_of(item, path, words, notes)
        if word in found:
            raise notes.reject(item.where, path, f"{quote(word)} twice", "each word once")
        found.append(word)
    return tuple(found)


def _number_of(base: Any, quantity: Quantity, node: Node, path: str, notes: Notes) -> float | int | str | None:
    options = get_args(base) if get_origin(base) in (Union, types.UnionType) else (base,)
    allowed = str(quantity)
    words = [str(word) for option in options for word in get_args(option)]
    if node.value in words:
        return str(node.value)
    allowed = ", or ".join([allowed, *words])
    if words and isinstance(node.value, str) and node.value.isalpha():
        raise notes.reject(node.where, path, quote(node.value), allowed, nearest(node.value, words))
    if node.value is None and types.NoneType in options:
        return None
    if int in options:
        return number(node, quantity, path, notes, whole=True, allowed=f"a whole number, {quantity.range()}")
    return number(node, quantity, path, notes, allowed=allowed)


def number(
    node: Node, quantity: Quantity, path: str, notes: Notes, *, whole: bool = False, allowed: str = ""
) -> float | int:
    """The SI number of a node: a plain number or text with a unit, inside the quantity's range, `allowed` in words."""
    allowed = allowed or str(quantity)
    value: float | int
    if isinstance(node.value, str):
        try:
            value = parse_quantity(node.value, quantity.dimension)
        except UnitError as error:
            raise notes.reject(node.where, path, quote(node.value), allowed if whole else str(error)) from error
    elif isinstance(node.value, int | float) and not isinstance(node.value, bool):
        value = node.value
    else:
        raise notes.reject(node.where, path, describe(node), allowed)
    if not quantity.holds(value):
        plain = not isinstance(node.value, str)
        hint = suggest_unit(float(value), quantity) if plain else ""
        raise notes.reject(node.where, path, describe(node), allowed, hint)
    if 0 < abs(value) < SMALLEST:
        raise notes.reject(node.where, path, describe(node), f"{allowed}; 0, or at least {SMALLEST:g} in size")
    if not whole:
        return float(value) + 0.0
    if value != int(value):
        raise notes.reject(node.where, path, describe(node), allowed)
    return int(value)


def plain(annotation: Any, value: Any) -> Any:
    """A value as plain data that `value_of` reads back to the same value; quantities carry their SI unit."""
    base, extras = unpacked(annotation)
    if isinstance(base, type) and is_dataclass(base):
        return {name: plain(part, getattr(value, name)) for name, part in grammar(base).items()}
    if isinstance(value, tuple):
        return list(value)
    if isinstance(value, bool | str) or value is None:
        return value
    quantity = quantity_in(extras)
    if isinstance(value, float):
        value += 0.0  # a minus zero is a zero
    return value if quantity.dimension == "number" else format_quantity(value, quantity.dimension)


def unpacked(annotation: Any) -> tuple[Any, tuple[Any, ...]]:
    if get_origin(annotation) is Annotated:
        base, *extras = get_args(annotation)
        return base, tuple(extras)
    return annotation, ()


def quantity_of(annotation: Any) -> Quantity | None:
    """What the numbers of an annotation mean, None where it takes none."""
    return next((extra for extra in unpacked(annotation)[1] if isinstance(extra, Quantity)), None)


def quantity_in(extras: tuple[Any, ...]) -> Quantity:
    return next((extra for extra in extras if isinstance(extra, Quantity)), Quantity())


def words_in(extras: tuple[Any, ...]) -> tuple[str, ...]:
    return next((extra.words for extra in extras if isinstance(extra, OneOf)), ())
