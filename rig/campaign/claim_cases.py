"""The conditions that decide each claim of a protocol: plain data, so that the analysis can judge
it without the protocol.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import is_dataclass
from functools import reduce
from typing import Any

from daq.documents.classes import shape_at
from rig.catalog.entries import Material
from rig.protocol.claims import LISTS
from rig.protocol.spec import Condition, Expect, Protocol
from rig.units import UNITS, Quantity

Pick = Callable[[Condition], Any]


def cases(protocol: Protocol, conditions: Sequence[Condition]) -> list[dict[str, Any]]:
    """Return the claims for the session file: words, kind, limits, and `cases` with the conditions
    of each.

    A case is {"at": {path: text}, "levels": [{"value": text, "conditions": [ids]}]}: one
    combination of the other varied fields. Levels are in the order of the claim; a level has
    several conditions if the claim is about a mean over them. A value that no condition has gives
    no level.
    """
    return [_claim(claim, protocol, conditions) for claim in protocol.expect]


TOLD = {"scene.bed", "scene.grains.material", "scene.grains.density", "scene.grains.diameter", "scene.grains.fill",
        "drive.mode", "drive.frequency", "drive.acceleration"}  # fmt: skip
"""Paths whose values are in the report's table of conditions anyway."""


WALL = {"scene.cavity.material": "wall_material", "scene.cavity.density": "wall_density"}
"""Paths whose last word is that of a field of the grains, with the name that the report gives them."""


def varied(protocol: Protocol, condition: Condition) -> dict[str, str]:
    """Return the condition's values of the other varied fields, readable, by the last word of the
    path, or by its name in `WALL`.
    """
    found = {}
    for axis in protocol.vary:
        for path in axis.paths:
            if path in TOLD or "." not in path:
                continue
            value = _at(condition, path)
            if not is_dataclass(value):
                found[WALL.get(path, path.rpartition(".")[2])] = _text(path, value)
    return found


def label(path: str, value: Any) -> str:
    """Return a field's value in readable form: "5 mm", "0.90", "stainless"."""
    quantity = shape_at(Protocol, path)
    if not isinstance(quantity, Quantity) or isinstance(value, str | bool) or value is None:
        return str(value)
    if quantity.dimension == "number":
        return (
            f"{value:.2f}"
            if isinstance(value, float) and round(value, 2) == value
            else f"{value:.6g}"
        )
    numbers = {
        unit: f"{value / float(scale):.6g}" for unit, scale in UNITS[quantity.dimension].items()
    }
    # Of all units the one that needs the fewest digits.
    shortest = min(numbers, key=lambda unit: len(numbers[unit]))
    return f"{numbers[shortest]} {shortest}"


def _claim(claim: Expect, protocol: Protocol, conditions: Sequence[Condition]) -> dict[str, Any]:
    chosen = [condition for condition in conditions if _concerns(claim, condition)]
    found = _cases(claim, _others(claim, protocol), chosen)
    return {
        "claim": claim.claim,
        "kind": claim.kind,
        "about": claim.path,
        "over": claim.over,
        "values": [label(claim.path, value) for value in claim.values],
        "limits": list(claim.limits),
        "imposed": claim.imposed,
        "cases": found,
    }


def _concerns(claim: Expect, condition: Condition) -> bool:
    """Return whether a condition has the values to which the claim is restricted."""
    return all(_at(condition, path) in values for path, values in claim.at.items())


def _at(condition: Condition, path: str) -> Any:
    value = reduce(getattr, path.split("."), condition)
    return str(value) if isinstance(value, Material) else value


def _others(claim: Expect, protocol: Protocol) -> list[str]:
    """Return the varied paths that distinguish cases: neither the claim's own path nor paths that
    vary with it.
    """
    paths = []
    for axis in protocol.vary:
        about = [axis.paths.index(path) for path in (claim.path, claim.over) if path in axis.paths]
        rows = [[row[column] for column in about] for row in axis.rows]
        if about and all(rows.count(row) == 1 for row in rows):
            # The other paths of this axis vary with it, one value for each of its own.
            continue
        paths += [path for path in axis.paths if path not in (claim.path, claim.over)]
    return paths


def _cases(
    claim: Expect, others: Sequence[str], chosen: Iterable[Condition]
) -> list[dict[str, Any]]:
    """Return the cases of a claim: the chosen conditions grouped by the values of the
    other paths.
    """
    if claim.kind == "offset_within":
        return _groups([claim.path] if claim.path else [], chosen)
    groups: dict[str, tuple[dict[str, str], list[Condition]]] = {}
    for condition in chosen:
        at = {path: _text(path, _at(condition, path)) for path in others}
        groups.setdefault(str(at), (at, []))[1].append(condition)
    named = _distinct([at for at, _ in groups.values()])
    return [
        {"at": at, "levels": levels}
        for at, (_, members) in zip(named, groups.values(), strict=True)
        if (levels := _levels(claim, members))
    ]


def _text(path: str, value: Any) -> str:
    return ", ".join(map(str, value)) or "none" if isinstance(value, tuple) else label(path, value)


def _groups(paths: Sequence[str], chosen: Iterable[Condition]) -> list[dict[str, Any]]:
    """Return the conditions grouped by the values of the paths, each group as one level."""
    found: dict[str, dict[str, Any]] = {}
    for condition in chosen:
        at = {path: _text(path, _at(condition, path)) for path in paths}
        case = found.setdefault(str(at), {"at": at, "levels": [{"value": "", "conditions": []}]})
        case["levels"][0]["conditions"].append(condition.id)
    return list(found.values())


def _distinct(places: Sequence[dict[str, str]]) -> list[dict[str, str]]:
    """Return the places without the fields that are equal in all of them."""
    if not places:
        return []
    first = places[0]
    differing = [path for path in first if any(place[path] != first[path] for place in places)]
    return [{path: place[path] for path in differing} for place in places]


def _levels(claim: Expect, members: Sequence[Condition]) -> list[dict[str, Any]]:
    """Return the values of a claim that occur, in its order, with the conditions that have them."""
    values = list(dict.fromkeys(_at(condition, claim.path) for condition in members))
    if claim.kind in ("rise", "fall") and all(
        isinstance(value, int | float) for value in (*values, *claim.values)
    ):
        first, last = claim.values
        inside = [value for value in values if min(first, last) <= value <= max(first, last)]
        values = sorted(inside, reverse=first > last)
    elif claim.kind in ("order", "rise", "fall", "nearly_zero"):
        values = [value for value in claim.values if value in values]
    elif claim.kind not in LISTS:
        values.sort()
    levels = []
    for value in values:
        ids = [condition.id for condition in members if _at(condition, claim.path) == value]
        levels.append({"value": label(claim.path, value), "conditions": ids})
    return levels
