"""Read YAML text to a tree of values that know their place.

Accepted is only what all YAML readers read alike: mappings with words as keys, lists, text,
integers, decimals, true, false and null (YAML 1.2 core schema). Tags, several documents, repeated
keys and sizes beyond the bounds are mistakes, so that a file can neither execute code nor exhaust
the memory.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import yaml

from daq.documents.notes import Node, Notes, Scalar, Unreadable
from daq.documents.shapes import Shape
from daq.regular_files import open_regular
from rig.errors import InputError, Mistake, in_order, quote

MAX_BYTES = 1 << 20
MAX_NODES = 20000
MAX_DEPTH = 20

_INTEGER = re.compile(r"[-+]?\d{1,300}", re.ASCII)
_DECIMAL = re.compile(r"[-+]?(?:\d{1,300}\.?\d{0,300}|\.\d{1,300})(?:[eE][-+]?\d{1,9})?", re.ASCII)
_NOT_FINITE = re.compile(r"[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)")
_WORDS: dict[str, Scalar] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
}
_LOADERS: tuple[Any, ...] = (getattr(yaml, "CSafeLoader", yaml.SafeLoader), yaml.SafeLoader)
"""Parsers in the order in which they are tried. The first, where it is installed, is fast, but has
limits of its own that differ between versions. A text that it refuses is read by the second, which
has none, so that bounds and messages are the same everywhere.
"""


def read_file(path: Path) -> str:
    """Return the text of a file of at most MAX_BYTES of UTF-8. Raises InputError."""
    try:
        with open_regular(path) as stream:
            data = stream.read(MAX_BYTES + 1) or b""
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        found = (getattr(error, "strerror", None) or "an impossible path").lower()
        raise InputError(Mistake(str(path), "", found, "a readable file")) from error
    if len(data) > MAX_BYTES:
        raise InputError(
            Mistake(str(path), "", "a file of more than 1 MiB", "at most 1 MiB of YAML")
        )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(
            Mistake(f"{path}:{line}", "", "bytes that are not UTF-8", "YAML text in UTF-8")
        ) from error


def read_yaml(text: str, source: str, mistakes: list[Mistake]) -> Node:
    """Return the tree of one YAML document; places read `source:line`.

    Mistakes after which the rest can still be read (a repeated key, a tag, a key that is not a
    word) are added to `mistakes`; any other raises InputError.
    """
    return _read(text, source, lambda line: f"{source}:{line + 1}", mistakes)


def read_document(shape: Shape, root: Node, notes: Notes) -> Any:
    """Return the value of a tree as its shape reads it. Raises InputError with every mistake, in
    the order of the lines.
    """
    value = None
    with suppress(Unreadable):
        value = shape.read(root, "", notes)
    if notes.mistakes:
        raise InputError(*in_order(notes.mistakes))
    return value


def read_value(text: str, place: str) -> Node:
    """Return the tree of a value given on the command line; every place in it reads `place`.
    Raises InputError.
    """
    mistakes: list[Mistake] = []
    node = _read(text, place, lambda _line: place, mistakes)
    if mistakes:
        raise InputError(*mistakes)
    return node


def _read(text: str, source: str, place: Callable[[int], str], mistakes: list[Mistake]) -> Node:
    """Return the tree of a text; `place` gives the place of a line, counted from 0."""
    if len(text) > MAX_BYTES:
        raise InputError(Mistake(source, "", "a text of more than 1 MiB", "at most 1 MiB of YAML"))
    *first, last = _LOADERS
    for loader in first:
        found: list[Mistake] = []  # of this parser only: the next one finds them again
        with suppress(yaml.MarkedYAMLError):
            root = _Builder(place, found).read(text, source, loader)
            mistakes += found
            return root
    try:
        return _Builder(place, mistakes).read(text, source, last)
    except yaml.MarkedYAMLError as error:
        raise InputError(_syntax_mistake(error, text, source, place)) from error


def _syntax_mistake(
    error: yaml.MarkedYAMLError, text: str, source: str, place: Callable[[int], str]
) -> Mistake:
    """Return a parser's error as a mistake, with a hint where the line is indented with tabs."""
    mark = error.problem_mark or error.context_mark
    problem = " ".join(filter(None, (error.context, error.problem))).removeprefix("found ")
    if mark is None:
        return Mistake(source, "", problem, "YAML")
    line = "".join(text.splitlines()[mark.line : mark.line + 1])
    tabs = "\t" in line[: len(line) - len(line.lstrip())]
    hint = "indent with spaces, not with tabs" if tabs else ""
    return Mistake(place(mark.line), "", f"no YAML: {problem}", "YAML", hint)


class _Builder:
    """Builds nodes from parser events and counts them, so that a file over the bounds is refused
    before its memory is used.
    """

    def __init__(self, place: Callable[[int], str], mistakes: list[Mistake]) -> None:
        self.place = place
        self.mistakes = mistakes
        self.nodes = 0
        self.anchors: dict[str, tuple[Node, int]] = {}

    def read(self, text: str, source: str, loader: Any) -> Node:
        """Return the tree of a text. Raises InputError, or the parser's own error for a syntax that
        it refuses.
        """
        try:
            text.encode("utf-8")
            return self._document(yaml.parse(text, Loader=loader), source)
        except (yaml.reader.ReaderError, UnicodeEncodeError) as error:
            raise InputError(
                Mistake(source, "", "characters that are not text", "YAML text in UTF-8")
            ) from error

    def _document(self, events: Iterator[Any], source: str) -> Node:
        """Return the tree of the only document. Raises InputError for none, or for a second."""
        root: Node | None = None
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent):
                first = next(events)
                if root is not None:
                    where = self.place(first.start_mark.line)
                    raise InputError(Mistake(where, "", "a second document", "one document"))
                root = self._node(first, events, 1)
        if root is None or (root.value is None and not root.text):
            raise InputError(Mistake(source, "", "an empty text", "a YAML mapping"))
        return root

    def _node(self, event: Any, events: Iterator[Any], depth: int) -> Node:
        """Return the node that begins with an event, and take its further events."""
        where = self.place(event.start_mark.line)
        self._count(1, where)
        if depth > MAX_DEPTH:
            raise InputError(
                Mistake(where, "", f"more than {MAX_DEPTH} levels", f"at most {MAX_DEPTH} levels")
            )
        if isinstance(event, yaml.AliasEvent):
            return self._alias(event, where)
        if event.tag not in (None, "!"):
            self.mistakes.append(
                Mistake(where, "", f"the tag {quote(event.tag)}", "plain YAML without tags")
            )
        before = self.nodes
        if isinstance(event, yaml.MappingStartEvent):
            node = self._mapping(events, where, depth)
        elif isinstance(event, yaml.SequenceStartEvent):
            node = Node(where, tuple(self._items(events, depth)))
        else:
            plain = event.implicit[0]  # written without quotes
            node = Node(
                where,
                scalar(event.value) if plain else event.value,
                text=event.value,
                quoted=not plain,
            )
        if event.anchor is not None:  # with its size: an alias counts as often as it is used
            self.anchors[event.anchor] = (node, self.nodes - before)
        return node

    def _items(self, events: Iterator[Any], depth: int) -> Iterator[Node]:
        """Yield the items of a list."""
        for event in events:
            if isinstance(event, yaml.SequenceEndEvent):
                return
            yield self._node(event, events, depth + 1)

    def _mapping(self, events: Iterator[Any], where: str, depth: int) -> Node:
        """Return a mapping; keys that are repeated or not words are noted and left out."""
        entries: dict[str, Node] = {}
        places: dict[str, str] = {}
        for event in events:
            if isinstance(event, yaml.MappingEndEvent):
                break
            key_node = self._node(event, events, depth + 1)
            key = event.value if isinstance(event, yaml.ScalarEvent) else None
            value = self._node(next(events), events, depth + 1)
            if key is None:
                self.mistakes.append(
                    Mistake(key_node.where, "", "a key that is not a word", "words as keys")
                )
            elif key in entries:
                allowed = f"each key once (it stands at {places[key]} too)"
                self.mistakes.append(
                    Mistake(key_node.where, "", f"the key {quote(key)} again", allowed)
                )
            else:
                entries[key], places[key] = value, key_node.where
        return Node(where, entries, key_places=places)

    def _alias(self, event: Any, where: str) -> Node:
        """Return the value that an alias refers to."""
        known = self.anchors.get(event.anchor)
        if known is None:
            raise InputError(
                Mistake(
                    where, "", f"the alias *{event.anchor}", "aliases of earlier, complete values"
                )
            )
        self._count(known[1], where)
        return known[0]

    def _count(self, more: int, where: str) -> None:
        """Count nodes. Raises InputError for too many."""
        self.nodes += more
        if self.nodes > MAX_NODES:
            raise InputError(
                Mistake(where, "", f"more than {MAX_NODES} values", f"at most {MAX_NODES} values")
            )


def scalar(text: str) -> Scalar:
    """Return the value of an unquoted scalar."""
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text):
        return int(text)
    if _DECIMAL.fullmatch(text):
        return float(text)
    if _NOT_FINITE.fullmatch(text):
        return float(text.replace(".", ""))
    return text
