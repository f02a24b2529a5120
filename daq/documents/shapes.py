"""What a JSON value must look like: shapes, and the deviations of a value from one. Foreign documents are checked here.

Every number is finite and below LARGEST in size, so that no arithmetic on a checked value can overflow.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

__all__ = [
    "LARGEST",
    "Choice",
    "Each",
    "Either",
    "Keys",
    "List",
    "Null",
    "Number",
    "Shape",
    "Text",
    "YesNo",
    "deviations",
]

LARGEST = 1e15
LONGEST_QUOTE = 40


@dataclass(frozen=True)
class Number:
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
        """Whether a value is such a number."""
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


@dataclass(frozen=True)
class Text:
    """Text, one of `words` unless that is empty; null where it says so."""

    words: tuple[str, ...] = ()
    null: bool = False

    def __str__(self) -> str:
        kind = f"one of {', '.join(self.words)}" if self.words else "text"
        return f"{kind} or null" if self.null else kind

    def holds(self, value: object) -> bool:
        """Whether a value is such a text."""
        if value is None:
            return self.null
        return isinstance(value, str) and (not self.words or value in self.words)


@dataclass(frozen=True)
class YesNo:
    """True or false."""

    def __str__(self) -> str:
        return "true or false"

    def holds(self, value: object) -> bool:
        """Whether a value is one of them."""
        return isinstance(value, bool)


@dataclass(frozen=True)
class List:
    """A list of at least `least` and at most `most` values of one shape."""

    item: "Shape"
    least: int = 0
    most: float = math.inf


@dataclass(frozen=True)
class Each:
    """A mapping with keys of any name and values of one shape."""

    item: "Shape"


@dataclass(frozen=True)
class Keys:
    """A mapping with these keys, and those in `optional` where it has them; null where it says so. Keys that the shape
    does not name are free. `as_long`: keys of lists that must have as many entries as the first of them.
    """

    required: Mapping[str, "Shape"]
    optional: Mapping[str, "Shape"] = field(default_factory=dict)
    as_long: tuple[str, ...] = ()
    null: bool = False


@dataclass(frozen=True)
class Null:
    """Null."""

    def __str__(self) -> str:
        return "null"

    def holds(self, value: object) -> bool:
        """Whether a value is null."""
        return value is None


@dataclass(frozen=True)
class Choice:
    """A mapping whose shape hangs on the word under `key`."""

    key: str
    shapes: Mapping[str, "Keys"]


@dataclass(frozen=True)
class Either:
    """A value of one shape or of another."""

    first: "Shape"
    second: "Shape"


Shape = Choice | Either | Null | Number | Text | YesNo | List | Each | Keys


def deviations(value: Any, shape: Shape, path: str = "") -> Iterator[str]:
    """One sentence for every place where a value is not as its shape wants it; none for a value that fits."""
    match shape:
        case Null() | Number() | Text() | YesNo():
            if not shape.holds(value):
                yield f"{path} is {_quoted(value)}, expected {shape}"
        case List():
            if not isinstance(value, list) or not shape.least <= len(value) <= shape.most:
                most = f" and at most {shape.most}" if shape.most < math.inf else ""
                yield f"{path} is {_quoted(value)}, expected a list of at least {shape.least}{most}"
                return
            if isinstance(shape.item, Number) and shape.item.holds_all(value):
                return
            for position, item in enumerate(value):
                yield from deviations(item, shape.item, f"{path}[{position}]")
        case Each():
            if not isinstance(value, dict):
                yield f"{path} is {_quoted(value)}, expected a mapping"
                return
            for key, item in value.items():
                yield from deviations(item, shape.item, f"{path}.{key}" if path else str(key))
        case Choice():
            word = value.get(shape.key) if isinstance(value, dict) else value
            if isinstance(word, str) and word in shape.shapes:
                yield from _keys(value, shape.shapes[word], path)
            else:
                yield f"{path}.{shape.key} is {_quoted(word)}, expected one of {', '.join(shape.shapes)}"
        case Either():
            found = list(deviations(value, shape.first, path))
            other = list(deviations(value, shape.second, path)) if found else []
            if other:
                yield (other if isinstance(shape.first, Null) else found)[0]
        case Keys():
            yield from _keys(value, shape, path)


def _keys(value: Any, shape: Keys, path: str) -> Iterator[str]:
    if value is None and shape.null:
        return
    if not isinstance(value, dict):
        yield f"{path} is {_quoted(value)}, expected a mapping"
        return
    dot = f"{path}." if path else ""
    for key, item in shape.required.items():
        if key in value:
            yield from deviations(value[key], item, f"{dot}{key}")
        else:
            yield f"{dot}{key} is missing"
    for key, item in shape.optional.items():
        if key in value:
            yield from deviations(value[key], item, f"{dot}{key}")
    lists = [value[key] for key in shape.as_long if isinstance(value.get(key), list)]
    if len({len(entries) for entries in lists}) > 1:
        yield f"{dot}{', '.join(shape.as_long)} are not equally long"


def _quoted(value: Any) -> str:
    kinds = {dict: "a mapping", list: "a list", type(None): "null"}
    if type(value) in kinds:
        return kinds[type(value)]
    text = ascii(value)
    return text if len(text) <= LONGEST_QUOTE else f"{text[:LONGEST_QUOTE]}..."
