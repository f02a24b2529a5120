"""Rig files: everything about the stand that a protocol does not state, read strictly and written
back unchanged.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from rig.catalog.entries import CatalogValue, Exciter, Rig
from rig.catalog.entries_by_name import HERE, entry_of, names
from rig.catalog.stated_values import Wanted, read_all, wanted_by, write_stated
from rig.documents.decode import Notes, Unreadable, describe, entries_of, word_of
from rig.documents.nodes import Node
from rig.documents.yaml_reader import read_file, read_yaml
from rig.documents.yaml_writer import write_yaml
from rig.errors import InputError, Mistake, in_order, nearest, quote
from rig.units import Quantity

SCHEMA = "rig/rig/1"
DEFAULT = "default"
RANGES = ("force", "acceleration", "current", "voltage")
_VOLTS = Wanted(Quantity("voltage", 0.0, 1000.0, above=True))
_PRESET = "preset"


def rig_names() -> tuple[str, ...]:
    """Return the names of the catalog's rigs."""
    return tuple(sorted(path.stem for path in (HERE / "rigs").glob("*.yaml")))


def is_path(name: str) -> bool:
    """Return whether a rig is given by its file and not by its catalog name."""
    return "/" in name or "\\" in name or name.endswith((".yaml", ".yml"))


def rig_path(name: str | Path) -> Path:
    """Return the file of a rig. Raises InputError where it does not exist."""
    named_by_file = isinstance(name, Path) or is_path(name)
    path = Path(name) if named_by_file else HERE / "rigs" / f"{name}.yaml"
    if not (os.path.isfile(path) if named_by_file else name in rig_names()):
        hint = nearest(str(name), rig_names())
        allowed = f"{', '.join(rig_names())}, or the path of a rig file (.yaml)"
        raise InputError(Mistake("", "rig", f"no rig {quote(str(name))}", allowed, hint))
    return path


def load_rig(name_or_path: str | Path = DEFAULT) -> Rig:
    """Return a rig from the catalog or from a file; values missing in a file are those of the
    default rig.

    Raises InputError with every mistake of the file.
    """
    path = rig_path(name_or_path)
    notes = Notes()
    base = None if path == rig_path(DEFAULT) else load_rig(DEFAULT)
    try:
        rig = _rig(read_yaml(read_file(path), str(path), notes.mistakes), base, notes)
    except Unreadable:
        raise InputError(*in_order(notes.mistakes)) from None
    if notes.mistakes:
        raise InputError(*in_order(notes.mistakes))
    return rig


def rig_with_losses(rig: Rig, noise: float, air: float, provenance: Mapping[str, Any]) -> Rig:
    """Return the rig with identified loss coefficients, `noise` in N s/m and `air` in N s^2/m^2,
    and their provenance.
    """
    found = {"loss_noise": noise, "loss_air": air}
    values = []
    for value in rig.values:
        if value.path in found:
            origin = "rig calibrate, see provenance"
            value = replace(value, value=found[value.path], status="computed", source=origin)
        values.append(value)
    return replace(rig, loss_noise=noise, loss_air=air, provenance=dict(provenance), values=tuple(values))


def dump_rig(rig: Rig) -> str:
    """Return the text of a rig file that load_rig reads back to an equal rig."""
    origins = {value.path: value for value in rig.values}

    def stated(owner: str, thing: object, path: str) -> dict[str, Any]:
        number = thing[path] if isinstance(thing, Mapping) else getattr(thing, path)
        return write_stated(replace(origins[f"{owner}{path}"], value=number))

    parts: dict[str, Any] = {_PRESET: rig.exciter.name}
    parts |= {path: stated("exciter.", rig.exciter, path) for path in wanted_by(Exciter)}
    # An exciter equal to the catalog's is written by its name alone.
    preset = rig.exciter.name in names("exciter") and _preset_values(rig.exciter.name) == {
        path: origins[path] for path in origins if path.startswith("exciter.")
    }
    data: dict[str, Any] = {"schema": SCHEMA, "name": rig.name, "exciter": rig.exciter.name if preset else parts}
    data |= {path: stated("", rig, path) for path in wanted_by(Rig)}
    data["ranges"] = {path: stated("ranges.", rig.ranges, path) for path in RANGES}
    data["provenance"] = dict(rig.provenance)
    return write_yaml(data)


def _rig(root: Node, base: Rig | None, notes: Notes) -> Rig:
    """Return the rig of a file's root node, with the values of `base` where the file has none;
    mistakes are noted.
    """
    wanted = wanted_by(Rig)
    entries = entries_of(root, "", ("schema", "name", "exciter", *wanted, "ranges", "provenance"), notes)
    _check_schema(root, entries, notes)
    # Later entries replace earlier ones: the default rig, the file, the file's ranges, its exciter.
    values = {value.path: value for value in base.values} if base else {}
    values |= {value.path: value for value in read_all(entries, wanted, "", notes)}
    if "ranges" in entries:
        limits = entries_of(entries["ranges"], "ranges", RANGES, notes)
        values |= {value.path: value for value in read_all(limits, dict.fromkeys(RANGES, _VOLTS), "ranges", notes)}
    name = base.name if base else DEFAULT
    if "name" in entries:
        name = word_of(entries["name"], "name", (), notes)
    preset, exciter_values = _exciter(entries.get("exciter"), base, values, notes)
    values |= exciter_values
    _check_packing(root, entries, values, notes)
    # The listing has one order, whatever the order in the file.
    order = [*wanted, *(f"ranges.{key}" for key in RANGES), *(f"exciter.{key}" for key in wanted_by(Exciter))]
    number: dict[str, Any] = {path: value.value for path, value in values.items()}
    return Rig(
        name=name,
        exciter=Exciter(preset, **{key: number[f"exciter.{key}"] for key in wanted_by(Exciter)}),
        ranges={key: number[f"ranges.{key}"] for key in RANGES if f"ranges.{key}" in number},
        provenance=_provenance(entries.get("provenance"), base, notes),
        values=tuple(values[path] for path in order if path in values),
        **{key: number[key] for key in wanted if key in number},
    )


def _preset_values(name: str) -> dict[str, CatalogValue]:
    """Return the stated values of a catalog exciter, by their paths in a rig file."""
    stated = entry_of("exciter", name).values
    return {f"exciter.{value.path}": replace(value, path=f"exciter.{value.path}") for value in stated}


def _exciter(
    node: Node | None, base: Rig | None, values: Mapping[str, CatalogValue], notes: Notes
) -> tuple[str, dict[str, CatalogValue]]:
    """Return the exciter's name and stated values: a catalog name, or a preset with some values
    replaced.
    """
    if node is None:
        name = base.exciter.name if base else names("exciter")[0]
        return name, {path: value for path, value in values.items() if path.startswith("exciter.")}
    wanted = wanted_by(Exciter)
    if not isinstance(node.value, dict):
        name = word_of(node, "exciter", names("exciter"), notes)
        return name, _preset_values(name)
    entries = entries_of(node, "exciter", (_PRESET, *wanted), notes)
    if _PRESET not in entries:
        raise notes.reject(node.where, "exciter", f"no {_PRESET}", f"{_PRESET}: one of {', '.join(names('exciter'))}")
    name = word_of(entries[_PRESET], f"exciter.{_PRESET}", names("exciter"), notes)
    own = {value.path: value for value in read_all(entries, wanted, "exciter", notes)}
    return name, _preset_values(name) | own


def _check_schema(root: Node, entries: Mapping[str, Node], notes: Notes) -> None:
    if "schema" not in entries:
        notes.reject(root.where, "schema", "nothing", SCHEMA)
    elif entries["schema"].value != SCHEMA:
        notes.reject(entries["schema"].where, "schema", describe(entries["schema"]), SCHEMA)


def _check_packing(root: Node, entries: Mapping[str, Node], values: Mapping[str, CatalogValue], notes: Notes) -> None:
    loose, shaken = (values[key].value if key in values else None for key in ("packing_loose", "packing_shaken"))
    if isinstance(loose, float) and isinstance(shaken, float) and loose > shaken:
        where = entries.get("packing_loose", entries.get("packing_shaken", root)).where
        allowed = f"at most packing_shaken, {shaken:g}: shaking makes a bed denser"
        notes.reject(where, "packing_loose", f"{loose:g}", allowed)


def _provenance(node: Node | None, base: Rig | None, notes: Notes) -> Mapping[str, Any]:
    if node is None:
        return base.provenance if base else {}
    if not isinstance(node.value, dict):
        raise notes.reject(node.where, "provenance", describe(node), "a mapping")
    plain: dict[str, Any] = node.plain()
    return plain
