"""The interface `Shape`, which reads a value strictly and returns itself as JSON Schema, and the
shapes of single values.

Every number is finite and at most LARGEST in magnitude, so that no arithmetic on a checked value
can overflow.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from daq.documents.notes import Node, Notes, bare, quote, where_of

__all__ = ["LARGEST", "Anything", "Null", "Number", "Schema", "Shape", "Text", "YesNo"]

LARGEST = 1e15

Schema = dict[str, Any]


@runtime_checkable
class Shape(Protocol):
    """The values that a document may have at one place; str() describes them in words."""

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        """Return the value of a node or of plain data. Raises Unreadable after noting why not.

        path : of the value, for messages
        """

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        """Return the shape as JSON Schema (draft 2020-12); classes that it refers to are added to
        `kinds`.
        """


class _Scalar:
    """Base of the shapes of single values."""

    def holds(self, value: object) -> bool:
        """Return whether a value is allowed."""
        raise NotImplementedError

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        """Return the value unchanged."""
        value = bare(node)
        if not self.holds(value):
            raise notes.refuse(node, path, self)
        return value


@dataclass(frozen=True, repr=False)
class Anything(_Scalar):
    """Any value, read by somebody else later: a node stays a node. `says`: its JSON Schema."""

    says: Mapping[str, Any] = field(default_factory=dict)

    def read(self, node: Any, _path: str, _notes: Notes) -> Any:
        """Return the node."""
        return node

    def schema(self, _kinds: dict[str, Schema]) -> Schema:
        return dict(self.says)


@dataclass(frozen=True, repr=False)
class Number(_Scalar):
    """A number from `least` to `most`.

    above : whether `least` itself is excluded
    whole : whether it must be a whole number
    null : whether null is allowed
    """

    least: float = -LARGEST
    most: float = LARGEST
    above: bool = False
    whole: bool = False
    null: bool = False

    def __str__(self) -> str:
        kind = "a whole number" if self.whole else "a number"
        low = ""
        if self.above:
            low = f" above {self.least:g}"
        elif self.least > -LARGEST:
            low = f" from {self.least:g}"
        high = f" to {self.most:g}" if self.most < LARGEST else ""
        return f"{kind}{low}{high}{' or null' if self.null else ''}"

    def holds(self, value: object) -> bool:
        if value is None:
            return self.null
        if isinstance(value, bool) or not isinstance(value, int | float):
            return False
        # Not asked of an int: it may be too large for any float.
        if isinstance(value, float) and not math.isfinite(value):
            return False
        inside = self.least < value if self.above else self.least <= value
        return inside and value <= self.most and (not self.whole or value == int(value))

    def holds_all(self, values: list[Any]) -> bool:
        """Return whether all values are allowed. Of finite floats only the extremes are checked,
        which takes a tenth of the time.
        """
        floats = set(map(type, values)) == {float} and not self.whole
        if floats and math.isfinite(sum(values)):  # so there is no NaN, which min and max may skip
            return self.holds(min(values)) and self.holds(max(values))
        return all(map(self.holds, values))

    def schema(self, _kinds: dict[str, Schema]) -> Schema:
        kind = "integer" if self.whole else "number"
        found: Schema = {"type": [kind, "null"] if self.null else kind}
        if self.least > -LARGEST:
            found["exclusiveMinimum" if self.above else "minimum"] = self.least
        return found | ({"maximum": self.most} if self.most < LARGEST else {})


@dataclass(frozen=True, repr=False)
class Text(_Scalar):
    """A text.

    words : the allowed ones; empty allows every text
    null : whether null is allowed
    pattern : regular expression that the whole text must match, "" for none
    allowed : description of the pattern for messages
    as_written : whether a number counts as the text that it was written as (a sensor's model may be
        a number)
    """

    words: tuple[str, ...] = ()
    null: bool = False
    pattern: str = ""
    allowed: str = ""
    as_written: bool = False

    def __str__(self) -> str:
        kind = self.allowed or ", ".join(filter(None, self.words)) or "text"
        if not self.allowed and len(self.words) > 1 and not self.as_written:
            kind = f"one of {kind}"
        return f"{kind} or null" if self.null else kind

    def holds(self, value: object) -> bool:
        if value is None:
            return self.null
        if not isinstance(value, str) or (self.words and value not in self.words):
            return False
        return not self.pattern or re.fullmatch(self.pattern, value, re.ASCII) is not None

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        value = bare(node)
        if self.as_written and isinstance(value, int | float) and not isinstance(value, bool):
            value = node.text if isinstance(node, Node) else str(node)
        if self.holds(value):
            return value
        if not isinstance(value, str):
            raise notes.refuse(node, path, self)
        hint = notes.near(value, self.words)
        raise notes.reject(where_of(node), path, quote(value), str(self), hint)

    def schema(self, _kinds: dict[str, Schema]) -> Schema:
        if self.words:
            words = [*self.words, *([None] if self.null else [])]
            return {"enum": words} if len(words) > 1 else {"const": words[0]}
        kinds = ["string"]
        kinds += ["number"] if self.as_written else []
        kinds += ["null"] if self.null else []
        found: Schema = {"type": kinds if len(kinds) > 1 else "string"}
        return found | ({"pattern": f"^{self.pattern}$"} if self.pattern else {})


@dataclass(frozen=True, repr=False)
class YesNo(_Scalar):
    """True or false."""

    def __str__(self) -> str:
        return "true or false"

    def holds(self, value: object) -> bool:
        return isinstance(value, bool)

    def schema(self, _kinds: dict[str, Schema]) -> Schema:
        return {"type": "boolean"}


@dataclass(frozen=True, repr=False)
class Null(_Scalar):
    """Null."""

    def __str__(self) -> str:
        return "null"

    def holds(self, value: object) -> bool:
        return value is None

    def schema(self, _kinds: dict[str, Schema]) -> Schema:
        return {"type": "null"}
