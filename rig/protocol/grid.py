"""The conditions of a protocol: every point of its grid, resolved and checked for fields that do
not fit together.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from daq.documents.classes import keys_of
from daq.documents.notes import Notes, Unreadable, node_of
from daq.documents.shapes import Shape, plain
from rig.errors import InputError, Mistake, in_order, quote
from rig.protocol.claims import expect_shape, plain_expect
from rig.protocol.fault_list import faults_shape, plain_faults
from rig.protocol.feasibility import Conflict, conflicts, misfits, unfit
from rig.protocol.seed_keys import seed_key
from rig.protocol.spec import (
    BEDS_OF_GRAINS,
    LOCKING_LEVEL,
    RIGID_BEDS,
    Acquire,
    Condition,
    Drive,
    Protocol,
    Scene,
)
from rig.protocol.vary import Axes, axes_shape, plain_axes
from rig.units import GRAVITY

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
    "prediction",
)

Row = Mapping[str, int]
"""Path -> index of its value on its axis, at one point of the grid."""


@dataclass(frozen=True)
class Point:
    """One point of the grid: the index of each path's value, and the three parts of the experiment
    with these values.
    """

    rows: Row
    scene: Scene
    drive: Drive
    acquire: Acquire


def conditions(protocol: Protocol) -> tuple[Condition, ...]:
    """Return every condition of the grid, resolved.

    Raises InputError with every value out of range or, where there is none, with every combination
    of values that cannot be run.
    """
    verify(protocol)
    return expand(protocol)


def verify(protocol: Protocol) -> None:
    """Check a protocol that was built in Python.

    Each part is written as plain data and read by the shape that reads a file. Raises InputError
    with every value that a file could not hold.
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
    """Return every condition of the grid, the last axis fastest, densities resolved.

    Raises InputError with every mistake.

    place : returns where the value of a path was written
    failed : paths whose value could not be read. They hold defaults, not the user's values, so that
        checks that involve them are left out.
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
    named: dict[str, str | Material] = {}
    for point in _points(protocol):
        found = conflicts(point.scene, point.drive, point.acquire)
        for conflict in (
            *found,
            *misfits(protocol.deliberate_error, point.scene, point.drive, point.acquire),
            *_unpredicted(protocol.prediction, point.scene, point.drive),
        ):
            if not failed.intersection(conflict.paths):
                where = place(conflict.paths[0], point.rows)
                mistakes[
                    Mistake(
                        where, conflict.paths[0], conflict.found, conflict.allowed, conflict.hint
                    )
                ] = None
        for path, name in _namesakes(point.scene, named):
            said = f"another material named {quote(name)}"
            where = place(path, point.rows)
            mistakes[Mistake(where, path, said, "one material for each name")] = None
        point = replace(point, scene=_with_densities(point.scene, materials))
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
            protocol.prediction,
        )
        for n, point in enumerate(points, 1)
    )


def _points(protocol: Protocol) -> Iterator[Point]:
    """Yield every point of the grid, the last axis fastest."""
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
    """Return a frozen dataclass with the value at a dotted path replaced; an empty path replaces
    the whole.
    """
    if not path:
        return value
    name, _, rest = path.partition(".")
    return replace(part, **{name: _with(getattr(part, name), rest, value)})


def _with_densities(scene: Scene, known: dict[str, Material | None]) -> Scene:
    """Return the scene with the densities of its materials where it states none.

    A box whose material is the rig's has none. `known` keeps the materials looked up so far; an
    unknown one is None and leaves the scene as it is, because its name is reported elsewhere.
    """
    changed: dict[str, Any] = {}
    for name in ("grains", "cavity"):
        part = getattr(scene, name)
        found = _looked_up(part.material, known) if part.density is None else None
        if found is not None:
            changed[name] = replace(part, density=found.density)
    return replace(scene, **changed) if changed else scene


def _namesakes(scene: Scene, named: dict[str, str | Material]) -> Iterator[tuple[str, str]]:
    """Yield path and name of each material whose name another one has already; `named` keeps the
    materials seen so far.
    """
    for path, found in (
        ("scene.grains.material", scene.grains.material),
        ("scene.cavity.material", scene.cavity.material),
    ):
        if found is not None and named.setdefault(str(found), found) != found:
            yield path, str(found)


def _looked_up(named: str | Material | None, known: dict[str, Material | None]) -> Material | None:
    """Return a scene's material, None for one that is not in the catalog."""
    if not isinstance(named, str):
        return named
    if named not in known:
        from rig.catalog.entries_by_name import material, names

        known[named] = material(named) if named in names("material") else None
    return known[named]


def _repeated(
    point: Point, first: Point, protocol: Protocol, place: Callable[[str, Row], str]
) -> Mistake:
    """Return the mistake of two equal conditions.

    Its place is that of the first value with another index on its axis: one content may be written
    in two ways, such as 1 and 100 %.
    """
    for axis in protocol.vary:
        path = axis.paths[0]
        if point.rows[path] != first.rows[path]:
            where = place(path, point.rows)
            return Mistake(
                where, path, "a condition that stands in the grid already", "every condition once"
            )
    return Mistake("", "vary", "a condition twice", "every condition once")


def _unpredicted(prediction: str | None, scene: Scene, drive: Drive) -> Iterator[Conflict]:
    """Yield why a named prediction can never be stated for a condition; beds that cannot slide keep
    their own.
    """
    bed, axis = scene.bed, scene.axis
    if prediction is None or bed in RIGID_BEDS:
        return
    found = f"prediction {prediction} for bed {bed}"
    if bed not in BEDS_OF_GRAINS and prediction != "own":
        yield Conflict(("prediction", "scene.bed"), found, "own for this bed")
    elif prediction in ("layers", "column", "as_printed") and axis != "horizontal":
        allowed = "own or band on this axis"
        yield Conflict(("prediction", "scene.axis"), f"{found} on axis {axis}", allowed)
    elif prediction == "own" and bed == "grains":
        lands = axis == "vertical" and drive.acceleration <= LOCKING_LEVEL * GRAVITY
        if not lands:
            found += f" on axis {axis} at {drive.acceleration / GRAVITY:.3g} g"
            allowed = f"layers, column or as_printed on a horizontal axis, band elsewhere; own up to {LOCKING_LEVEL:g} g vertically"
            yield Conflict(("prediction", "scene.bed", "scene.axis"), found, allowed)
