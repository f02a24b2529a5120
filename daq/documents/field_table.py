"""Write the fields of a document as a Markdown table, from the shapes that read it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import MISSING
from typing import Any

from daq.documents.shapes import Keys, List, Shape, Then

__all__ = ["field_table"]


def field_table(shape: Shape) -> str:
    """Return the table, a row for every field: its path, the allowed values, its default."""
    rows = ["| field | allowed | default |", "|---|---|---|"]
    for path, part, default in _fields(shape, ""):
        written = "" if default is MISSING else f"`{json.dumps(default, ensure_ascii=False)}`"
        allowed = str(part).replace("|", r"\|")
        rows.append(f"| `{path}` | {allowed} | {written} |")
    return "\n".join(rows) + "\n"


def _fields(shape: Shape, path: str) -> Iterator[tuple[str, Shape, Any]]:
    """Yield path, shape and default of every field; a group, or a list of groups, is replaced by
    its fields.
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
