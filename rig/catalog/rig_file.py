"""Rig files: everything about the stand that a protocol does not state, read strictly and written
back unchanged.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from daq.documents.notes import Node, Notes, new_name
from daq.documents.shapes import Anything, Each, Either, Keys, Text, Then, one_of
from rig.catalog.entries import CatalogValue, Exciter, Rig
from rig.catalog.entries_by_name import HERE, entry_of, names
from rig.catalog.stated_values import StatedNumber, stated_fields, write_stated
from rig.documents.former_names import FORMER_NAMES, FORMER_RIGS
from rig.documents.yaml_reader import read_document, read_file, read_yaml
from rig.documents.yaml_writer import write_yaml
from rig.errors import InputError, Mistake, nearest, quote
from rig.units import Quantity

SCHEMA = "rig/rig/1"
DEFAULT = "clean"
RANGES = ("force", "acceleration", "current", "voltage")
_VOLTS = StatedNumber(Quantity("voltage", 0.0, 1000.0, above=True))
_PRESET = "preset"
_PACKING = ("packing_loose", "packing_shaken")
_EXCITER = tuple(f"exciter.{name}" for name in stated_fields(Exciter))


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
        hint = new_name(Path(name).stem, rig_names(), FORMER_RIGS) or nearest(
            str(name), rig_names()
        )
        allowed = f"{', '.join(rig_names())}, or the path of a rig file (.yaml)"
        raise InputError(Mistake("", "rig", f"no rig {quote(str(name))}", allowed, hint))
    return path


def load_rig(name_or_path: str | Path = DEFAULT) -> Rig:
    """Return a rig from the catalog or from a file; values missing in a file are those of the
    default rig.

    Raises InputError with every mistake of the file.
    """
    path = rig_path(name_or_path)
    notes = Notes(renamed=FORMER_NAMES)
    base = None if path == rig_path(DEFAULT) else load_rig(DEFAULT)
    root = read_yaml(read_file(path), str(path), notes.mistakes)
    return _rig(read_document(rig_shape(base), root, notes), base)


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
    return replace(
        rig, loss_noise=noise, loss_air=air, provenance=dict(provenance), values=tuple(values)
    )


def dump_rig(rig: Rig) -> str:
    """Return the text of a rig file that load_rig reads back to an equal rig."""
    origins = {value.path: value for value in rig.values}

    def stated(owner: str, thing: object, path: str) -> dict[str, Any]:
        number = thing[path] if isinstance(thing, Mapping) else getattr(thing, path)
        return write_stated(replace(origins[f"{owner}{path}"], value=number))

    parts: dict[str, Any] = {_PRESET: rig.exciter.name}
    parts |= {path: stated("exciter.", rig.exciter, path) for path in stated_fields(Exciter)}
    preset = rig.exciter.name in names("exciter") and _preset_values(rig.exciter.name) == {
        path: origins[path] for path in origins if path.startswith("exciter.")
    }
    data: dict[str, Any] = {
        "schema": SCHEMA,
        "name": rig.name,
        "exciter": rig.exciter.name if preset else parts,
    }
    data |= {path: stated("", rig, path) for path in stated_fields(Rig)}
    data["ranges"] = {path: stated("ranges.", rig.ranges, path) for path in RANGES}
    data["provenance"] = dict(rig.provenance)
    return write_yaml(data)


def rig_shape(base: Rig | None) -> Then:
    """Return the shape of a rig file: every number with its origin, the exciter by name or with
    values of its own.
    """
    preset = one_of(*names("exciter"))
    own = Keys({_PRESET: preset}, stated_fields(Exciter), closed=True)
    return Then(
        Keys(
            {"schema": one_of(SCHEMA)},
            {
                "name": Text(as_written=True),
                "exciter": Either(preset, own),
                **stated_fields(Rig),
                "ranges": Keys({}, dict.fromkeys(RANGES, _VOLTS), closed=True),
                "provenance": Each(Anything()),
            },
            closed=True,
            standing_in={"schema": SCHEMA},
        ),
        partial(_check_packing, base),
    )


def _rig(parts: Mapping[str, Any], base: Rig | None) -> Rig:
    """Return the rig of a file's values; `base` supplies the others."""
    exciter = parts.get("exciter", base.exciter.name if base else names("exciter")[0])
    values = {value.path: value for value in base.values} if base else {}
    if "exciter" in parts or base is None:
        own = exciter if isinstance(exciter, dict) else {_PRESET: exciter}
        exciter = own[_PRESET]
        values |= _preset_values(exciter) | {
            value.path: value for key, value in own.items() if key != _PRESET
        }
    stated = [
        part
        for part in (*parts.values(), *parts.get("ranges", {}).values())
        if isinstance(part, CatalogValue)
    ]
    values |= {value.path: value for value in stated}
    order = [*stated_fields(Rig), *(f"ranges.{key}" for key in RANGES), *_EXCITER]
    provenance = base.provenance if base else {}
    if "provenance" in parts:
        provenance = {key: part.plain() for key, part in parts["provenance"].items()}
    number: dict[str, Any] = {path: value.value for path, value in values.items()}
    return Rig(
        name=parts.get("name", base.name if base else DEFAULT),
        exciter=Exciter(exciter, **{path.partition(".")[2]: number[path] for path in _EXCITER}),
        ranges={key: number[f"ranges.{key}"] for key in RANGES if f"ranges.{key}" in number},
        provenance=provenance,
        values=tuple(values[path] for path in order if path in values),
        **{key: number[key] for key in stated_fields(Rig) if key in number},
    )


def _preset_values(name: str) -> dict[str, CatalogValue]:
    """Return the stated values of a catalog exciter, by their paths in a rig file."""
    stated = entry_of("exciter", name).values
    return {
        f"exciter.{value.path}": replace(value, path=f"exciter.{value.path}") for value in stated
    }


def _check_packing(
    base: Rig | None, parts: dict[str, Any], _node: Node, _path: str, notes: Notes
) -> dict[str, Any]:
    own = [key for key in _PACKING if key in parts]
    loose, shaken = (
        parts[key].value if key in parts else getattr(base, key, None) for key in _PACKING
    )
    if own and isinstance(loose, float) and isinstance(shaken, float) and loose > shaken:
        allowed = f"at most packing_shaken, {shaken:g}: shaking makes a bed denser"
        notes.reject(notes.place_of(own[0]), _PACKING[0], f"{loose:g}", allowed)
    return parts
