"""JSON Schema of a protocol. What hangs on several fields at once (levels in the grid, fits of bed
and axis) or on the size of a text's number beyond its sign is left to `rig check`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from daq.documents.json_schema import document_schema
from rig.protocol.load import protocol_shape
from rig.protocol.spec import SCHEMA
from rig.protocol.vary import Axes


def protocol_schema() -> dict[str, Any]:
    """The schema of a protocol file."""
    return document_schema(
        protocol_shape(Path(), Axes()), f"Protocol of the particle-damper rig, {SCHEMA}"
    )
