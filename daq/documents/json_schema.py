"""JSON Schema (draft 2020-12) of documents, so that editors and other tools can check what our reader
checks.

A schema refuses nothing that the reader accepts. It cannot state that lists must be equally long
(`Keys.as_long`).
"""

from typing import Any

from daq.documents.shapes import Shape

__all__ = ["DRAFT", "document_schema", "json_schema"]

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def json_schema(shape: Shape) -> dict[str, Any]:
    """Return the schema of a shape, the classes in it under `$defs`."""
    kinds: dict[str, dict[str, Any]] = {}
    found: dict[str, Any] = getattr(shape, "body", shape.schema)(kinds)
    return found | ({"$defs": kinds} if kinds else {})


def document_schema(shape: Shape, title: str) -> dict[str, Any]:
    """Return the schema of a whole document."""
    return {"$schema": DRAFT, "title": title, **json_schema(shape)}
