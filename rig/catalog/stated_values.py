"""Numbers that state their origin: `{value, unit, status, source}`, or a plain quantity in a user's
own rig file or protocol; and materials, which are made of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, get_type_hints

from daq.documents.notes import Node, Notes, Unreadable, bare, where_of
from daq.documents.shapes import Anything, Keys, List, Shape, Text
from rig.catalog.entries import STATUSES, CatalogValue, Material
from rig.errors import InputError
from rig.units import UNITS, Quantity, unit_of

_WORD = Text(as_written=True)
_STATED = Keys(
    {"value": Anything(), "status": Text(STATUSES)}, {"unit": _WORD, "source": _WORD}, closed=True
)


@dataclass(frozen=True)
class StatedNumber:
    """A number with its origin, or with `many` a list of them; read into a CatalogValue in SI, null
    allowed where the quantity's is. `plain_source` : origin of a number that states none."""

    quantity: Quantity
    many: bool = False
    plain_source: str = "given in the rig file"

    def __str__(self) -> str:
        return f"a list of numbers, {self.quantity}" if self.many else str(self.quantity)

    def read(self, node: Node, path: str, notes: Notes) -> CatalogValue:
        """Return the stated value; a plain number counts as assumed."""
        parts: dict[str, Any] = {
            "value": node,
            "status": "assumed",
            "source": self.plain_source,
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
        """Return the schema: the number alone, or the mapping."""
        number: Shape = List(self.quantity, least=1) if self.many else self.quantity
        return {"anyOf": [number.schema(kinds), _STATED.schema(kinds)]}


def stated_fields(kind: type) -> dict[str, StatedNumber]:
    """Return the number fields of a catalog dataclass."""
    hints = get_type_hints(kind, include_extras=True)
    marks = {
        name: hint.__metadata__ for name, hint in hints.items() if hasattr(hint, "__metadata__")
    }
    return {name: StatedNumber(mark) for name, (mark,) in marks.items()}


def write_stated(value: CatalogValue) -> dict[str, Any]:
    """Return the mapping that reads back to the same value."""
    number = list(value.value) if isinstance(value.value, tuple) else value.value
    unit = {"unit": value.unit} if value.unit else {}
    return {"value": number, **unit, "status": value.status, "source": value.source}


def _with_unit(node: Node, unit: str) -> Node:
    """Return the node with a unit beside every plain number in it."""
    if isinstance(node.value, tuple):
        return Node(node.where, tuple(_with_unit(item, unit) for item in node.value))
    if not isinstance(node.value, int | float) or isinstance(node.value, bool):
        return node
    return Node(node.where, f"{node.text} {unit}", f"{node.text} {unit}")


NEEDED = ("density", "youngs_modulus", "poisson_ratio")
"""Numbers that every material has; coefficients of contact may be left to the rig."""

UNNAMED = "own"
"""Name of a material that is written in a protocol without one."""

NOT_STATED: Mapping[str, CatalogValue] = {
    value.path: value
    for value in (
        CatalogValue(
            "youngs_modulus", 1e11, "Pa", "assumed", "not stated; polymers have 3, ceramics 300 GPa"
        ),
        CatalogValue("poisson_ratio", 0.3, "", "assumed", "not stated; most solids have 0.2-0.4"),
    )
}
"""What takes the place of an elastic constant that one's own material leaves out. Coefficients of
contact that are left out are the rig's.
"""

_LABEL = Text(as_written=True)
_NAME = Text(
    pattern=r"[A-Za-z0-9][A-Za-z0-9 _.+-]{0,39}",
    allowed="at most 40 letters, digits, spaces, _, +, - and ., starting with a letter or digit",
    as_written=True,
)


def needed_numbers(origin: str = "") -> dict[str, StatedNumber]:
    """Return the shapes of the numbers that every material has; `origin` : of plain ones."""
    return {name: shape for name, shape in _numbers(origin).items() if name in NEEDED}


def contact_numbers(origin: str = "") -> dict[str, StatedNumber]:
    """Return the shapes of the coefficients of contact, which a material may leave to the rig."""
    return {name: shape for name, shape in _numbers(origin).items() if name not in NEEDED}


def _numbers(origin: str) -> dict[str, StatedNumber]:
    return {
        name: replace(shape, plain_source=origin) for name, shape in stated_fields(Material).items()
    }


def own_values(origin: str, named: bool) -> Keys:
    """Return the shape of one's own material; only its density is required.

    origin : of plain numbers, in words
    named : whether its name is a key of the mapping, and not the key of the mapping itself
    """
    numbers = needed_numbers(origin) | contact_numbers(origin)
    density = {"density": numbers.pop("density")}
    words = {"name": _NAME, "label": _LABEL} if named else {"label": _LABEL}
    return Keys(density, {**words, **numbers}, closed=True)


def own_material(name: str, parts: Mapping[str, Any]) -> Material:
    """Return the material of the values that were read with `own_values`."""
    given = {
        key: replace(part, path=key)
        for key, part in parts.items()
        if isinstance(part, CatalogValue)
    }
    stated = {**NOT_STATED, **given}
    values = tuple(stated[key] for key in stated_fields(Material) if key in stated)
    numbers: dict[str, Any] = {value.path: value.value for value in values}
    return Material(name=name, label=parts.get("label", name), values=values, **numbers)


@dataclass(frozen=True)
class MaterialShape:
    """A material: its name, which stays text for one of the catalog, or a mapping with its values,
    which becomes a `Material`.
    """

    null: bool = False

    def fitted(self, whole: bool, null: bool, words: tuple[str, ...]) -> MaterialShape:
        """Return the shape as a field's type wants it; only `null` matters here."""
        del whole, words
        return replace(self, null=null)

    def __str__(self) -> str:
        keys = ", ".join(_WRITTEN.optional)
        return f"the name of a material, or a mapping with density and any of {keys}"

    def read(self, node: Any, path: str, notes: Notes) -> Material | str | None:
        """Return the name, the material that it stands for beside the document, or one's own."""
        if isinstance(bare(node), dict):
            parts = _WRITTEN.read(node, path, notes)
            return own_material(parts.get("name", UNNAMED), parts)
        name: str | None = Text(null=self.null, as_written=True, allowed=str(self)).read(
            node, path, notes
        )
        if name is None or notes.meaning is None:
            return name
        try:
            found: Material | str = notes.meaning(name)
        except InputError as error:
            for one in error.mistakes:
                where, field = one.where or where_of(node), one.field or path
                notes.reject(where, field, one.found, one.allowed, one.hint)
            raise Unreadable(path) from None
        return found

    def plain(self, value: Material | str | None) -> Any:
        """Return the name, or the mapping that is read back to the same material."""
        if not isinstance(value, Material):
            return value
        origins = {origin.path: origin for origin in value.values}
        numbers = {key: getattr(value, key) for key in stated_fields(Material)}
        return {"name": value.name, "label": value.label} | {
            key: write_stated(origins[key]) if key in origins else number
            for key, number in numbers.items()
            if number is not None
        }

    def schema(self, kinds: dict[str, Any]) -> dict[str, Any]:
        """Return the JSON Schema: text, the mapping, or null where allowed."""
        forms: list[dict[str, Any]] = [
            {"type": "string"},
            {"type": "number"},
            _WRITTEN.schema(kinds),
        ]
        return {"anyOf": forms + ([{"type": "null"}] if self.null else [])}


_WRITTEN = own_values("given with the scene", named=True)
MATERIAL = MaterialShape()
