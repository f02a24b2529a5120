"""Shapes of lists and mappings: each reads a value strictly and returns itself as JSON Schema.

Every document is read here: the JSON in a session, which may have further keys, and the files that
people write, whose keys are closed and whose values know their lines (`daq.documents.classes` makes
the shapes of both). Reading continues after a mistake where it can, so that all mistakes of a
document are reported at once.
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
    """Yield a sentence for every place where plain data deviate from a shape."""
    notes = Notes()
    _tried(shape, value, path, notes)
    return (visible(mistake.sentence()) for mistake in notes.mistakes)


def plain(shape: Shape, value: Any) -> Any:
    """Return a value as plain data, which its shape reads back to the same value."""
    if isinstance(shape, Keys) and value is not None:
        return {name: plain(part, getattr(value, name)) for name, part in shape.every().items()}
    if isinstance(value, tuple):
        return list(value)
    written = getattr(shape, "plain", None)
    return value if written is None else written(value)


_NOTHING = object()  # None is a value


def _tried(shape: Shape, node: Any, path: str, notes: Notes) -> Any:
    """Return the value of a node, or _NOTHING after noting its mistakes."""
    try:
        return shape.read(node, path, notes)
    except Unreadable:
        return _NOTHING


@dataclass(frozen=True, repr=False)
class List:
    """A list of `least` to `most` values of one shape, each at most once where `unique`; `what`
    names the values in messages.
    """

    item: Shape
    least: int = 0
    most: float = math.inf
    unique: bool = False
    what: str = ""

    def __str__(self) -> str:
        if self.what:
            return f"a list of {self.what}"
        if self.unique:
            return f"a list of {self.item}"
        most = f" and at most {self.most}" if self.most < math.inf else ""
        return f"a list of at least {self.least}{most}"

    def read(self, node: Any, path: str, notes: Notes) -> tuple[Any, ...]:
        values = bare(node)
        if not isinstance(values, list | tuple) or not self.least <= len(values) <= self.most:
            raise notes.refuse(node, path, self)
        # Long lists of numbers (signals in a session's documents) are checked as a whole.
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
        """Return the path of an item for messages: counted from 0 in plain data, from 1 in a file,
        where a word or number has none, because its line is given.
        """
        if not isinstance(part, Node):
            return f"{path}[{position}]"
        return f"{path}[{position + 1}]" if isinstance(self.item, Keys | OneOf | Then) else path

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        found: Schema = {"type": "array", "items": self.item.schema(kinds), "minItems": self.least}
        found |= {} if math.isinf(self.most) else {"maxItems": self.most}
        return found | ({"uniqueItems": True} if self.unique else {})


def one_of(*words: str) -> Text:
    """Return the mark of a text that is one of these words."""
    return Text(words, as_written=True)


def some_of(*words: str) -> List:
    """Return the mark of a list of these words, each at most once."""
    return List(one_of(*words), unique=True)


@dataclass(frozen=True, repr=False)
class Each:
    """A mapping of values of one shape, under any key that `keys` allows; None allows every key."""

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
    """Return a key of a mapping as a node with its own place, or as it is in plain data."""
    return Node(node.key_places[key], key, key) if isinstance(node, Node) else key


@dataclass(frozen=True, repr=False)
class Keys:
    """A mapping with the keys of `required`, and optionally those of `optional`.

    as_long : keys of lists that must have equal lengths
    null : whether null is allowed instead of the mapping
    closed : whether other keys are refused; they are ignored otherwise
    kind : class that is made from the values; None returns them as a dict
    alone : keys that a plain value instead of the mapping is given to
    groups : regular expression -> shape of all keys that match it
    what : name of the mapping in messages
    names : description of the keys in messages, where there are too many to list
    standing_in : values for required keys that are missing, so that reading can continue
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
        kind = f"a mapping with the keys {self.allowed_keys()}" if self.closed else "a mapping"
        null = " or null" if self.null and not self.closed else ""
        return f"{self.what or kind}{null}"

    def every(self) -> dict[str, Shape]:
        """Return the shape of every key, in the order of the class's fields if there is one."""
        found = {**self.required, **self.optional}
        if not is_dataclass(self.kind):
            return found
        return {item.name: found[item.name] for item in fields(self.kind)}

    def allowed_keys(self) -> str:
        """Return the keys in words, for messages."""
        return self.names or ", ".join(self.every())

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        entries = bare(node)
        if entries is None and self.null:
            return None
        where = where_of(node)
        if isinstance(node, Node):
            notes.places[path] = where
        plain_value = not isinstance(entries, dict | list | tuple) and entries is not None
        if self.alone and plain_value:
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
        """Return the values of the keys that could be read; note unknown keys where closed."""
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
                hint = notes.near(key, [*self.required, *self.optional])
                if not hint and not self.names:  # the key of another mapping of the document?
                    homes = (path for path in notes.known if path.rpartition(".")[2] == key)
                    hint = next((f"did you mean {home}?" for home in homes), "")
                notes.reject(
                    where_of(_key_of(node, key)),
                    full,
                    f"the key {quote(key)}",
                    self.allowed_keys(),
                    hint,
                )
        return given

    def _group(self, key: str) -> Shape | None:
        """Return the shape of the group that a key belongs to, None for none."""
        for pattern, shape in self.groups.items():
            if re.fullmatch(pattern, key):
                return shape
        return None

    def _note_missing(self, missing: list[str], where: str, path: str, notes: Notes) -> None:
        """Note missing keys: together in a mapping inside a file, one by one elsewhere."""
        if self.closed and path and missing:
            keys = ", ".join(missing)
            notes.reject(where, path, f"no {keys}", f"{self.what or 'a mapping'} with {keys}")
            return
        for key in missing:
            full = f"{path}.{key}" if path else key
            if not self.closed:
                notes.reject(where, full, "is missing", "")
                continue
            shape = self.required[key]
            listed = isinstance(shape, Text) and str(shape) != "text"  # its words say more
            notes.reject(where, full, "nothing", str(shape) if listed else f"an entry {key}")

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        if not is_dataclass(self.kind):
            return self.body(kinds)
        name = str(getattr(self.kind, "__name__", ""))
        if name not in kinds:
            kinds[name] = {}  # takes its position before those of its parts
            kinds[name] = self.body(kinds)
        forms = [{"$ref": f"#/$defs/{name}"}]
        forms += [self.every()[self.alone[0]].schema(kinds)] if self.alone else []
        forms += [{"type": "null"}] if self.null else []
        return {"anyOf": forms} if len(forms) > 1 else forms[0]

    def body(self, kinds: dict[str, Schema]) -> Schema:
        """Return the schema itself, where `schema` returns a reference to it."""
        null = self.null and self.kind is None
        found: Schema = {"type": ["object", "null"] if null else "object"}
        found["properties"] = {
            name: part.schema(kinds) | self._default(name) for name, part in self.every().items()
        }
        found |= {"required": list(self.required)} if self.required or not self.closed else {}
        patterns = {f"^{pattern}$": shape.schema(kinds) for pattern, shape in self.groups.items()}
        found |= {"patternProperties": patterns} if patterns else {}
        found |= {"additionalProperties": False} if self.closed else {}
        about = " ".join((self.kind.__doc__ or "").split()) if self.kind is not None else self.what
        return found | ({"description": about} if about else {})

    def default_of(self, name: str) -> Any:
        """Return the default of a key as plain data, MISSING for none.

        A group has none of its own: the defaults are those of its fields.
        """
        defaults: dict[str, Any] = {}
        if is_dataclass(self.kind):
            defaults = {item.name: item.default for item in fields(self.kind)}
        default = defaults.get(name, MISSING)
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
    """A mapping whose shape depends on the word under `key`."""

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
    """A mapping that has exactly one of these keys, on which its shape depends.

    The shapes are closed, and a key that several of them have is the same in each. `what` names the
    mapping in messages.
    """

    shapes: Mapping[str, Keys]
    what: str

    def every(self) -> dict[str, Shape]:
        """Return the shape of every key that at least one of the shapes has."""
        return {key: part for shape in self.shapes.values() for key, part in shape.every().items()}

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        entries = bare(node)
        if not isinstance(entries, dict):
            raise notes.refuse(node, path, f"a mapping for each {self.what}")
        kinds = [key for key in entries if key in self.shapes]
        if len(kinds) == 1:
            return self.shapes[kinds[0]].read(node, path, notes)
        # Without a kind no value can be read, but a misspelt key can be named.
        _tried(Keys({}, dict.fromkeys(self.every(), Anything()), closed=True), node, path, notes)
        found = f"the kinds {' and '.join(kinds)}" if kinds else f"a {self.what} without a kind"
        raise notes.reject(where_of(node), path, found, f"one of {', '.join(self.shapes)}")

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        in_all = set.intersection(*(set(part.required) for part in self.shapes.values()))
        return {
            "type": "object",
            "properties": {name: part.schema(kinds) for name, part in self.every().items()},
            "required": sorted(in_all),
            "additionalProperties": False,
            "oneOf": [{"required": [key]} for key in self.shapes],
            "allOf": [_rule(key, part) for key, part in self.shapes.items()],
        }


def _rule(key: str, shape: Keys) -> Schema:
    """Return the schema rule of a key of `OneOf`: the keys that it requires and allows."""
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
        """Return the value as the first shape reads it or, failing that, the second.

        Where both fail, the mistakes of one are reported: of the second if the value is a mapping
        and so is the shape, or if the first is null; of the first otherwise.
        """
        first, second = (
            Notes(known=notes.known, renamed=notes.renamed, meaning=notes.meaning) for _ in range(2)
        )
        value = _tried(self.first, node, path, first)
        found = first
        if first.mistakes:
            value = _tried(self.second, node, path, second)
            mapping = isinstance(bare(node), dict) and isinstance(self.second, Keys)
            if not second.mistakes or mapping or isinstance(self.first, Null):
                found = second
        notes.add(found)
        if found.mistakes:
            raise Unreadable(path)
        return value

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        return {"anyOf": [self.first.schema(kinds), self.second.schema(kinds)]}


@dataclass(frozen=True, repr=False)
class Then:
    """A value of a shape, converted or checked further by `build(value, node, path, notes)`, which
    notes mistakes of the values taken together. `says`: keywords of JSON Schema for these checks.
    """

    shape: Shape
    build: Callable[[Any, Any, str, Notes], Any]
    says: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        return str(self.shape)

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        return self.build(self.shape.read(node, path, notes), node, path, notes)

    def plain(self, value: Any) -> Any:
        """Return the value as plain data, as the shape alone writes it."""
        return plain(self.shape, value)

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        return {**self.shape.schema(kinds), **self.says}

    def body(self, kinds: dict[str, Schema]) -> Schema:
        """Return the schema itself, where `schema` returns a reference to it."""
        return {**getattr(self.shape, "body", self.shape.schema)(kinds), **self.says}
