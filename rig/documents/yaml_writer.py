"""Write plain data as YAML text that the reader reads back unchanged; equal data give equal bytes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from rig.documents.yaml_reader import scalar

WIDTH = 110
_PLAIN = re.compile(r"[A-Za-z0-9.](?:[A-Za-z0-9 ./^%+*_-]*[A-Za-z0-9./^%+*_-])?", re.ASCII)


def write_yaml(data: Mapping[str, Any]) -> str:
    """Return the YAML text of a mapping.

    A mapping that holds mappings, or is longer than a line, is written as a block; everything else
    in one line.
    """
    return "".join(f"{line}\n" for line in _block(data, 0))


def write_text(text: str) -> str:
    """Return a text as a scalar: plain if every reader reads it as that text, else in double
    quotes.
    """
    if _PLAIN.fullmatch(text) and scalar(text) == text:
        return text
    safe = (c if c.isprintable() and c not in '"\\' else f"\\U{ord(c):08X}" for c in text)
    return f'"{"".join(safe)}"'


def _block(data: Mapping[str, Any], depth: int) -> list[str]:
    """Return the lines of a mapping, indented by `depth` levels."""
    lines = []
    for key, value in data.items():
        head = f"{'  ' * depth}{write_text(key)}:"
        flow = _flow(value)
        mapping = isinstance(value, Mapping)
        nested = mapping and any(isinstance(part, Mapping) for part in value.values())
        if nested or (mapping and len(head) + len(flow) > WIDTH):
            lines += [head, *_block(value, depth + 1)]
        else:
            lines.append(f"{head} {flow}")
    return lines


def _flow(value: Any) -> str:
    """Return any value in one line."""
    if isinstance(value, Mapping):
        parts = [f"{write_text(key)}: {_flow(part)}" for key, part in value.items()]
        return f"{{{', '.join(parts)}}}"
    if isinstance(value, str):
        return write_text(value)
    if isinstance(value, Sequence):
        return f"[{', '.join(_flow(part) for part in value)}]"
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value)
