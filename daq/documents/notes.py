"""What a reader reads, plain data or values that know where they were written, and what it notes:
mistakes.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

__all__ = [
    "MOST_MISTAKES", "Mistake", "Node", "Notes", "Scalar", "Unreadable", "bare", "describe",
    "in_order", "nearest", "node_of", "quote", "where_of",
]  # fmt: skip

LONGEST_QUOTE = 60
MOST_MISTAKES = 50

Scalar = str | int | float | bool | None


@dataclass(frozen=True)
class Mistake:
    """One mistake in what a user gave.

    `where` is `file:line` or the command-line option, `field` the full path of the key (both may be
    empty), `found` and `allowed` are phrases, `hint` a whole question or advice such as "did you
    mean 'fill'?".
    """

    where: str
    field: str
    found: str
    allowed: str
    hint: str = ""

    def __str__(self) -> str:
        place = "".join(f"{part}: " for part in (self.where, self.field) if part)
        return f"{place}found {self.found}; allowed: {self.allowed}{self._advice()}"

    def sentence(self) -> str:
        """The mistake in a document that no user wrote, and that has no lines."""
        said = f"is {self.found}, expected {self.allowed}" if self.allowed else self.found
        return f"{self.field} {said}{self._advice()}"

    def _advice(self) -> str:
        return f"; {self.hint}" if self.hint else ""


def quote(value: object) -> str:
    """A user's value for a message: shortened, control characters escaped."""
    text = repr(value)
    return text if len(text) <= LONGEST_QUOTE else f"{text[: LONGEST_QUOTE - 3]}..."


def nearest(word: str, choices: Iterable[str]) -> str:
    """The hint "did you mean ...?" for a misspelt word, or "" where nothing is near."""
    close = difflib.get_close_matches(word[:LONGEST_QUOTE], list(choices), n=1, cutoff=0.6)
    return f"did you mean {close[0]!r}?" if close else ""


def new_name(word: str, choices: Iterable[str], renamed: Mapping[str, str]) -> str:
    """The hint "renamed: write ..." for an old name, or a path with old names in it; "" for any
    other word.
    """
    told = [renamed.get(part, part).partition(" ") for part in word.split(".")]
    now, note = ".".join(part[0] for part in told), "".join(part[2] for part in told)
    more = f" {note}" if note else ""
    return f"renamed: write {now!r}{more}" if now != word and now in choices else ""


def in_order(mistakes: Iterable[Mistake]) -> list[Mistake]:
    """Mistakes in the order of their lines, at most MOST_MISTAKES of them and one that counts the
    rest.
    """
    ordered = sorted(mistakes, key=_line)
    more = len(ordered) - MOST_MISTAKES
    if more <= 0:
        return ordered
    return [*ordered[:MOST_MISTAKES], Mistake("", "", f"{more} more mistakes", "none")]


def _line(mistake: Mistake) -> float:
    number = mistake.where.rpartition(":")[2]
    return int(number) if number.isdecimal() else math.inf


@dataclass(frozen=True)
class Node:
    """A value and its place. `value` is a scalar, a tuple of nodes or a dict of nodes; `text` a
    scalar as written; `key_places` says where each key of a dict stands; `quoted` marks text
    written in quotes."""

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


def bare(node: Any) -> Any:
    """The value of a node; plain data are their own."""
    return node.value if type(node) is Node else node


def where_of(node: Any) -> str:
    """Where a node was written; "" for plain data."""
    return node.where if type(node) is Node else ""


def describe(node: Any) -> str:
    """What a node or a plain value holds, for a message."""
    value = bare(node)
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return "a list"
    if value is None:
        return "null" if node is None else "nothing"
    return node.text[:60] if type(node) is Node and not isinstance(value, str) else quote(value)


class Unreadable(Exception):
    """A value that was noted as a mistake and has no meaning."""


@dataclass
class Notes:
    """What a reading leaves beside its result: the mistakes, the paths whose value failed, the
    place of each path. `known` are all paths of the whole, so that a key in the wrong place can be
    sent to the right one; `renamed` are the new names of old ones."""

    mistakes: list[Mistake] = field(default_factory=list)
    failed: set[str] = field(default_factory=set)
    places: dict[str, str] = field(default_factory=dict)
    known: tuple[str, ...] = ()
    renamed: Mapping[str, str] = field(default_factory=dict)

    def near(self, word: str, choices: Iterable[str]) -> str:
        """The hint for a word that is not among the choices: what it is called now, or the nearest
        of them.
        """
        return new_name(word, choices, self.renamed) or nearest(word, choices)

    def reject(self, where: str, path: str, found: str, allowed: str, hint: str = "") -> Unreadable:
        """Note a mistake; the caller raises what this returns where it cannot go on."""
        self.mistakes.append(Mistake(where, path, found, allowed, hint))
        self.failed.add(path)
        return Unreadable(path)

    def refuse(self, node: Any, path: str, allowed: object, hint: str = "") -> Unreadable:
        """As `reject`, for a value that is not what it should be."""
        return self.reject(where_of(node), path, describe(node), str(allowed), hint)

    def add(self, other: Notes) -> None:
        """Add what another reading left."""
        self.mistakes += other.mistakes
        self.failed |= other.failed
        self.places |= other.places

    def spoilt(self, path: str) -> bool:
        """Whether a value inside the mapping at a path failed."""
        return any(failed.startswith(f"{path}.") for failed in self.failed)

    def place_of(self, path: str) -> str:
        """Where a path, or the nearest mapping around it, was written; "" for what nobody wrote."""
        while path not in self.places and "." in path:
            path = path.rpartition(".")[0]
        return self.places.get(path, self.places.get("", ""))
