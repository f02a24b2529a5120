"""The grid's axes in a protocol's tree: one path with its values, or under `zip` several that vary together."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from rig.documents.decode import Notes, Unreadable, annotation_at, describe, paths_of, plain, value_of
from rig.documents.nodes import Node
from rig.errors import nearest, quote
from rig.protocol.spec import Protocol, Vary

PARTS = ("scene", "drive", "acquire")
ZIP = re.compile(r"zip(\.\w+)?")
"""The keys of `vary` that hold paths which vary together; several groups read zip, zip.2, zip.ends and so on."""


@dataclass
class Axes:
    """The axes read so far and the place of every value: path -> row -> place."""

    axes: list[Vary] = field(default_factory=list)
    places: dict[str, list[str]] = field(default_factory=dict)


def read_axes(node: Node, notes: Notes) -> Axes:
    """Every axis in the order written; what cannot be read is noted, its paths as failed, and left out."""
    if not isinstance(node.value, dict):
        raise notes.reject(node.where, "vary", describe(node), "a mapping of paths to lists of values")
    axes = Axes()
    for key, entry in node.value.items():
        if not ZIP.fullmatch(key):
            _read_axis({key: entry}, node.key_places, "vary", notes, axes)
        elif not isinstance(entry.value, dict) or not entry.value:
            notes.reject(entry.where, f"vary.{key}", describe(entry), "a mapping of paths to lists of equal length")
        else:
            _read_axis(entry.value, entry.key_places, f"vary.{key}", notes, axes)
    return axes


def plain_axes(axes: Iterable[Vary]) -> dict[str, Any]:
    """The axes as plain data that read_axes takes back in the same order."""
    data: dict[str, Any] = {}
    groups = 0
    for axis in axes:
        lists: dict[str, Any] = {
            path: [plain(annotation_at(Protocol, path), row[column]) for row in axis.rows]
            for column, path in enumerate(axis.paths)
        }
        if len(lists) == 1:
            data |= lists
        else:
            groups += 1
            data["zip" if groups == 1 else f"zip.{groups}"] = lists
    return data


def _read_axis(lists: Mapping[str, Node], key_places: Mapping[str, str], owner: str, notes: Notes, axes: Axes) -> None:
    columns: dict[str, list[Any]] = {}
    for path, node in lists.items():
        full = f"{owner}.{path}"
        try:
            annotation = _annotation(path, key_places[path], full, [*axes.places, *columns], notes)
            if not isinstance(node.value, tuple) or not node.value:
                raise notes.reject(node.where, full, describe(node), "a list of one or more values")
            columns[path] = _values(annotation, node.value, full, notes)
        except Unreadable:
            notes.failed.add(path)
    if len({len(values) for values in columns.values()}) > 1:
        found = ", ".join(f"{len(values)} values of {path}" for path, values in columns.items())
        notes.reject(key_places[next(iter(columns))], owner, found, "lists of equal length")
        notes.failed.update(columns)
    if len(columns) == len(lists) and not notes.failed.intersection(columns):
        axes.axes.append(Vary(tuple(columns), tuple(zip(*columns.values(), strict=True))))
        for path, node in lists.items():
            axes.places[path] = [item.where for item in node.value] if isinstance(node.value, tuple) else []


def _annotation(path: str, place: str, full: str, others: list[str], notes: Notes) -> Any:
    known = [known for known in paths_of(Protocol) if known.partition(".")[0] in PARTS]
    if path not in known:
        allowed = f"the path of a field under {', '.join(PARTS)}, such as scene.grains.fill"
        raise notes.reject(place, full, f"the key {quote(path)}", allowed, nearest(path, known))
    for other in others:
        if f"{path}.".startswith(f"{other}.") or f"{other}.".startswith(f"{path}."):
            raise notes.reject(place, full, f"{path} beside {other}", "every field in one axis only")
    return annotation_at(Protocol, path)


def _values(annotation: Any, items: tuple[Node, ...], full: str, notes: Notes) -> list[Any]:
    """The values of one path; raises Unreadable after noting the mistakes in any of them."""
    inner = Notes()
    values = []
    for item in items:
        try:
            values.append(value_of(annotation, item, full, inner))
        except Unreadable:
            continue
    notes.mistakes += inner.mistakes
    if inner.mistakes:
        raise Unreadable(full)
    return values
