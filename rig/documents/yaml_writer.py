"""Plain data to YAML text that the reader takes back unchanged: the same data give the same bytes."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from rig.documents.yaml_reader import scalar

WIDTH = 110
_PLAIN = re.compile(r"[A-Za-z0-9.](?:[A-Za-z0-9 ./^%+*_-]*[A-Za-z0-9./^%+*_-])?", re.ASCII)


def write_yaml(data: Mapping[str, Any]) -> str:
    """Block mappings outside; a mapping or list whose parts are scalars or that fits one line is
    written in flow.
    """
    return "".join(f"{line}\n" for line in _block(data, 0))


def write_text(text: str) -> str:
    """A scalar text, plain where every reader takes it as that text, else in double quotes."""
    if _PLAIN.fullmatch(text) and scalar(text) == text:
        return text
    safe = (c if c.isprintable() and c not in '"\\' else f"\\U{ord(c):08X}" for c in text)
    return f'"{"".join(safe)}"'


def _block(data: Mapping[str, Any], depth: int) -> list[str]:
    lines = []
    for key, value in data.items():
        head = f"{'  ' * depth}{write_text(key)}:"
        flow = _flow(value)
        nested = (
            isinstance(value, Mapping)
            and value
            and any(isinstance(part, Mapping) for part in value.values())
        )
        if nested or (isinstance(value, Mapping) and len(head) + len(flow) > WIDTH):
            lines += [head, *_block(value, depth + 1)]
        else:
            lines.append(f"{head} {flow}")
    return lines


def _flow(value: Any) -> str:
    if isinstance(value, Mapping):
        return (
            f"{{{', '.join(f'{write_text(key)}: {_flow(part)}' for key, part in value.items())}}}"
        )
    if isinstance(value, str):
        return write_text(value)
    if isinstance(value, Sequence):
        return f"[{', '.join(_flow(part) for part in value)}]"
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value)
