"""What a document must look like: shapes that read a value strictly, and that say themselves as
JSON Schema.

Every document goes through here: JSON in a session, whose further keys are free, and files that
somebody wrote (`daq.documents.grammar`), whose keys are closed and whose values know their lines. A
reading goes on after a mistake where it can, so that all of them are told at once.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import MISSING, dataclass, field, fields, is_dataclass
from typing import Any

from daq.documents.notes import Node, Notes, Unreadable, bare, quote, where_of
from daq.documents.scalars import LARGEST, Anything, Null, Number, Schema, Shape, Text, YesNo
from daq.strange_text import visible

__all__ = [
    "LARGEST", "Anything", "Choice", "Each", "Either", "Keys", "List", "Null", "Number", "OneOf",
    "Shape", "Text", "Then", "YesNo", "deviations", "one_of", "plain", "some_of",
]  # fmt: skip


def deviations(value: Any, shape: Shape, path: str = "") -> Iterator[str]:
    """One sentence for every place where plain data are not as a shape wants them; none for what
    fits.
    """
    notes = Notes()
    _tried(shape, value, path, notes)
    return (visible(mistake.sentence()) for mistake in notes.mistakes)


def plain(shape: Shape, value: Any) -> Any:
    """A value as plain data that its shape reads back to the same value."""
    if isinstance(shape, Keys) and value is not None:
        return {name: plain(part, getattr(value, name)) for name, part in shape.every().items()}
    if isinstance(value, tuple):
        return list(value)
    written = getattr(shape, "plain", None)
    return value if written is None else written(value)


_NOTHING = object()


def _tried(shape: Shape, node: Any, path: str, notes: Notes) -> Any:
    """The value of a node, or _NOTHING after its mistakes were noted."""
    try:
        return shape.read(node, path, notes)
    except Unreadable:
        return _NOTHING


@dataclass(frozen=True, repr=False)
class List:
    """A list of at least `least` and at most `most` values of one shape, each once where `unique`;
    `what` says what is in it."""

    item: Shape
    least: int = 0
    most: float = math.inf
    unique: bool = False
    what: str = ""

    def __str__(self) -> str:
        if self.what:
            return f"a list of {self.what}"
        most = f" and at most {self.most}" if self.most < math.inf else ""
        return (
            f"a list of at least {self.least}{most}"
            if not self.unique
            else f"a list of {self.item}"
        )

    def read(self, node: Any, path: str, notes: Notes) -> tuple[Any, ...]:
        values = bare(node)
        if not isinstance(values, list | tuple) or not self.least <= len(values) <= self.most:
            raise notes.refuse(node, path, self)
        if (
            isinstance(self.item, Number)
            and isinstance(values, list)
            and self.item.holds_all(values)
        ):
            return tuple(values)
        found: list[Any] = []
        for position, part in enumerate(values):
            value = _tried(self.item, part, self._path_of(part, path, position), notes)
            if self.unique and value in found:
                notes.reject(where_of(part), path, f"{quote(value)} twice", "each word once")
            elif value is not _NOTHING:
                found.append(value)
        if len(found) < len(values):
            notes.failed.add(path)
            raise Unreadable(path)
        return tuple(found)

    def _path_of(self, part: Any, path: str, position: int) -> str:
        """People count from 1, and need no number for a word or a number in a line of theirs."""
        if not isinstance(part, Node):
            return f"{path}[{position}]"
        return f"{path}[{position + 1}]" if isinstance(self.item, Keys | OneOf | Then) else path

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        found: Schema = {"type": "array", "items": self.item.schema(kinds), "minItems": self.least}
        found |= {} if math.isinf(self.most) else {"maxItems": self.most}
        return found | ({"uniqueItems": True} if self.unique else {})


def one_of(*words: str) -> Text:
    """The mark of a text that is one of these words."""
    return Text(words, as_written=True)


def some_of(*words: str) -> List:
    """The mark of a list of these words, each at most once."""
    return List(one_of(*words), unique=True)


@dataclass(frozen=True, repr=False)
class Each:
    """A mapping with values of one shape under keys of any name, or of those that `keys` allows."""

    item: Shape
    keys: Text | None = None
    what: str = "a mapping"

    def __str__(self) -> str:
        return self.what

    def read(self, node: Any, path: str, notes: Notes) -> dict[str, Any]:
        entries = bare(node)
        if not isinstance(entries, dict):
            raise notes.refuse(node, path, self)
        found = {}
        for key, part in entries.items():
            full = f"{path}.{key}" if path else str(key)
            if (
                self.keys is None
                or _tried(self.keys, _key_of(node, key), full, notes) is not _NOTHING
            ):
                found[key] = _tried(self.item, part, full, notes)
        if len(found) < len(entries) or any(value is _NOTHING for value in found.values()):
            raise Unreadable(path)
        return found

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        names = {} if self.keys is None else {"propertyNames": self.keys.schema(kinds)}
        return {"type": "object", **names, "additionalProperties": self.item.schema(kinds)}


def _key_of(node: Any, key: str) -> Any:
    return Node(node.key_places[key], key, key) if isinstance(node, Node) else key


@dataclass(frozen=True, repr=False)
class Keys:
    """A mapping with these keys, and those in `optional` where it has them; null where it says so.

    Keys that the shape does not name are free, unless it is closed. `as_long`: keys of lists that
    must have as many entries as the first of them. `kind`: the class that the mapping becomes.
    `alone`: keys that a plain value in the place of the mapping stands for. `groups`: further keys,
    all that a regular expression matches, of one shape. `what` says what the mapping is, `names`
    what its keys are, where they are too many to name. `standing_in`: what takes the place of a
    required value that is missing, so that the reading goes on.
    """

    required: Mapping[str, Shape]
    optional: Mapping[str, Shape] = field(default_factory=dict)
    as_long: tuple[str, ...] = ()
    null: bool = False
    closed: bool = False
    kind: Callable[..., Any] | None = None
    alone: tuple[str, ...] = ()
    groups: Mapping[str, Shape] = field(default_factory=dict)
    what: str = ""
    names: str = ""
    standing_in: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        listed = f"a mapping with the keys {self.allowed_keys()}" if self.closed else "a mapping"
        return f"{self.what or listed}{' or null' if self.null and not self.closed else ''}"

    def every(self) -> dict[str, Shape]:
        """The shape of every key, those of the class in its order."""
        found = {**self.required, **self.optional}
        return (
            {item.name: found[item.name] for item in fields(self.kind)}
            if is_dataclass(self.kind)
            else found
        )

    def allowed_keys(self) -> str:
        """The keys in words."""
        return self.names or ", ".join(self.every())

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        entries = bare(node)
        if entries is None and self.null:
            return None
        where = where_of(node)
        if isinstance(node, Node):
            notes.places[path] = where
        if self.alone and not isinstance(entries, dict | list | tuple) and entries is not None:
            entries = dict.fromkeys(self.alone, node)
        if not isinstance(entries, dict):
            raise notes.refuse(node, path, self)
        given = self._values(node, entries, path, notes)
        self._note_missing([key for key in self.required if key not in entries], where, path, notes)
        lists = [entries[key] for key in self.as_long if isinstance(entries.get(key), list)]
        if len({len(values) for values in lists}) > 1:
            several = f"{path}.{', '.join(self.as_long)}" if path else ", ".join(self.as_long)
            notes.reject(where, several, "are not equally long", "")
        given = {**self.standing_in, **given}
        if not self.required.keys() <= given.keys():
            raise Unreadable(path)
        return given if self.kind is None else self.kind(**given)

    def _values(
        self, node: Any, entries: Mapping[str, Any], path: str, notes: Notes
    ) -> dict[str, Any]:
        given = {}
        for key, part in entries.items():
            full = f"{path}.{key}" if path else str(key)
            shape = self.required.get(key) or self.optional.get(key) or self._group(key)
            if shape is not None:
                if isinstance(part, Node):
                    notes.places[full] = part.where
                value = _tried(shape, part, full, notes)
                if value is not _NOTHING:
                    given[key] = value
            elif self.closed:
                homes = (
                    f"did you mean {home}?"
                    for home in notes.known
                    if home.rpartition(".")[2] == key
                )
                hint = notes.near(key, [*self.required, *self.optional]) or (
                    "" if self.names else next(homes, "")
                )
                notes.reject(
                    where_of(_key_of(node, key)),
                    full,
                    f"the key {quote(key)}",
                    self.allowed_keys(),
                    hint,
                )
        return given

    def _group(self, key: str) -> Shape | None:
        return next(
            (shape for pattern, shape in self.groups.items() if re.fullmatch(pattern, key)), None
        )

    def _note_missing(self, missing: list[str], where: str, path: str, notes: Notes) -> None:
        if self.closed and path and missing:
            keys = ", ".join(missing)
            notes.reject(where, path, f"no {keys}", f"{self.what or 'a mapping'} with {keys}")
            return
        for key in missing:
            full = f"{path}.{key}" if path else key
            told = str(self.required[key])
            wanted = (
                told
                if isinstance(self.required[key], Text) and told != "text"
                else f"an entry {key}"
            )
            notes.reject(where, full, *(("nothing", wanted) if self.closed else ("is missing", "")))

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        if not is_dataclass(self.kind):
            return self.body(kinds)
        name = str(getattr(self.kind, "__name__", ""))
        if name not in kinds:
            kinds[name] = {}  # its place, before those of its parts
            kinds[name] = self.body(kinds)
        forms = [{"$ref": f"#/$defs/{name}"}]
        forms += [self.every()[self.alone[0]].schema(kinds)] if self.alone else []
        forms += [{"type": "null"}] if self.null else []
        return {"anyOf": forms} if len(forms) > 1 else forms[0]

    def body(self, kinds: dict[str, Schema]) -> Schema:
        """The schema itself, in the place of a reference to it."""
        null = self.null and self.kind is None
        found: Schema = {"type": ["object", "null"] if null else "object"}
        found["properties"] = {
            name: part.schema(kinds) | self._default(name) for name, part in self.every().items()
        }
        found |= {"required": list(self.required)} if self.required or not self.closed else {}
        patterns = {f"^{pattern}$": shape.schema(kinds) for pattern, shape in self.groups.items()}
        found |= {"patternProperties": patterns} if patterns else {}
        found |= {"additionalProperties": False} if self.closed else {}
        told = " ".join((self.kind.__doc__ or "").split()) if self.kind is not None else self.what
        return found | ({"description": told} if told else {})

    def default_of(self, name: str) -> Any:
        """The class's own default as plain data, MISSING for none; a group's stand at its own
        fields.
        """
        kind = self.kind if is_dataclass(self.kind) else None
        default = (
            next((item.default for item in fields(kind) if item.name == name), MISSING)
            if kind
            else MISSING
        )
        if default is MISSING or is_dataclass(default) or name in self.required:
            return MISSING
        shape = self.every()[name]
        written = shape.says.get("default") if isinstance(shape, Then) else None
        return plain(shape, default) if written is None else written

    def _default(self, name: str) -> Schema:
        default = self.default_of(name)
        return {} if default is MISSING else {"default": default}


@dataclass(frozen=True, repr=False)
class Choice:
    """A mapping whose shape hangs on the word under `key`."""

    key: str
    shapes: Mapping[str, Keys]

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        entries = bare(node)
        word = entries.get(self.key) if isinstance(entries, dict) else node
        shape = self.shapes.get(bare(word)) if isinstance(bare(word), str) else None
        if shape is None:
            full = f"{path}.{self.key}" if path else self.key
            raise notes.refuse(word, full, f"one of {', '.join(self.shapes)}")
        return shape.read(node, path, notes)

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        return {"oneOf": [self._case(word, keys.body(kinds)) for word, keys in self.shapes.items()]}

    def _case(self, word: str, found: Schema) -> Schema:
        properties = found["properties"] | {self.key: {"const": word}}
        return found | {"properties": properties, "required": [self.key, *found["required"]]}


@dataclass(frozen=True, repr=False)
class OneOf:
    """A mapping whose shape hangs on which of these keys it has; exactly one of them. The shapes
    are closed, and a key that several of them have is the same in each. `what` it is, in words."""

    shapes: Mapping[str, Keys]
    what: str

    def every(self) -> dict[str, Shape]:
        """The shape of every key that one of the shapes has."""
        return {key: part for shape in self.shapes.values() for key, part in shape.every().items()}

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        entries = bare(node)
        if not isinstance(entries, dict):
            raise notes.refuse(node, path, f"a mapping for each {self.what}")
        kinds = [key for key in entries if key in self.shapes]
        if len(kinds) == 1:
            return self.shapes[kinds[0]].read(node, path, notes)
        _tried(Keys({}, dict.fromkeys(self.every(), Anything()), closed=True), node, path, notes)
        found = f"the kinds {' and '.join(kinds)}" if kinds else f"a {self.what} without a kind"
        raise notes.reject(where_of(node), path, found, f"one of {', '.join(self.shapes)}")

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        return {
            "type": "object",
            "properties": {name: part.schema(kinds) for name, part in self.every().items()},
            "required": sorted(
                set.intersection(*(set(part.required) for part in self.shapes.values()))
            ),
            "additionalProperties": False,
            "oneOf": [{"required": [key]} for key in self.shapes],
            "allOf": [_rule(key, part) for key, part in self.shapes.items()],
        }


def _rule(key: str, shape: Keys) -> Schema:
    """What goes with a key of `OneOf`."""
    then = {"required": list(shape.required), "propertyNames": {"enum": list(shape.every())}}
    return {"if": {"required": [key]}, "then": then}


@dataclass(frozen=True, repr=False)
class Either:
    """A value of one shape or of another."""

    first: Shape
    second: Shape

    def __str__(self) -> str:
        return f"{self.first}, or {self.second}"

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        """The value; the mistakes are those of the shape that a mapping, or that anything but null,
        was meant for.
        """
        first, second = (Notes(known=notes.known, renamed=notes.renamed) for _ in range(2))
        value = _tried(self.first, node, path, first)
        found = first
        if first.mistakes:
            value = _tried(self.second, node, path, second)
            mapping = isinstance(bare(node), dict) and isinstance(self.second, Keys)
            found = (
                second if not second.mistakes or mapping or isinstance(self.first, Null) else first
            )
        notes.add(found)
        if found.mistakes:
            raise Unreadable(path)
        return value

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        return {"anyOf": [self.first.schema(kinds), self.second.schema(kinds)]}


@dataclass(frozen=True, repr=False)
class Then:
    """A value of a shape, and what `build` makes of it: build(value, node, path, notes), which
    notes what does not fit together. `says`: what JSON Schema can know of that."""

    shape: Shape
    build: Callable[[Any, Any, str, Notes], Any]
    says: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        return str(self.shape)

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        return self.build(self.shape.read(node, path, notes), node, path, notes)

    def plain(self, value: Any) -> Any:
        """As the shape alone."""
        return plain(self.shape, value)

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        return {**self.shape.schema(kinds), **self.says}

    def body(self, kinds: dict[str, Schema]) -> Schema:
        """The schema itself, in the place of a reference to it."""
        return {**getattr(self.shape, "body", self.shape.schema)(kinds), **self.says}
