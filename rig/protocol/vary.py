"""Read and write the grid's axes, `vary` of a protocol.

An axis is a path with the list of its values, or, under a key `zip`, several paths that vary
together.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import Any

from daq.documents.classes import paths_of, shape_at
from daq.documents.notes import Node, Notes
from daq.documents.shapes import Keys, List, Then, plain
from rig.protocol.spec import Protocol, Vary

PARTS = ("scene", "drive", "acquire")
ZIP = re.compile(r"zip(\.\w+)?")
"""Keys of `vary` that hold paths which vary together: zip, and for further groups zip.2, zip.ends
and the like.
"""

NAMES = f"the path of a field under {', '.join(PARTS)}, such as scene.grains.fill"


@dataclass
class Axes:
    """The axes read so far, and where their values were written: path -> row -> `file:line`."""

    axes: list[Vary] = field(default_factory=list)
    places: dict[str, list[str]] = field(default_factory=dict)


@dataclass(frozen=True)
class Field:
    """Shape of a value of the protocol's field at `path`; its schema refers to the field's own."""

    path: str

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        """Return the value, read as the field itself is read."""
        shape = shape_at(Protocol, self.path)
        assert shape is not None
        return shape.read(node, path, notes)

    def schema(self, _kinds: dict[str, Any]) -> dict[str, Any]:
        """Return a reference to the field's own schema."""
        owner, _, name = self.path.rpartition(".")
        group = shape_at(Protocol, owner) if owner else None
        if not isinstance(group, Keys):
            return {"$ref": f"#/properties/{name}"}
        return {"$ref": f"#/$defs/{getattr(group.kind, '__name__', '')}/properties/{name}"}


def axes_shape(axes: Axes) -> Then:
    """Return the shape of `vary`, which is read into a tuple of axes.

    Reading also adds the axes, with the places of their values, to `axes`.
    """
    meaning = "The grid: every combination of the values, the last axis fastest."
    return Then(_lists(), partial(_read_axes, axes), {"description": meaning, "default": {}})


@cache
def _lists() -> Keys:
    lists: dict[str, Any] = {
        path: List(Field(path), least=1, what="one or more values")
        for path in paths_of(Protocol)
        if path.partition(".")[0] in PARTS
    }
    together = Keys(
        {}, lists, closed=True, names=NAMES, what="a mapping of paths to lists of equal length"
    )
    groups = {ZIP.pattern: Then(together, _not_empty, {"minProperties": 1})}
    return replace(together, groups=groups, what="a mapping of paths to lists of values")


def plain_axes(axes: Iterable[Vary]) -> dict[str, Any]:
    """Return the axes as plain data, which are read back in the same order."""
    data: dict[str, Any] = {}
    groups = 0
    for axis in axes:
        lists = {
            path: plain_values(path, (row[n] for row in axis.rows))
            for n, path in enumerate(axis.paths)
        }
        if len(lists) == 1:
            data |= lists
        else:
            groups += 1
            data["zip" if groups == 1 else f"zip.{groups}"] = lists
    return data


def plain_values(path: str, values: Iterable[Any]) -> list[Any]:
    """Return values of the field at `path` as plain data."""
    shape = shape_at(Protocol, path)
    return [value if shape is None else plain(shape, value) for value in values]


def _not_empty(lists: Mapping[str, Any], node: Node, path: str, notes: Notes) -> Mapping[str, Any]:
    if not node.value:
        raise notes.refuse(node, path, "a mapping of paths to lists of equal length")
    return lists


def _read_axes(
    axes: Axes, values: Mapping[str, Any], node: Node, path: str, notes: Notes
) -> tuple[Vary, ...]:
    """Return every axis in the order written.

    An axis whose values do not fit together is left out: the mistake is noted, its paths as failed.
    """
    assert isinstance(node.value, dict)
    for key, entry in node.value.items():
        if not ZIP.fullmatch(key):
            _add(
                {key: entry},
                {key: values[key]} if key in values else {},
                node.key_places,
                path,
                notes,
                axes,
            )
        elif isinstance(entry.value, dict) and key in values:
            _add(entry.value, values[key], entry.key_places, f"{path}.{key}", notes, axes)
    return tuple(axes.axes)


def _add(
    lists: Mapping[str, Node],
    columns: Mapping[str, tuple[Any, ...]],
    key_places: Mapping[str, str],
    owner: str,
    notes: Notes,
    axes: Axes,
) -> None:
    """Add one axis to `axes`: its paths' nodes are `lists`, their values `columns`."""
    notes.failed.update(lists.keys() - columns.keys())  # unreadable lists have no column
    seen = list(axes.places)
    for path in columns:
        for other in seen:
            # The dot keeps drive.level and drive.level_x apart.
            if f"{path}.".startswith(f"{other}.") or f"{other}.".startswith(f"{path}."):
                found = f"{path} beside {other}"
                notes.reject(
                    key_places[path], f"{owner}.{path}", found, "every field in one axis only"
                )
                notes.failed.add(path)
        seen.append(path)
    if len({len(values) for values in columns.values()}) > 1:
        found = ", ".join(f"{len(values)} values of {path}" for path, values in columns.items())
        notes.reject(key_places[next(iter(columns))], owner, found, "lists of equal length")
        notes.failed.update(columns)
    if len(columns) == len(lists) and not notes.failed.intersection(columns):
        axes.axes.append(Vary(tuple(columns), tuple(zip(*columns.values(), strict=True))))
        for path, node in lists.items():
            axes.places[path] = (
                [item.where for item in node.value] if isinstance(node.value, tuple) else []
            )
