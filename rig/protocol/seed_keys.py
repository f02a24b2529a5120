"""What seeds a condition's random streams: a hash of its content, under the names of the project's
first edition.

The names below are frozen. A field that is renamed changes the right side of its line and no more,
so that every bed stays the same bed; a new field joins `LATER`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from operator import attrgetter
from typing import Any

from rig.protocol.spec import Drive, Scene

SCENE: Mapping[str, str] = {
    "axis": "axis",
    "bed": "bed",
    "cavity.height": "cavity.height",
    "cavity.length": "cavity.length",
    "cavity.wall": "cavity.wall",
    "cavity.width": "cavity.width",
    "dashpot.c": "dashpot.c",
    "grains.density": "grains.density",
    "grains.diameter": "grains.diameter",
    "grains.fill": "grains.fill",
    "grains.material": "grains.material",
    "layers.play": "layers.clearance",
    "layers.rows": "layers.rows",
    "layers.side_walls": "layers.side_walls",
    "layers.spread": "layers.spread",
    "slug.friction": "single_mass.friction",
    "slug.gap": "single_mass.gap",
    "slug.restitution": "single_mass.restitution",
}
"""Name in the first edition -> path of the field in `Scene` today."""

LATER: Mapping[str, tuple[str, Any]] = {
    "slug.start": ("single_mass.start", 0.0),
    "slug.velocity": ("single_mass.velocity", 0.0),
}
"""The same for fields younger than the first seeds, with the value that stands for what was before:
it is no content, so that a new field reseeds no old protocol."""

BEDS: Mapping[str, str] = {"single_mass": "slug"}
"""Bed today -> its name in the first edition, where that was another."""

NO_CONTENT = ("losses", "support")
"""Fields of `Scene` that seed nothing: the same bed is seen with other losses."""


def seed_key(scene: Scene, drive: Drive) -> str:
    """Return the SHA-256, hex, of the content that seeds a condition's streams.

    Left out are losses, support, all of the drive but its level and frequency, and the acquisition,
    so that the same bed is seen through other drives and instruments.
    """
    content = {name: _as_float(attrgetter(path)(scene)) for name, path in SCENE.items()}
    content["bed"] = BEDS.get(scene.bed, scene.bed)
    for name, (path, before) in LATER.items():
        value = attrgetter(path)(scene)
        if value != before:
            content[name] = _as_float(value)
    frequency, acceleration = _as_float(drive.frequency), _as_float(drive.acceleration)
    level = {"mode": "servo", "frequency": frequency, "acceleration": acceleration}
    text = json.dumps(
        {"scene": _nested(content), "drive": level}, sort_keys=True, separators=(",", ":")
    )
    return hashlib.sha256(text.encode()).hexdigest()


def _as_float(value: Any) -> Any:
    """A number as a float, so that 1 and 1.0 seed alike; anything else as it is."""
    return (
        float(value) + 0.0
        if isinstance(value, int | float) and not isinstance(value, bool)
        else value
    )


def _nested(content: Mapping[str, Any]) -> dict[str, Any]:
    """Values under dotted names as groups within groups."""
    groups: dict[str, Any] = {}
    for name, value in content.items():
        group, _, field = name.rpartition(".")
        (groups.setdefault(group, {}) if group else groups)[field] = value
    return groups
