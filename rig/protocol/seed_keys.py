"""Hash the content of a condition to the key that seeds its random streams.

The content is written under the names of the project's first edition, which are frozen below: a
renamed field changes the right side of its line only, so that every seed still gives the same bed.
A new field is added to `LATER`.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from operator import attrgetter
from typing import Any

from rig.catalog.entries import Material
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
    "cavity.material": ("cavity.material", None),
    "cavity.density": ("cavity.density", None),
}
"""The same for fields added after the first seeds, with the value that describes the behaviour
before the field existed. A field with that value is left out of the hash, so that a new field
reseeds no old protocol.
"""

BEDS: Mapping[str, str] = {"single_mass": "slug"}
"""Bed today -> its name in the first edition, where that was another."""

NO_CONTENT = ("losses", "support")
"""Fields of `Scene` that are not hashed: the same bed is measured with other losses."""


def seed_key(scene: Scene, drive: Drive) -> str:
    """Return the SHA-256, in hexadecimal, of the content that seeds a condition's random streams.

    Losses, support, acquisition, and of the drive all but level and frequency are left out, so that
    the same bed is measured with other drives and instruments.
    """
    content = {name: _as_float(attrgetter(path)(scene)) for name, path in SCENE.items()}
    content["bed"] = BEDS.get(scene.bed, scene.bed)
    for name, (path, before) in LATER.items():
        value = attrgetter(path)(scene)
        if value != before:
            content[name] = _as_float(value)
    frequency, acceleration = _as_float(drive.frequency), _as_float(drive.acceleration)
    # "servo" for every drive: it was the only mode when the first seeds were made.
    level = {"mode": "servo", "frequency": frequency, "acceleration": acceleration}
    text = json.dumps(
        {"scene": _nested(content), "drive": level}, sort_keys=True, separators=(",", ":")
    )
    return hashlib.sha256(text.encode()).hexdigest()


def _as_float(value: Any) -> Any:
    """Return a number as a float, so that 1 and 1.0 give one seed; a material's name, so that its
    elastic constants change no bed; anything else as it is.
    """
    if isinstance(value, Material):
        return value.name
    if isinstance(value, bool) or not isinstance(value, int | float):
        return value
    return float(value) + 0.0  # -0.0 + 0.0 is 0.0: one seed for both zeros


def _nested(content: Mapping[str, Any]) -> dict[str, Any]:
    """Return values under dotted names as nested mappings: {"a.b": 1} as {"a": {"b": 1}}."""
    groups: dict[str, Any] = {}
    for name, value in content.items():
        group, _, field = name.rpartition(".")
        (groups.setdefault(group, {}) if group else groups)[field] = value
    return groups
