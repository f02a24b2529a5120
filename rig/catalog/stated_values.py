"""Numbers that state their origin: `{value, unit, status, source}`, or a plain quantity in a user's
own rig file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

from rig.catalog.entries import STATUSES, CatalogValue
from rig.documents.decode import Notes, Unreadable, describe, entries_of, grammar, number, word_of
from rig.documents.nodes import Node
from rig.errors import Mistake, quote
from rig.units import UNITS, Quantity, unit_of

KEYS = ("value", "unit", "status", "source")


@dataclass(frozen=True)
class Wanted:
    """The form of a catalog field: one number, one or null ("maybe"), or a list of them ("many").

    A field that is not `needed` may be left out.
    """

    quantity: Quantity
    form: Literal["one", "maybe", "many"] = "one"
    needed: bool = True


def wanted_by(kind: type) -> dict[str, Wanted]:
    """Return the number fields of a catalog dataclass."""
    found = {}
    for name, annotation in grammar(kind).items():
        marks = [extra for extra in get_args(annotation) if isinstance(extra, Quantity)]
        if marks:
            found[name] = Wanted(marks[0])
    return found


def read_all(entries: Mapping[str, Node], wanted: Mapping[str, Wanted], path: str, notes: Notes) -> list[CatalogValue]:
    """Return the stated values of the wanted entries, paths prefixed by `path`; entries with
    mistakes are noted and left out.
    """
    found = []
    for name, entry in entries.items():
        if name in wanted:
            try:
                found.append(read_stated(entry, wanted[name], f"{path}.{name}" if path else name, notes))
            except Unreadable:
                continue
    return found


def read_stated(node: Node, wanted: Wanted, path: str, notes: Notes) -> CatalogValue:
    """Return one stated value in SI. Raises Unreadable after noting the mistake."""
    unit = unit_of(wanted.quantity.dimension)
    if not isinstance(node.value, dict):
        return CatalogValue(path, _value(node, wanted, path, notes), unit, "assumed", "given in the rig file")
    entries = entries_of(node, path, KEYS, notes)
    for key in ("value", "status"):
        if key not in entries:
            raise notes.reject(node.where, path, f"no {key}", f"a mapping with the keys {', '.join(KEYS)}")
    status = word_of(entries["status"], f"{path}.status", STATUSES, notes)
    source = word_of(entries["source"], f"{path}.source", (), notes) if "source" in entries else ""
    value = entries["value"]
    if "unit" in entries:
        value = _with_unit(value, entries["unit"], wanted.quantity, path, notes)
    return CatalogValue(path, _value(value, wanted, path, notes), unit, status, source)


def write_stated(value: CatalogValue) -> dict[str, Any]:
    """Return the mapping that read_stated reads back to the same value."""
    number = list(value.value) if isinstance(value.value, tuple) else value.value
    unit = {"unit": value.unit} if value.unit else {}
    return {"value": number, **unit, "status": value.status, "source": value.source}


def _with_unit(node: Node, unit: Node, quantity: Quantity, path: str, notes: Notes) -> Node:
    """Return the node of a number with its unit appended, as one quantity in words."""
    word = word_of(unit, f"{path}.unit", (), notes)
    if word not in UNITS[quantity.dimension]:
        allowed = ", ".join(known for known in UNITS[quantity.dimension] if known)
        notes.mistakes.append(Mistake(unit.where, f"{path}.unit", quote(word), allowed))
        raise Unreadable(path)
    if isinstance(node.value, tuple):
        return Node(node.where, tuple(_with_unit(item, unit, quantity, path, notes) for item in node.value))
    if not isinstance(node.value, int | float) or isinstance(node.value, bool):
        return node
    text = f"{node.text} {word}"
    return Node(node.where, text, text)


def _value(node: Node, wanted: Wanted, path: str, notes: Notes) -> float | tuple[float, ...] | None:
    """Return the SI number or numbers of a field."""
    if wanted.form == "maybe" and node.value is None:
        return None
    if wanted.form != "many":
        return float(number(node, wanted.quantity, path, notes))
    if not isinstance(node.value, tuple) or not node.value:
        raise notes.reject(node.where, path, describe(node), f"a list of numbers, {wanted.quantity}")
    return tuple(float(number(item, wanted.quantity, path, notes)) for item in node.value)
