"""Claims in a protocol: the grammar of `expect:`.

An entry has the claim in words, one kind with the field it is about, and the values, limits or
margin that the kind needs:

    - {claim: ..., optimum: scene.grains.fill, value: 90 %}                  W is largest at that value (or in a list)
    - {claim: ..., order: scene.grains.material, values: [alumina, heavy]}   W rises along the list
    - {claim: ..., rise: scene.grains.fill, from: 10 %, to: 90 %}            W rises in every step between; also fall
    - {claim: ..., nonlinear: drive.acceleration, margin: 0.1}               |dlnW/dlna - 2| exceeds the margin
    - {claim: ..., nearly_zero: scene.grains.fill, value: 0 %, full: 90 %, margin: 2 %}    W < margin x W at `full`
    - {claim: ..., offset_within: [5.5 %, 8.5 %], per: scene.grains.material}              sum W_exp / sum W_T - 1

An entry is judged at every combination of the other fields that vary. `at: {path: value or list}`
restricts it to some of them; `over: path` judges the mean of ln W along that field instead of each
of its values. `imposed: reason` marks a claim whose outcome was put into the model.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from functools import cache
from typing import Any

from daq.documents.classes import paths_of, shape_at
from daq.documents.notes import Node, Notes, Unreadable
from daq.documents.shapes import Anything, Each, Keys, List, OneOf, Shape, Text, Then
from rig.catalog.entries import Material
from rig.protocol.spec import Expect, Protocol
from rig.protocol.vary import PARTS, plain_values
from rig.units import Quantity

KINDS: Mapping[str, tuple[str, ...]] = {
    "optimum": ("value", "at", "over"),
    "order": ("values", "at", "over"),
    "rise": ("from", "to", "at", "over"),
    "fall": ("from", "to", "at", "over"),
    "nonlinear": ("margin", "at"),
    "nearly_zero": ("value", "full", "margin", "at"),
    "offset_within": ("per", "at"),
}
"""Kind -> the keys beside `claim`, `imposed` and the kind itself."""

NAMES: Mapping[str, tuple[str, ...]] = {
    "optimum": ("value",), "order": ("values",), "rise": ("from", "to"), "fall": ("from", "to"),
    "nearly_zero": ("value", "full"),
}  # fmt: skip
"""Kind -> its keys that hold values of the field. Those of the kinds in LISTS may hold a list."""

LISTS = ("optimum", "order")
MARGINS = {"nonlinear": 0.1, "nearly_zero": 0.02}
LEVEL = "drive.acceleration"
ALWAYS = ("claim", "imposed")


@cache
def expect_shape() -> List:
    """Return the shape of `expect`, which is read into a tuple of `Expect`."""
    names = "the path of a field under scene, drive, acquire, such as scene.grains.fill"
    path = Text(tuple(single_paths()), as_written=True, allowed=names)
    words = Then(Text(as_written=True), _words, {"pattern": r"\S"})
    # A value is read later, by the shape of the field that the claim names.
    value = Anything({"not": {"type": "object"}})
    limits = List(Quantity("number", -1.0, 100.0), 2, 2, what="two numbers, such as [5.5 %, 8.5 %]")
    shapes: dict[str, Shape] = dict.fromkeys(ALWAYS, words) | dict.fromkeys(KINDS, path)
    shapes |= {"nonlinear": Text((LEVEL,)), "offset_within": limits, "per": path, "over": path}
    shapes |= {"margin": Quantity("number", 0.0, 1.0, above=True)}
    shapes |= {"at": Each(value, path, "a mapping of paths to a value or a list of values")}
    kinds = {}
    for kind, keys in KINDS.items():
        needed = ("claim", kind, *NAMES.get(kind, ()))
        every = {key: shapes.get(key, value) for key in (*needed, "imposed", *keys)}
        required = {key: every.pop(key) for key in needed}
        kinds[kind] = Keys(required, every, closed=True, what=f"a claim of the kind {kind}")
    return List(Then(OneOf(kinds, "claim"), _claim), what="claims")


def plain_expect(claim: Expect) -> dict[str, Any]:
    """Return a claim as plain data, which `expect_shape` reads back to an equal one."""
    data: dict[str, Any] = {"claim": claim.claim}
    if claim.kind == "offset_within":
        data[claim.kind] = [limit + 0.0 for limit in claim.limits]  # a minus zero is a zero
        data |= {"per": claim.path} if claim.path else {}
    else:
        data[claim.kind] = claim.path
        values = plain_values(claim.path, claim.values)
        if claim.kind in LISTS:
            data[NAMES[claim.kind][0]] = values
        else:
            data |= zip(NAMES.get(claim.kind, ()), values, strict=False)
        data |= {"margin": claim.limits[0]} if claim.limits else {}
    if claim.at:
        data["at"] = {path: plain_values(path, values) for path, values in claim.at.items()}
    data |= {"over": claim.over} if claim.over else {}
    return data | ({"imposed": claim.imposed} if claim.imposed else {})


def single_paths() -> Iterator[str]:
    """Yield every path under scene, drive and acquire that holds one number or word."""
    for path in paths_of(Protocol):
        several = isinstance(shape_at(Protocol, path), Keys | List)
        if path.partition(".")[0] in PARTS and not several:
            yield path


def _claim(parts: Mapping[str, Any], node: Node, where: str, notes: Notes) -> Expect:
    """Return the claim of an entry. Raises Unreadable after noting what does not fit together."""
    before = len(notes.mistakes)
    (kind,) = (key for key in parts if key in KINDS)
    found: dict[str, Any] = {key: parts[key] for key in (*ALWAYS, "over") if key in parts}
    path = found["path"] = parts.get("per", "") if kind == "offset_within" else parts[kind]
    found["values"] = ()
    for key in NAMES.get(kind, ()):
        found["values"] += _values(path, parts[key], f"{where}.{key}", notes, listed=kind in LISTS)
    found["at"] = {
        key: _values(key, item, f"{where}.at.{key}", notes, listed=True)
        for key, item in parts.get("at", {}).items()
    }
    if kind == "offset_within":
        found["limits"] = low, high = parts[kind]
        if low >= high:
            notes.reject(
                _place(node, kind),
                f"{where}.{kind}",
                f"{low:g} to {high:g}",
                "the lower limit first",
            )
    elif kind in MARGINS:
        found["limits"] = (parts.get("margin", MARGINS[kind]),)
    if kind == "order" and len(found["values"]) == 1:
        notes.reject(
            _place(node, "values"),
            f"{where}.values",
            "one value",
            "two or more values, lowest W first",
        )
    if kind != "optimum" and len(set(found["values"])) < len(found["values"]):
        notes.reject(_place(node, NAMES[kind][0]), where, "a value twice", "different values")
    if len(notes.mistakes) > before:
        raise Unreadable(where)
    return Expect(kind=kind, **found)


def _place(node: Node, key: str) -> str:
    """Return where the value of a key of a mapping was written."""
    return node.value[key].where if isinstance(node.value, dict) else node.where


def _words(text: str, node: Node, path: str, notes: Notes) -> str:
    """Return a text; refuse one of blanks alone."""
    if not text.strip():
        raise notes.reject(node.where, path, "no words", "a sentence")
    return text


def _values(path: str, node: Node, where: str, notes: Notes, *, listed: bool) -> tuple[Any, ...]:
    """Return the values of the field at `path` that a claim names, none after a mistake.

    listed : whether the node may hold a list of values instead of one
    """
    shape = shape_at(Protocol, path)
    many = node if listed and isinstance(node.value, tuple) else Node(node.where, (node,))
    if many.value == ():
        notes.reject(node.where, where, "an empty list", "one or more values")
    elif shape is not None:
        with suppress(Unreadable):
            found = List(shape).read(many, where, notes)
            # A claim speaks of a material by its name; its values stand in the scene.
            return tuple(str(one) if isinstance(one, Material) else one for one in found)
    return ()
