"""The fields of a document as a table in Markdown, from the shapes that read it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import MISSING
from typing import Any

from daq.documents.shapes import Keys, List, Shape, Then

__all__ = ["field_table"]


def field_table(shape: Shape) -> str:
    """A row for every field: its path, what is allowed, its default."""
    rows = ["| field | allowed | default |", "|---|---|---|"]
    for path, part, default in _fields(shape, ""):
        told = "" if default is MISSING else f"`{json.dumps(default, ensure_ascii=False)}`"
        rows.append(f"| `{path}` | {str(part).replace('|', chr(92) + '|')} | {told} |")
    return "\n".join(rows) + "\n"


def _fields(shape: Shape, path: str) -> Iterator[tuple[str, Shape, Any]]:
    """Path, shape and default of every field; those of a group or of a list's items come in its
    place.
    """
    inner = shape
    while isinstance(inner, Then | List):
        path += "[]" if isinstance(inner, List) else ""
        inner = inner.shape if isinstance(inner, Then) else inner.item
    if not isinstance(inner, Keys) or inner.names:
        return
    for name, part in inner.every().items():
        full = f"{path}.{name}" if path else name
        below = list(_fields(part, full))
        yield from below or [(full, part, inner.default_of(name))]
