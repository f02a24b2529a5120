"""Shapes of one value, and what a shape is: it reads a value strictly, and says itself as JSON Schema.

Every number is finite and below LARGEST in size, so that no arithmetic on a checked value can overflow.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

from daq.documents.notes import Node, Notes, bare, describe, nearest, quote, where_of

__all__ = ["LARGEST", "Anything", "Null", "Number", "Schema", "Shape", "Text", "YesNo"]

LARGEST = 1e15

Schema = dict[str, Any]


@runtime_checkable
class Shape(Protocol):
    """What a value must look like; str() says it in words."""

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        """The value of a node, or of plain data. Raises Unreadable after noting why it has none."""

    def schema(self, kinds: dict[str, Schema]) -> Schema:
        """The shape as JSON Schema (draft 2020-12); classes that it refers to are added to `kinds`."""


class _Scalar:
    """What shapes of one value have in common."""

    def holds(self, value: object) -> bool:
        """Whether a value is as it should be."""
        raise NotImplementedError

    def read(self, node: Any, path: str, notes: Notes) -> Any:
        """The value itself."""
        value = bare(node)
        if not self.holds(value):
            raise notes.refuse(node, path, self)
        return value


@dataclass(frozen=True, repr=False)
class Anything(_Scalar):
    """Any value, which is left as it is: a node stays one. `says` is what JSON Schema knows of it."""

    says: Mapping[str, Any] = field(default_factory=dict)

    def read(self, node: Any, _path: str, _notes: Notes) -> Any:
        """The node."""
        return node

    def schema(self, _kinds: dict[str, Schema]) -> Schema:
        return dict(self.says)


@dataclass(frozen=True, repr=False)
class Number(_Scalar):
    """A number from `least` to `most`, above `least` where `above`; whole, or null, where it says so."""

    least: float = -LARGEST
    most: float = LARGEST
    above: bool = False
    whole: bool = False
    null: bool = False

    def __str__(self) -> str:
        kind = "a whole number" if self.whole else "a number"
        low = f" above {self.least:g}" if self.above else f" from {self.least:g}" if self.least > -LARGEST else ""
        high = f" to {self.most:g}" if self.most < LARGEST else ""
        return f"{kind}{low}{high}{' or null' if self.null else ''}"

    def holds(self, value: object) -> bool:
        if value is None:
            return self.null
        if isinstance(value, bool) or not isinstance(value, int | float):
            return False
        if isinstance(value, float) and not math.isfinite(value):  # a whole number may be beyond every float
            return False
        inside = self.least < value if self.above else self.least <= value
        return inside and value <= self.most and (not self.whole or value == int(value))

    def holds_all(self, values: list[Any]) -> bool:
        """Whether all values are such numbers; of floats their extremes tell it, in a tenth of the time."""
        if set(map(type, values)) == {float} and not self.whole and math.isfinite(sum(values)):  # no NaN among them
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
    """Text, one of `words` unless that is empty, or all of it as the regular expression `pattern`; null where it says
    so. `allowed`: the same in words. as_written: a number counts as the text that it was written as (names of models
    may be numbers)."""

    words: tuple[str, ...] = ()
    null: bool = False
    pattern: str = ""
    allowed: str = ""
    as_written: bool = False

    def __str__(self) -> str:
        several = "one of " if len(self.words) > 1 and not self.as_written else ""
        kind = self.allowed or (f"{several}{', '.join(filter(None, self.words))}" if self.words else "text")
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
        if not self.holds(value):
            word = isinstance(value, str)
            found = quote(value) if word else describe(node)
            raise notes.reject(where_of(node), path, found, str(self), nearest(value, self.words) if word else "")
        return value

    def schema(self, _kinds: dict[str, Schema]) -> Schema:
        if self.words:
            words = [*self.words, *([None] if self.null else [])]
            return {"enum": words} if len(words) > 1 else {"const": words[0]}
        kinds = ["string", *(["number"] if self.as_written else []), *(["null"] if self.null else [])]
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
