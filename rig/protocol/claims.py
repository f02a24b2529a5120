"""Claims in a protocol: the grammar of `expect:`.

An entry has the claim in words, one kind with what it is about, and what the kind needs; margins stand in the protocol:

    - {claim: ..., optimum: scene.grains.fill, value: 90 %}                  W is largest there (a list: in there)
    - {claim: ..., order: scene.grains.material, values: [alumina, heavy]}   W rises along the list
    - {claim: ..., rise: scene.grains.fill, from: 10 %, to: 90 %}            W rises in every step between; also fall
    - {claim: ..., nonlinear: drive.acceleration, margin: 0.1}               n = dlnW/dlna is off 2 by more than that
    - {claim: ..., nearly_zero: scene.grains.fill, value: 0 %, full: 90 %, margin: 2 %}    W below the margin of full W
    - {claim: ..., offset_within: [5.5 %, 8.5 %], per: scene.grains.material}              sum W_exp / sum W_T - 1

`at: {path: value or list}` restricts an entry to some conditions; otherwise it is judged at every combination of the
other fields that vary, or over the mean of ln W along one of them with `over: path`. `imposed: reason` marks a claim
whose outcome was put in.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rig.documents.decode import (
    Notes,
    Unreadable,
    annotation_at,
    describe,
    entries_of,
    number,
    paths_of,
    plain,
    value_of,
    word_of,
)
from rig.documents.nodes import Node
from rig.errors import nearest, quote
from rig.protocol.spec import Acquire, Drive, Expect, Protocol, Scene
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
"""Kind -> its keys that hold values of the field; the last of them may hold a list where the kind wants one."""

LISTS = ("optimum", "order")
LISTED = ("scene.losses", "acquire.effects")
MARGINS = {"nonlinear": 0.1, "nearly_zero": 0.02}
LEVEL = "drive.acceleration"
_MARGIN = Quantity("number", 0.0, 1.0, above=True)
_OFFSET = Quantity("number", -1.0, 100.0)
ALWAYS = ("claim", "imposed")


def read_expect(node: Node, notes: Notes) -> tuple[Expect, ...]:
    """Every claim that can be read; what cannot is noted and left out."""
    if not isinstance(node.value, tuple):
        raise notes.reject(node.where, "expect", describe(node), "a list of mappings")
    claims = []
    for place, item in enumerate(node.value, 1):
        try:
            claims.append(_claim(item, f"expect[{place}]", notes))
        except Unreadable:
            continue
    return tuple(claims)


def plain_expect(claim: Expect) -> dict[str, Any]:
    """A claim as plain data that read_expect reads back to an equal one."""
    data: dict[str, Any] = {"claim": claim.claim}
    if claim.kind == "offset_within":
        data[claim.kind] = [limit + 0.0 for limit in claim.limits]  # a minus zero is a zero
        data |= {"per": claim.path} if claim.path else {}
    else:
        data[claim.kind] = claim.path
        values = _plain_values(claim.path, claim.values)
        if claim.kind in LISTS:
            data[NAMES[claim.kind][0]] = values
        else:
            data |= zip(NAMES.get(claim.kind, ()), values, strict=False)
        data |= {"margin": claim.limits[0]} if claim.limits else {}
    if claim.at:
        data["at"] = {path: _plain_values(path, values) for path, values in claim.at.items()}
    data |= {"over": claim.over} if claim.over else {}
    return data | ({"imposed": claim.imposed} if claim.imposed else {})


def _plain_values(path: str, values: tuple[Any, ...]) -> list[Any]:
    annotation = annotation_at(Protocol, path)
    return [value if annotation is None else plain(annotation, value) for value in values]


def _claim(node: Node, where: str, notes: Notes) -> Expect:
    if not isinstance(node.value, dict):
        raise notes.reject(node.where, where, describe(node), "a mapping for each claim")
    kinds = [key for key in node.value if key in KINDS]
    if len(kinds) != 1:
        every = (*ALWAYS, *KINDS, *dict.fromkeys(key for keys in KINDS.values() for key in keys))
        entries_of(node, where, every, notes)
        found = f"the kinds {' and '.join(kinds)}" if kinds else "a claim without a kind"
        raise notes.reject(node.where, where, found, f"one of {', '.join(KINDS)}")
    kind = kinds[0]
    before = len(notes.mistakes)
    entries = entries_of(node, where, (*ALWAYS, kind, *KINDS[kind]), notes)
    needed = ("claim", *(name for name in NAMES.get(kind, ())))
    for name in needed:
        if name not in entries:
            notes.reject(node.where, where, f"no {name}", f"a {kind} claim with {', '.join(needed)}")
    parts = _parts(kind, entries, where, notes)
    if len(notes.mistakes) > before:
        raise Unreadable(where)
    return Expect(kind=kind, **parts)


def _parts(kind: str, entries: Mapping[str, Node], where: str, notes: Notes) -> dict[str, Any]:
    """The fields of a claim; mistakes are noted and their fields left out."""
    parts: dict[str, Any] = {}
    path_key = "per" if kind == "offset_within" else kind
    for key, node in entries.items():
        full = f"{where}.{key}"
        try:
            if key in ALWAYS:
                parts[key] = _words(node, full, notes)
            elif key == path_key:
                parts["path"] = _path(node, full, notes, only=LEVEL if kind == "nonlinear" else "")
            elif key == "over":
                parts["over"] = _path(node, full, notes)
            elif key == "margin":
                parts["limits"] = (float(number(node, _MARGIN, full, notes)),)
            elif key == "offset_within":
                parts["limits"] = _range(node, full, notes)
            elif key == "at":
                parts["at"] = _at(node, full, notes)
        except Unreadable:
            continue
    if kind in MARGINS:
        parts.setdefault("limits", (MARGINS[kind],))
    if parts.get("path") and kind in NAMES:
        parts["values"] = tuple(
            value
            for key in NAMES[kind]
            if key in entries
            for value in _values(parts["path"], entries[key], f"{where}.{key}", notes, listed=kind in LISTS)
        )
        if kind == "order" and len(parts["values"]) == 1:
            notes.reject(entries["values"].where, f"{where}.values", "one value", "two or more values, lowest W first")
        if kind != "optimum" and len(set(parts["values"])) < len(parts["values"]):
            notes.reject(entries[NAMES[kind][0]].where, where, "a value twice", "different values")
    return parts


def _words(node: Node, path: str, notes: Notes) -> str:
    text = word_of(node, path, (), notes)
    if not text.strip():
        raise notes.reject(node.where, path, "no words", "a sentence")
    return text


def _path(node: Node, path: str, notes: Notes, only: str = "") -> str:
    """A path of a single number or word; lists and groups cannot be compared."""
    known = [only] if only else list(single_paths())
    text = word_of(node, path, (), notes)
    if text not in known:
        allowed = only or "the path of a field under scene, drive, acquire, such as scene.grains.fill"
        raise notes.reject(node.where, path, quote(text), allowed, nearest(text, known))
    return text


def single_paths() -> Iterator[str]:
    """Every path under scene, drive and acquire of one number or word: no group of fields, no list."""
    groups = {name.rpartition(".")[0] for name in paths_of(Protocol)}
    parts = {"scene": Scene, "drive": Drive, "acquire": Acquire}
    every = (f"{part}.{name}" for part, kind in parts.items() for name in paths_of(kind))
    return (path for path in every if path not in groups and path not in LISTED)


def _values(path: str, node: Node, where: str, notes: Notes, *, listed: bool) -> tuple[Any, ...]:
    """The values of a field that a claim names: one, or with `listed` one or a list of them."""
    items = node.value if listed and isinstance(node.value, tuple) else (node,)
    if not items:
        notes.reject(node.where, where, "an empty list", "one or more values")
    inner = Notes()
    values = []
    for item in items:
        try:
            values.append(value_of(annotation_at(Protocol, path), item, where, inner))
        except Unreadable:
            continue
    notes.mistakes += inner.mistakes
    return tuple(values)


def _range(node: Node, path: str, notes: Notes) -> tuple[float, float]:
    items = node.value
    if not isinstance(items, tuple) or len(items) != 2:
        raise notes.reject(node.where, path, describe(node), "a list of two numbers, such as [5.5 %, 8.5 %]")
    low, high = (float(number(item, _OFFSET, path, notes)) for item in items)
    if low >= high:
        raise notes.reject(node.where, path, f"{low:g} to {high:g}", "the lower limit first")
    return low, high


def _at(node: Node, path: str, notes: Notes) -> dict[str, tuple[Any, ...]]:
    if not isinstance(node.value, dict):
        raise notes.reject(node.where, path, describe(node), "a mapping of paths to a value or a list of values")
    found = {}
    for key, item in node.value.items():
        full = f"{path}.{key}"
        name = _path(Node(node.key_places[key], key, key), full, notes)
        found[name] = _values(name, item, full, notes, listed=True)
    return found
