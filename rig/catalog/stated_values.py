"""Numbers that state their origin: `{value, unit, status, source}`, or a plain quantity in a user's
own rig file.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from daq.documents.classes import keys_of
from daq.documents.notes import Node, Notes, Unreadable
from daq.documents.shapes import Anything, Keys, List, Shape, Text
from rig.catalog.entries import STATUSES, CatalogValue
from rig.units import UNITS, Quantity, unit_of

_WORD = Text(as_written=True)
_STATED = Keys(
    {"value": Anything(), "status": Text(STATUSES)}, {"unit": _WORD, "source": _WORD}, closed=True
)


@dataclass(frozen=True)
class StatedNumber:
    """A number with its origin, or with `many` a list of them; read into a CatalogValue in SI, null
    allowed where the quantity's is."""

    quantity: Quantity
    many: bool = False

    def __str__(self) -> str:
        return f"a list of numbers, {self.quantity}" if self.many else str(self.quantity)

    def read(self, node: Node, path: str, notes: Notes) -> CatalogValue:
        """The stated value; a plain one is taken as assumed."""
        parts: dict[str, Any] = {
            "value": node,
            "status": "assumed",
            "source": "given in the rig file",
        }
        if isinstance(node.value, dict):
            parts = {"source": "", **_STATED.read(node, path, notes)}
            if notes.spoilt(path):
                raise Unreadable(path)
        value = parts["value"]
        if "unit" in parts:
            units = Text(tuple(unit for unit in UNITS[self.quantity.dimension] if unit))
            place = node.value["unit"] if isinstance(node.value, dict) else node
            value = _with_unit(value, units.read(place, f"{path}.unit", notes))
        shape: Shape = (
            List(self.quantity, least=1, what=f"numbers, {self.quantity}")
            if self.many
            else self.quantity
        )
        number: Any = shape.read(value, path, notes)
        return CatalogValue(
            path, number, unit_of(self.quantity.dimension), parts["status"], parts["source"]
        )

    def schema(self, kinds: dict[str, Any]) -> dict[str, Any]:
        """The number alone, or the mapping."""
        number: Shape = List(self.quantity, least=1) if self.many else self.quantity
        return {"anyOf": [number.schema(kinds), _STATED.schema(kinds)]}


def stated_fields(kind: type) -> dict[str, StatedNumber]:
    """The number fields of a catalog dataclass."""
    return {
        name: StatedNumber(shape)
        for name, shape in keys_of(kind).every().items()
        if isinstance(shape, Quantity)
    }


def write_stated(value: CatalogValue) -> dict[str, Any]:
    """The mapping that is read back to the same value."""
    number = list(value.value) if isinstance(value.value, tuple) else value.value
    unit = {"unit": value.unit} if value.unit else {}
    return {"value": number, **unit, "status": value.status, "source": value.source}


def _with_unit(node: Node, unit: str) -> Node:
    """The node with a unit beside every plain number in it."""
    if isinstance(node.value, tuple):
        return Node(node.where, tuple(_with_unit(item, unit) for item in node.value))
    if not isinstance(node.value, int | float) or isinstance(node.value, bool):
        return node
    return Node(node.where, f"{node.text} {unit}", f"{node.text} {unit}")
