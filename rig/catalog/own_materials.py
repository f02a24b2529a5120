"""Materials of one's own in a file `materials.yaml` beside a protocol, or in another catalog file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from daq.documents.notes import Notes
from daq.documents.shapes import Keys, Text
from rig.catalog.entries import Material
from rig.catalog.entries_by_name import NAME, SCHEMA, names
from rig.catalog.stated_values import own_material, own_values
from rig.documents.yaml_reader import read_document, read_file, read_yaml
from rig.errors import InputError, Mistake, nearest, quote

FILE = "materials.yaml"


def read_materials(path: Path) -> dict[str, Material]:
    """Return the materials of a catalog file. Raises InputError with every mistake in it."""
    notes = Notes()
    root = read_yaml(read_file(path), str(path), notes.mistakes)
    one = own_values(f"given in {path.name}", named=False)
    shape = Keys({"schema": Text((SCHEMA,))}, groups={NAME: one}, closed=True)
    found: dict[str, Any] = read_document(shape, root, notes)
    return {name: own_material(name, parts) for name, parts in found.items() if name != "schema"}


class OwnMaterials:
    """Finds the materials that a protocol names: `Notes.meaning` of its reader.

    A name in the folder's `materials.yaml` comes first, then the catalog's. `metals.yaml` is the
    one material of another catalog file in the folder, `metals.yaml:brass` one of several. A name
    of the catalog stays text.
    """

    def __init__(self, folder: Path) -> None:
        """Read the folder's `materials.yaml`, if any. Raises InputError with every mistake in it."""
        self._folder = folder
        path = folder / FILE
        self._own = read_materials(path) if os.path.isfile(path) else {}

    def __call__(self, name: str) -> Material | str:
        """Return the material that a name stands for; raises InputError for an unknown one."""
        file, colon, entry = name.partition(".yaml:")
        if colon or name.endswith((".yaml", ".yml")):
            return self._in_file(f"{file}.yaml" if colon else name, entry)
        if name in self._own or not self._own or name in names("material"):
            return self._own.get(name, name)
        known = [*self._own, *names("material")]
        raise InputError(Mistake("", "", quote(name), ", ".join(known), nearest(name, known)))

    def _in_file(self, file: str, entry: str) -> Material:
        path = self._folder / file
        if not os.path.isfile(path):
            allowed = "a catalog file beside the protocol"
            raise InputError(Mistake("", "", f"no file {quote(file)}", allowed))
        found = read_materials(path)
        if entry in found:
            return found[entry]
        if not entry and len(found) == 1:
            return next(iter(found.values()))
        told = ", ".join(f"{file}:{name}" for name in found)
        hint = nearest(entry, found) if entry else ""
        what = (
            f"no material {quote(entry)}" if entry else f"{len(found)} materials in {quote(file)}"
        )
        raise InputError(Mistake("", "", what, told or "a file with a material", hint))
