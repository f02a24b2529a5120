"""From a protocol to its conditions: the grid, every value resolved, and what only values together can get wrong."""

from __future__ import annotations

import hashlib
import itertools
import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

from rig.errors import InputError, Mistake, in_order
from rig.feasible import conflicts, misfits, unfit
from rig.scene import Acquire, Condition, Drive, Protocol, Scene

if TYPE_CHECKING:
    from rig.catalog import Material

MAX_RUNS = 100000

Row = Mapping[str, int]
"""Path -> the row of its axis that a condition takes."""


@dataclass(frozen=True)
class Point:
    """One point of the grid: its row on each axis and the three parts of the experiment there."""

    rows: Row
    scene: Scene
    drive: Drive
    acquire: Acquire


def expand(
    protocol: Protocol, place: Callable[[str, Row], str] = lambda _path, _rows: "", failed: frozenset[str] = frozenset()
) -> tuple[Condition, ...]:
    """Every condition of the grid, the last axis fastest, densities resolved.

    `place` says where the value of a path was written; a check that involves a `failed` path is left out, because that
    path's value is not the user's. Raises InputError with every mistake.
    """
    runs = math.prod(len(axis.rows) for axis in protocol.vary) * protocol.repeats.n
    if runs > MAX_RUNS:
        raise InputError(Mistake(place("vary", {}), "vary", f"{runs} runs", f"at most {MAX_RUNS}"))
    mistakes: dict[Mistake, None] = {}
    for conflict in unfit(protocol):
        if not failed.intersection(conflict.paths):
            path = conflict.paths[0]
            rows = {path: 0} if any(path in axis.paths for axis in protocol.vary) else {}
            mistakes[Mistake(place(path, rows), path, conflict.found, conflict.allowed, conflict.hint)] = None
    seen: dict[tuple[Scene, Drive, Acquire], Point] = {}
    points = []
    materials: dict[str, Material | None] = {}
    for point in _points(protocol):
        found = conflicts(point.scene, point.drive, point.acquire)
        for conflict in (*found, *misfits(protocol.mistake, point.scene, point.drive, point.acquire)):
            if not failed.intersection(conflict.paths):
                where = place(conflict.paths[0], point.rows)
                mistakes[Mistake(where, conflict.paths[0], conflict.found, conflict.allowed, conflict.hint)] = None
        point = replace(point, scene=_with_density(point.scene, materials))
        content = (point.scene, point.drive, point.acquire)
        if content in seen and not failed:
            mistakes[_repeated(point, seen[content], protocol, place)] = None
        seen.setdefault(content, point)
        points.append(point)
    if mistakes:
        raise InputError(*in_order(mistakes))
    digits = max(2, len(str(len(points))))
    return tuple(
        Condition(f"c{n:0{digits}d}", point.scene, point.drive, point.acquire, seed_key(point.scene, point.drive))
        for n, point in enumerate(points, 1)
    )


ADDED = (("slug", "start", 0.0), ("slug", "velocity", 0.0))
"""Fields of the scene younger than the first seeds, with the value that stands for what was before: it is no content,
so that a new field reseeds no old protocol."""


def seed_key(scene: Scene, drive: Drive) -> str:
    """SHA-256 of the content that seeds a condition's streams, hex: losses, support, all of the drive but its level
    and frequency, and the acquisition are left out, so that the same bed is seen through other drives and instruments.
    """
    level = {"mode": "servo", "frequency": drive.frequency, "acceleration": drive.acceleration}
    content = {"scene": asdict(scene), "drive": level}
    for name in ("losses", "support"):
        del content["scene"][name]
    for group, name, before in ADDED:
        if content["scene"][group][name] == before:
            del content["scene"][group][name]
    text = json.dumps(_as_floats(content), sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(text.encode()).hexdigest()


def _points(protocol: Protocol) -> Iterator[Point]:
    for chosen in itertools.product(*(range(len(axis.rows)) for axis in protocol.vary)):
        parts: dict[str, Any] = {"scene": protocol.scene, "drive": protocol.drive, "acquire": protocol.acquire}
        rows = {}
        for axis, row in zip(protocol.vary, chosen, strict=True):
            for path, value in zip(axis.paths, axis.rows[row], strict=True):
                part, _, rest = path.partition(".")
                parts[part] = _with(parts[part], rest, value)
                rows[path] = row
        yield Point(rows, **parts)


def _with(part: Any, path: str, value: Any) -> Any:
    """A frozen dataclass with the value at a dotted path replaced; the whole of it for an empty path."""
    if not path:
        return value
    name, _, rest = path.partition(".")
    return replace(part, **{name: _with(getattr(part, name), rest, value)})


def _with_density(scene: Scene, known: dict[str, Material | None]) -> Scene:
    if scene.grains.density is not None:
        return scene
    name = scene.grains.material
    if name not in known:
        from rig.catalog import material, names

        known[name] = material(name) if name in names("material") else None
    found = known[name]
    return scene if found is None else replace(scene, grains=replace(scene.grains, density=found.density))


def _repeated(point: Point, first: Point, protocol: Protocol, place: Callable[[str, Row], str]) -> Mistake:
    """The mistake of two equal conditions, placed at a value in which the second differs from the first."""
    for axis in protocol.vary:
        path = axis.paths[0]
        if point.rows[path] != first.rows[path]:
            where = place(path, point.rows)
            return Mistake(where, path, "a condition that stands in the grid already", "every condition once")
    return Mistake("", "vary", "a condition twice", "every condition once")


def _as_floats(value: Any) -> Any:
    """Plain data with every number a float, so that 1 and 1.0 seed alike."""
    if isinstance(value, dict):
        return {key: _as_floats(part) for key, part in value.items()}
    if isinstance(value, tuple | list):
        return [_as_floats(part) for part in value]
    return float(value) + 0.0 if isinstance(value, int | float) and not isinstance(value, bool) else value
