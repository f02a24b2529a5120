"""The catalog's own files: materials, exciters, transducers, analyzers, each entry a set of numbers
with their origins.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from daq.documents.notes import Node, Notes
from daq.documents.shapes import Choice, Keys, Shape, Text, Then
from rig.catalog.entries import CatalogValue, Exciter, Material
from rig.catalog.stated_values import StatedNumber, contact_numbers, needed_numbers, stated_fields
from rig.documents.yaml_reader import read_document, read_file, read_yaml
from rig.errors import InputError, Mistake, nearest, quote
from rig.units import Quantity

if TYPE_CHECKING:
    from daq.chain.channel import AnalyzerSpec, TransducerSpec

HERE = Path(__file__).parent
SCHEMA = "rig/catalog/1"
NAME = r"[A-Za-z0-9].*"
KINDS = ("material", "exciter", "transducer", "analyzer")
IDEAL = "ideal"

_RELATIVE = Quantity("number", 0.0, 1.0)
_COUNT = Quantity("number", 1.0, 64.0)
_SENSOR_UNITS = {"force": "N", "acceleration": "m/s^2", "voltage": "V", "current": "A"}


class Entry(NamedTuple):
    """An entry of the catalog: its words (label, quantity) and its numbers with their origins."""

    words: dict[str, str]
    values: tuple[CatalogValue, ...]

    def numbers(self) -> dict[str, Any]:
        """Return the SI numbers by field."""
        return {value.path: value.value for value in self.values}

    def statuses(self) -> dict[str, str]:
        """Return the status of each number by field."""
        return {value.path: value.status for value in self.values}


def material(name: str) -> Material:
    """Return a material of grains or walls by its catalog name.

    Raises InputError naming the nearest, as the others do.
    """
    entry = entry_of("material", name)
    return Material(name=name, label=entry.words["label"], values=entry.values, **entry.numbers())


def exciter(name: str) -> Exciter:
    """Return an exciter by its catalog name."""
    return Exciter(name=name, **entry_of("exciter", name).numbers())


def transducer(
    name: str, quantity: Literal["force", "acceleration", "voltage", "current"] | None = None
) -> TransducerSpec:
    """Return a transducer by its catalog name.

    Raises InputError where it does not measure `quantity`, if given.

    "ideal", a transducer without any error, needs the quantity.
    """
    from daq.chain.channel import TransducerSpec, ideal_transducer

    if name == IDEAL and quantity is not None:
        return ideal_transducer(quantity)
    entry = entry_of("transducer", name)
    measures = entry.words["quantity"]
    if quantity not in (None, measures):
        fit = ", ".join([IDEAL, *sensors_for(str(quantity))])
        raise InputError(
            Mistake("", "", f"the transducer {quote(name)}, which measures {measures}", fit)
        )
    kind: Any = measures
    return TransducerSpec(
        name, kind, _SENSOR_UNITS[measures], statuses=entry.statuses(), **entry.numbers()
    )


def sensors_for(quantity: str) -> list[str]:
    """Return the names of the transducers that measure a quantity."""
    return [
        name for name, entry in shelf("transducer").items() if entry.words["quantity"] == quantity
    ]


def analyzer(name: str) -> AnalyzerSpec:
    """Return an analyzer by its catalog name; "ideal" has no noise, gain or clock error."""
    from daq.chain.channel import AnalyzerSpec, ideal_analyzer

    if name == IDEAL:
        return ideal_analyzer()
    entry = entry_of("analyzer", name)
    numbers = entry.numbers()
    numbers |= {field: int(numbers[field]) for field in ("oversampling", "bits", "channels")}
    return AnalyzerSpec(name, statuses=entry.statuses(), **numbers)


def names(kind: str) -> tuple[str, ...]:
    """Return the catalog's names of one kind."""
    return tuple(shelf(kind))


def entry_of(kind: str, name: str) -> Entry:
    """Return an entry by name. Raises InputError where there is none."""
    entries = shelf(kind)
    if name not in entries:
        known = [*entries, IDEAL] if kind in ("transducer", "analyzer") else list(entries)
        raise InputError(
            Mistake("", "", f"the {kind} {quote(name)}", ", ".join(known), nearest(name, known))
        )
    return entries[name]


@cache
def shelf(kind: str) -> dict[str, Entry]:
    """Return every entry of one kind.

    Read once: the files belong to the package and do not change while it runs.
    """
    path = HERE / f"{kind}s.yaml"
    notes = Notes()
    root = read_yaml(read_file(path), path.name, notes.mistakes)
    document = Keys(
        {"schema": Text((SCHEMA,))}, groups={NAME: Then(_shape(kind), _entry)}, closed=True
    )
    found: dict[str, Any] = read_document(document, root, notes)
    return {name: entry for name, entry in found.items() if name != "schema"}


def _entry(parts: dict[str, Any], _node: Node, path: str, _notes: Notes) -> Entry:
    words = {key: part for key, part in parts.items() if isinstance(part, str)}
    values = (part for part in parts.values() if isinstance(part, CatalogValue))
    return Entry(
        words, tuple(replace(value, path=value.path.removeprefix(f"{path}.")) for value in values)
    )


def _shape(kind: str) -> Shape:
    if kind == "transducer":
        return Choice("quantity", {quantity: _transducer(quantity) for quantity in _SENSOR_UNITS})
    if kind == "material":
        return Keys({"label": Text(), **needed_numbers()}, contact_numbers(), closed=True)
    fields = {"exciter": stated_fields(Exciter), "analyzer": _ANALYZER}
    return Keys({"label": Text(), **fields[kind]}, closed=True)


_ANALYZER = {
    "rates": StatedNumber(Quantity("rate", 0.0, 1e9, above=True), many=True),
    "oversampling": StatedNumber(_COUNT),
    "bits": StatedNumber(Quantity("number", 8.0, 32.0)),
    "ranges": StatedNumber(Quantity("voltage", 0.0, 1000.0, above=True), many=True),
    "noise_rms": StatedNumber(Quantity("voltage", 0.0, 1.0)),
    "gain_tolerance": StatedNumber(_RELATIVE),
    "clock_ppm": StatedNumber(Quantity("ppm", 0.0, 1e5)),
    "channels": StatedNumber(_COUNT),
    "ac_corner": StatedNumber(Quantity("frequency", 0.0, 1e3, above=True)),
    "ac_tolerance": StatedNumber(_RELATIVE),
    "skew": StatedNumber(Quantity("delay", 0.0, 1e-6)),
}


def _transducer(quantity: str) -> Keys:
    spots = StatedNumber(Quantity("acceleration noise", 0.0, 1e6, above=True), many=True)
    needed = {
        "sensitivity": StatedNumber(Quantity(f"{quantity} sensitivity", 0.0, 1e6, above=True)),
        "full_scale": StatedNumber(Quantity(quantity, 0.0, 1e9, above=True)),
        "time_constant": StatedNumber(Quantity("time", 0.0, 1e9, above=True, null=True)),
        "time_constant_spread": StatedNumber(_RELATIVE),
        "noise_rms": StatedNumber(Quantity(quantity, 0.0, 1e6)),
        "noise_bandwidth": StatedNumber(Quantity("frequency", 0.0, 1e9, above=True)),
        "calibration_U": StatedNumber(_RELATIVE),
    }
    maybe = {
        "linearity": StatedNumber(_RELATIVE),
        "resonance": StatedNumber(Quantity("frequency", 0.0, 1e9, above=True)),
        "resonance_damping": StatedNumber(Quantity("number", 0.0, 0.9, above=True)),
        "clips_at": StatedNumber(Quantity("voltage", 0.0, 1000.0, above=True)),
        **({"noise_spots": spots} if quantity == "acceleration" else {}),
    }
    return Keys({"label": Text(), "quantity": Text(), **needed}, maybe, closed=True)
