"""Read a protocol from YAML, strictly, and write it back; its JSON Schema.

Every mistake of a file is reported at once.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from operator import attrgetter, getitem
from pathlib import Path
from typing import Any

from daq.documents.classes import keys_of, paths_of
from daq.documents.json_schema import document_schema
from daq.documents.notes import Node, Notes, Unreadable
from daq.documents.shapes import Keys, Shape, Text, Then, one_of, plain
from rig.catalog.entries_by_name import HERE
from rig.catalog.own_materials import OwnMaterials
from rig.catalog.rig_file import is_path, rig_path
from rig.documents.former_names import FORMER_NAMES
from rig.documents.yaml_reader import read_file, read_yaml
from rig.documents.yaml_writer import write_yaml
from rig.errors import InputError, Mistake, in_order, quote
from rig.protocol import shipped
from rig.protocol.claims import expect_shape, plain_expect
from rig.protocol.deliberate_errors import DeliberateError
from rig.protocol.fault_list import faults_shape, misplaced, plain_faults
from rig.protocol.grid import Row, expand
from rig.protocol.overrides import edited
from rig.protocol.spec import SCHEMA, Protocol, Repeats
from rig.protocol.vary import PARTS, Axes, axes_shape, plain_axes

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,79}", re.ASCII)
_NAMING = (
    "at most 80 letters, digits, _, - and ., starting with a letter or digit (it names a folder)"
)
YOUNGER = ("scene.cavity.material", "scene.cavity.density")
"""Fields that came after sessions and reports had been written: left out where they have their
defaults, so that old sessions can be resumed and old reports keep their bytes.
"""
_DEFAULTS = Protocol(name="")


@dataclass(frozen=True)
class LoadedProtocol:
    """A protocol, its text as written (before any change from the command line), and its file, None
    for a text.
    """

    protocol: Protocol
    text: str
    path: Path | None


def load_protocol(
    source: str | Path,
    sets: Sequence[str] = (),
    varies: Sequence[str] = (),
    seed: int | None = None,
    rig: str | None = None,
) -> Protocol:
    """Return the protocol of a file, of a shipped name (`fill_rate`), or of a text.

    A string of several lines, or one that starts with a brace, is a text. Raises InputError with
    every mistake.

    sets : changes of values, such as "scene.bed=empty"
    varies : axes of the grid to add or replace, such as "scene.grains.fill=[0.5, 0.9]"
    seed, rig : replace the protocol's
    """
    return read_protocol(source, sets, varies, seed, rig).protocol


def read_protocol(
    source: str | Path,
    sets: Sequence[str] = (),
    varies: Sequence[str] = (),
    seed: int | None = None,
    rig: str | None = None,
) -> LoadedProtocol:
    """Return the protocol as `load_protocol` does, with its verbatim text and its file."""
    if isinstance(source, str) and ("\n" in source or source.lstrip().startswith("{")):
        path, text, name = None, source, "protocol"
    else:
        path = shipped.protocol_path(source)
        if isinstance(source, str) and not os.path.lexists(path) and "\0" not in source:
            raise _no_file(source)
        text, name = read_file(path), str(path)
    beside = path.parent if path is not None else Path()
    notes = Notes(
        known=tuple(paths_of(Protocol)), renamed=FORMER_NAMES, meaning=OwnMaterials(beside)
    )
    root = edited(read_yaml(text, name, notes.mistakes), sets, varies, seed, rig)
    # A rig file is looked for beside the protocol; one from the command line, where one works.
    folder = beside if rig is None else Path()
    return LoadedProtocol(_read(root, folder, notes), text, path)


def _no_file(source: str) -> InputError:
    """Return the error for a source that is neither a file nor a shipped name."""
    names, hint = ", ".join(shipped.names()), shipped.hint(source)
    if NAME.fullmatch(source) and not source.endswith((".yaml", ".yml")):
        found = f"no file and no shipped protocol {quote(source)}"
        return InputError(Mistake(source, "", found, f"a protocol file, or one of {names}", hint))
    return InputError(Mistake(source, "", "no such file or directory", "a readable file", hint))


def dump_protocol(protocol: Protocol) -> str:
    """Return the YAML text of a protocol, every field written out.

    `load_protocol` reads it back to an equal protocol. `fidelity`, `tolerance`, `deliberate_error`
    and the fields of `YOUNGER` are left out where they have their defaults.
    """
    data: dict[str, Any] = {"schema": protocol.schema, "rig": protocol.rig, "name": protocol.name}
    data["question"] = protocol.question
    data |= {
        name: plain(keys_of(Protocol).every()[name], getattr(protocol, name)) for name in PARTS
    }
    for path in YOUNGER:
        *groups, name = path.split(".")
        if attrgetter(path)(protocol) == attrgetter(path)(_DEFAULTS):
            del reduce(getitem, groups, data)[name]
    data["vary"] = plain_axes(protocol.vary)
    data["repeats"] = plain(keys_of(Repeats), protocol.repeats)
    data |= {
        "seed": protocol.seed,
        "faults": plain_faults(protocol.faults),
        "expect": [plain_expect(claim) for claim in protocol.expect],
    }
    if protocol.fidelity != "as_written":
        data["fidelity"] = protocol.fidelity
    if protocol.tolerance is not None:
        data["tolerance"] = protocol.tolerance
    if protocol.prediction is not None:
        data["prediction"] = protocol.prediction
    made = plain(keys_of(DeliberateError), protocol.deliberate_error)
    if protocol.deliberate_error.kinds:
        data["deliberate_error"] = {kind: made[kind] for kind in protocol.deliberate_error.kinds}
    return write_yaml(data)


def protocol_template() -> str:
    """Return the commented protocol that `rig init` writes."""
    return read_file(HERE / "templates" / "protocol.yaml")


def protocol_shape(folder: Path, axes: Axes) -> Keys:
    """Return the shape of a protocol file in a folder; reading adds the grid's axes to `axes`."""
    whole = keys_of(Protocol)
    # Fields that are read in another way than their annotations say.
    others: dict[str, Shape] = {
        "rig": Then(Text(as_written=True), partial(_rig, folder)),
        "vary": axes_shape(axes),
        "repeats": replace(keys_of(Repeats), alone=("n",)),
        "faults": faults_shape(),
        "expect": expect_shape(),
    }
    name = Text(pattern=NAME.pattern, allowed=_NAMING, as_written=True)
    return replace(
        whole,
        required={"name": name, "schema": one_of(SCHEMA)},
        optional={
            key: others.get(key, shape) for key, shape in whole.optional.items() if key != "schema"
        },
        standing_in={"name": "", "schema": ""},
    )


def protocol_schema() -> dict[str, Any]:
    """Return the JSON Schema of a protocol file.

    It accepts more than the reader: checks over several fields (levels in the grid, bed and axis)
    and ranges of numbers that are written as text with a unit are left to `rig check`.
    """
    shape = protocol_shape(Path(), Axes())
    return document_schema(shape, f"Protocol of the particle-damper rig, {SCHEMA}")


def _read(root: Node, folder: Path, notes: Notes) -> Protocol:
    """Return the protocol of a tree: read each field, then check the fields taken together."""
    axes = Axes()
    try:
        protocol: Protocol = protocol_shape(folder, axes).read(root, "", notes)
    except Unreadable:
        raise InputError(*in_order(notes.mistakes)) from None

    def place(path: str, rows: Row) -> str:
        """Return where the value of a path was written: on its axis, or at the field itself."""
        for axis_path, row in rows.items():
            if path == axis_path or path.startswith(f"{axis_path}."):
                return axes.places[axis_path][row]
        return notes.place_of(path)

    mistakes = list(notes.mistakes)
    try:
        found = expand(protocol, place, _with_fields_inside(notes.failed))
        mistakes += misplaced(protocol, found, notes)
    except InputError as error:
        mistakes += error.mistakes
    if mistakes:
        raise InputError(*in_order(mistakes))
    return protocol


def _with_fields_inside(failed: set[str]) -> frozenset[str]:
    """Return failed paths and every path inside them: all of these hold defaults, not the user's
    values.
    """
    tops = tuple(f"{top}." for top in failed)
    return frozenset(failed.union(path for path in paths_of(Protocol) if path.startswith(tops)))


def _rig(folder: Path, name: str, node: Node, path: str, notes: Notes) -> str:
    """Return a rig's name, a path taken from the protocol's own folder; note a rig that is not
    there.
    """
    if is_path(name):
        name = str(folder / name)
    try:
        rig_path(name)
    except InputError as error:
        for mistake in error.mistakes:
            notes.reject(node.where, path, mistake.found, mistake.allowed, mistake.hint)
        raise Unreadable(path) from None
    return name
