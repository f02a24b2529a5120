"""A tree of plain values that know where they were written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

Scalar = str | int | float | bool | None


@dataclass(frozen=True)
class Node:
    """A value and its place. `value` is a scalar, a tuple of nodes or a dict of nodes; `text` a scalar as written;
    `key_places` says where each key of a dict stands; `quoted` marks text written in quotes."""

    where: str
    value: Scalar | tuple[Node, ...] | dict[str, Node]
    text: str = ""
    key_places: dict[str, str] = field(default_factory=dict)
    quoted: bool = False

    def plain(self) -> Any:
        """The value as nested dicts, lists and scalars."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, tuple):
            return [node.plain() for node in self.value]
        return self.value


def node_of(data: Any, where: str = "") -> Node:
    """The tree of plain data, every place `where`."""
    if isinstance(data, Mapping):
        entries = {key: node_of(part, where) for key, part in data.items()}
        return Node(where, entries, key_places=dict.fromkeys(entries, where))
    if isinstance(data, list | tuple):
        return Node(where, tuple(node_of(part, where) for part in data))
    return Node(where, data, text=str(data))
