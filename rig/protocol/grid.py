"""From a protocol to its conditions: the grid, every value resolved, and what only values together
can get wrong.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from daq.documents.grammar import keys_of
from daq.documents.notes import Notes, Unreadable, node_of
from daq.documents.shapes import Shape, plain
from rig.errors import InputError, Mistake, in_order
from rig.protocol.claims import expect_shape, plain_expect
from rig.protocol.fault_list import faults_shape, plain_faults
from rig.protocol.feasibility import conflicts, misfits, unfit
from rig.protocol.seed_keys import seed_key
from rig.protocol.spec import Acquire, Condition, Drive, Protocol, Scene
from rig.protocol.vary import Axes, axes_shape, plain_axes

if TYPE_CHECKING:
    from rig.catalog.entries import Material

MAX_RUNS = 100000
CHECKED = (
    "scene",
    "drive",
    "acquire",
    "repeats",
    "seed",
    "deliberate_error",
    "fidelity",
    "tolerance",
)

Row = Mapping[str, int]
"""Path -> the row of its axis that a condition takes."""


@dataclass(frozen=True)
class Point:
    """One point of the grid: its row on each axis and the three parts of the experiment there."""

    rows: Row
    scene: Scene
    drive: Drive
    acquire: Acquire


def conditions(protocol: Protocol) -> tuple[Condition, ...]:
    """Return every condition of the grid, resolved. Raises InputError with every value out of
    range, or all that does not fit."""
    verify(protocol)
    return expand(protocol)


def verify(protocol: Protocol) -> None:
    """Check a protocol that was built in Python: InputError for every value that a file could not
    hold.
    """
    whole = keys_of(Protocol).every()
    written: dict[str, tuple[Shape, Any]] = {
        name: (whole[name], plain(whole[name], getattr(protocol, name))) for name in CHECKED
    }
    written["vary"] = axes_shape(Axes()), plain_axes(protocol.vary)
    written["expect"] = expect_shape(), [plain_expect(claim) for claim in protocol.expect]
    written["faults"] = faults_shape(), plain_faults(protocol.faults)
    notes = Notes()
    for name, (shape, value) in written.items():
        with suppress(Unreadable):
            shape.read(node_of(value), name, notes)
    if notes.mistakes:
        raise InputError(*notes.mistakes)


def expand(
    protocol: Protocol,
    place: Callable[[str, Row], str] = lambda _path, _rows: "",
    failed: frozenset[str] = frozenset(),
) -> tuple[Condition, ...]:
    """Every condition of the grid, the last axis fastest, densities resolved.

    `place` says where the value of a path was written; a check that involves a `failed` path is
    left out, because that path's value is not the user's. Raises InputError with every mistake.
    """
    runs = math.prod(len(axis.rows) for axis in protocol.vary) * protocol.repeats.n
    if runs > MAX_RUNS:
        raise InputError(Mistake(place("vary", {}), "vary", f"{runs} runs", f"at most {MAX_RUNS}"))
    mistakes: dict[Mistake, None] = {}
    for conflict in unfit(protocol):
        if not failed.intersection(conflict.paths):
            path = conflict.paths[0]
            rows = {path: 0} if any(path in axis.paths for axis in protocol.vary) else {}
            mistakes[
                Mistake(place(path, rows), path, conflict.found, conflict.allowed, conflict.hint)
            ] = None
    seen: dict[tuple[Scene, Drive, Acquire], Point] = {}
    points = []
    materials: dict[str, Material | None] = {}
    for point in _points(protocol):
        found = conflicts(point.scene, point.drive, point.acquire)
        for conflict in (
            *found,
            *misfits(protocol.deliberate_error, point.scene, point.drive, point.acquire),
        ):
            if not failed.intersection(conflict.paths):
                where = place(conflict.paths[0], point.rows)
                mistakes[
                    Mistake(
                        where, conflict.paths[0], conflict.found, conflict.allowed, conflict.hint
                    )
                ] = None
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
        Condition(
            f"c{n:0{digits}d}",
            point.scene,
            point.drive,
            point.acquire,
            seed_key(point.scene, point.drive),
        )
        for n, point in enumerate(points, 1)
    )


def _points(protocol: Protocol) -> Iterator[Point]:
    for chosen in itertools.product(*(range(len(axis.rows)) for axis in protocol.vary)):
        parts: dict[str, Any] = {
            "scene": protocol.scene,
            "drive": protocol.drive,
            "acquire": protocol.acquire,
        }
        rows = {}
        for axis, row in zip(protocol.vary, chosen, strict=True):
            for path, value in zip(axis.paths, axis.rows[row], strict=True):
                part, _, rest = path.partition(".")
                parts[part] = _with(parts[part], rest, value)
                rows[path] = row
        yield Point(rows, **parts)


def _with(part: Any, path: str, value: Any) -> Any:
    """A frozen dataclass with the value at a dotted path replaced; the whole of it for an empty
    path.
    """
    if not path:
        return value
    name, _, rest = path.partition(".")
    return replace(part, **{name: _with(getattr(part, name), rest, value)})


def _with_density(scene: Scene, known: dict[str, Material | None]) -> Scene:
    if scene.grains.density is not None:
        return scene
    name = scene.grains.material
    if name not in known:
        from rig.catalog.entries_by_name import material, names

        known[name] = material(name) if name in names("material") else None
    found = known[name]
    return (
        scene
        if found is None
        else replace(scene, grains=replace(scene.grains, density=found.density))
    )


def _repeated(
    point: Point, first: Point, protocol: Protocol, place: Callable[[str, Row], str]
) -> Mistake:
    """The mistake of two equal conditions, placed at a value in which the second differs from the
    first.
    """
    for axis in protocol.vary:
        path = axis.paths[0]
        if point.rows[path] != first.rows[path]:
            where = place(path, point.rows)
            return Mistake(
                where, path, "a condition that stands in the grid already", "every condition once"
            )
    return Mistake("", "vary", "a condition twice", "every condition once")
