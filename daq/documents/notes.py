"""Values that know where they were written, and the mistakes that a reader notes in them."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable, Mapping
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

    where : `file:line` or the command-line option, may be empty
    field : full path of the key, may be empty
    found, allowed : phrases
    hint : a question or an advice, such as "did you mean 'fill'?"
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
        """Return the message for a document of a program, whose values have no lines."""
        said = f"is {self.found}, expected {self.allowed}" if self.allowed else self.found
        return f"{self.field} {said}{self._advice()}"

    def _advice(self) -> str:
        return f"; {self.hint}" if self.hint else ""


def quote(value: object) -> str:
    """Return a user's value for a message: shortened, control characters escaped."""
    text = repr(value)
    return text if len(text) <= LONGEST_QUOTE else f"{text[: LONGEST_QUOTE - 3]}..."


def nearest(word: str, choices: Iterable[str]) -> str:
    """Return the hint "did you mean ...?" for a misspelt word, "" if no choice is similar."""
    close = difflib.get_close_matches(word[:LONGEST_QUOTE], list(choices), n=1, cutoff=0.6)
    return f"did you mean {close[0]!r}?" if close else ""


def new_name(word: str, choices: Iterable[str], renamed: Mapping[str, str]) -> str:
    """Return the hint "renamed: write ..." for an old name, or a path with old names in it; "" for
    any other word.

    renamed : old name -> new name, after a blank with a note for the user
    """
    parts = [renamed.get(part, part).partition(" ") for part in word.split(".")]
    now, note = ".".join(part[0] for part in parts), "".join(part[2] for part in parts)
    more = f" {note}" if note else ""
    return f"renamed: write {now!r}{more}" if now != word and now in choices else ""


def in_order(mistakes: Iterable[Mistake]) -> list[Mistake]:
    """Return mistakes in the order of their lines: at most MOST_MISTAKES, and one that counts the
    rest.
    """
    ordered = sorted(mistakes, key=_line)
    more = len(ordered) - MOST_MISTAKES
    if more <= 0:
        return ordered
    return [*ordered[:MOST_MISTAKES], Mistake("", "", f"{more} more mistakes", "none")]


def _line(mistake: Mistake) -> float:
    """Return the line of a mistake, infinity for none."""
    number = mistake.where.rpartition(":")[2]
    return int(number) if number.isdecimal() else math.inf


@dataclass(frozen=True)
class Node:
    """A value and its place in a file.

    where : `file:line`
    value : a scalar, a tuple of nodes or a dict of nodes
    text : a scalar as written
    key_places : key of a dict -> where the key was written
    quoted : whether the text was written in quotes
    """

    where: str
    value: Scalar | tuple[Node, ...] | dict[str, Node]
    text: str = ""
    key_places: dict[str, str] = field(default_factory=dict)
    quoted: bool = False

    def plain(self) -> Any:
        """Return the value as nested dicts, lists and scalars."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, tuple):
            return [node.plain() for node in self.value]
        return self.value


def node_of(data: Any, where: str = "") -> Node:
    """Return the tree of plain data, every place `where`."""
    if isinstance(data, Mapping):
        entries = {key: node_of(part, where) for key, part in data.items()}
        return Node(where, entries, key_places=dict.fromkeys(entries, where))
    if isinstance(data, list | tuple):
        return Node(where, tuple(node_of(part, where) for part in data))
    return Node(where, data, text=str(data))


def bare(node: Any) -> Any:
    """Return the value of a node; plain data as they are."""
    return node.value if type(node) is Node else node


def where_of(node: Any) -> str:
    """Return where a node was written; "" for plain data."""
    return node.where if type(node) is Node else ""


def describe(node: Any) -> str:
    """Return a description of a node or a plain value, for a message."""
    value = bare(node)
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, list | tuple):
        return "a list"
    if value is None:
        return "null" if node is None else "nothing"
    return node.text[:60] if type(node) is Node and not isinstance(value, str) else quote(value)


class Unreadable(Exception):
    """A value could not be read; its mistake is noted already."""


@dataclass
class Notes:
    """Notes taken while a document is read.

    mistakes : all of them
    failed : paths whose value could not be read
    places : path -> where it was written
    known : every path of the document's grammar, to suggest the right place of a misplaced key
    renamed : old name -> new name
    meaning : returns what a name stands for that is defined beside the document; None where
        names stand for themselves
    """

    mistakes: list[Mistake] = field(default_factory=list)
    failed: set[str] = field(default_factory=set)
    places: dict[str, str] = field(default_factory=dict)
    known: tuple[str, ...] = ()
    renamed: Mapping[str, str] = field(default_factory=dict)
    meaning: Callable[[str], Any] | None = None

    def near(self, word: str, choices: Iterable[str]) -> str:
        """Return the hint for a word that is not among the choices: its new name, or the most
        similar choice.
        """
        return new_name(word, choices, self.renamed) or nearest(word, choices)

    def reject(self, where: str, path: str, found: str, allowed: str, hint: str = "") -> Unreadable:
        """Note a mistake. Returns the exception to raise where the caller cannot continue."""
        self.mistakes.append(Mistake(where, path, found, allowed, hint))
        self.failed.add(path)
        return Unreadable(path)

    def refuse(self, node: Any, path: str, allowed: object, hint: str = "") -> Unreadable:
        """Note that a value is not of the allowed kind. Returns the exception, as `reject` does."""
        return self.reject(where_of(node), path, describe(node), str(allowed), hint)

    def add(self, other: Notes) -> None:
        """Add the notes of another reading."""
        self.mistakes += other.mistakes
        self.failed |= other.failed
        self.places |= other.places

    def spoilt(self, path: str) -> bool:
        """Return whether a value inside the mapping at a path could not be read."""
        return any(failed.startswith(f"{path}.") for failed in self.failed)

    def place_of(self, path: str) -> str:
        """Return where a path, or the innermost mapping around it, was written; "" for none."""
        while path not in self.places and "." in path:
            path = path.rpartition(".")[0]
        return self.places.get(path, self.places.get("", ""))
