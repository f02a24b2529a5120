"""The catalog's own files: materials, exciters, transducers, analyzers, each entry a set of numbers
with their origins.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from rig.catalog.entries import CatalogValue, Exciter, Material
from rig.catalog.stated_values import Wanted, read_all, wanted_by
from rig.documents.decode import Notes, entries_of, word_of
from rig.documents.nodes import Node
from rig.documents.yaml_reader import read_file, read_yaml
from rig.errors import InputError, Mistake, nearest, quote
from rig.units import Quantity

if TYPE_CHECKING:
    from daq.chain.channel import AnalyzerSpec, TransducerSpec

HERE = Path(__file__).parent
SCHEMA = "rig/catalog/1"
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
    """Return a grain material by its catalog name.

    Raises InputError naming the nearest, as the others do.
    """
    entry = entry_of("material", name)
    return Material(name=name, label=entry.words["label"], **entry.numbers())


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
        raise InputError(Mistake("", "", f"the transducer {quote(name)}, which measures {measures}", fit))
    kind: Any = measures
    return TransducerSpec(name, kind, _SENSOR_UNITS[measures], statuses=entry.statuses(), **entry.numbers())


def sensors_for(quantity: str) -> list[str]:
    """Return the names of the transducers that measure a quantity."""
    return [name for name, entry in shelf("transducer").items() if entry.words["quantity"] == quantity]


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
        raise InputError(Mistake("", "", f"the {kind} {quote(name)}", ", ".join(known), nearest(name, known)))
    return entries[name]


@cache
def shelf(kind: str) -> dict[str, Entry]:
    """Return every entry of one kind.

    Read once: the files belong to the package and do not change while it runs.
    """
    path = HERE / f"{kind}s.yaml"
    notes = Notes()
    root = read_yaml(read_file(path), path.name, notes.mistakes)
    found = {}
    for name, node in root.value.items() if isinstance(root.value, dict) else ():
        if name != "schema":
            found[name] = _entry(kind, name, node, notes)
    if notes.mistakes:
        raise InputError(*notes.mistakes)
    return found


def _entry(kind: str, name: str, node: Node, notes: Notes) -> Entry:
    """Return one entry of a file; mistakes are noted."""
    # The quantity of a transducer decides the units of its other fields, so it is read first.
    word_names = ("label", "quantity") if kind == "transducer" else ("label",)
    quantity = node.value["quantity"].text if kind == "transducer" and isinstance(node.value, dict) else ""
    wanted = _wanted(kind, quantity)
    entries = entries_of(node, name, (*word_names, *wanted), notes)
    words = {word: word_of(entries[word], f"{name}.{word}", (), notes) for word in word_names}
    values = read_all(entries, wanted, "", notes)
    missing = sorted({name for name, want in wanted.items() if want.needed} - {value.path for value in values})
    if missing:
        notes.reject(node.where, name, f"no {', '.join(missing)}", "every field")
    return Entry(words, tuple(values))


def _wanted(kind: str, quantity: str) -> dict[str, Wanted]:
    """Return the number fields of a kind, with their quantities and limits."""
    if kind == "material":
        return wanted_by(Material)
    if kind == "exciter":
        return wanted_by(Exciter)
    if kind == "analyzer":
        return {
            "rates": Wanted(Quantity("rate", 0.0, 1e9, above=True), "many"),
            "oversampling": Wanted(_COUNT),
            "bits": Wanted(Quantity("number", 8.0, 32.0)),
            "ranges": Wanted(Quantity("voltage", 0.0, 1000.0, above=True), "many"),
            "noise_rms": Wanted(Quantity("voltage", 0.0, 1.0)),
            "gain_tolerance": Wanted(_RELATIVE),
            "clock_ppm": Wanted(Quantity("ppm", 0.0, 1e5)),
            "channels": Wanted(_COUNT),
            "ac_corner": Wanted(Quantity("frequency", 0.0, 1e3, above=True)),
            "ac_tolerance": Wanted(_RELATIVE),
            "skew": Wanted(Quantity("delay", 0.0, 1e-6)),
        }
    spots = Wanted(Quantity("acceleration noise", 0.0, 1e6, above=True), "many", needed=False)
    return {
        "sensitivity": Wanted(Quantity(f"{quantity} sensitivity", 0.0, 1e6, above=True)),
        "full_scale": Wanted(Quantity(quantity, 0.0, 1e9, above=True)),
        "time_constant": Wanted(Quantity("time", 0.0, 1e9, above=True), "maybe"),
        "time_constant_spread": Wanted(_RELATIVE),
        "noise_rms": Wanted(Quantity(quantity, 0.0, 1e6)),
        "noise_bandwidth": Wanted(Quantity("frequency", 0.0, 1e9, above=True)),
        "calibration_U": Wanted(_RELATIVE),
        "linearity": Wanted(_RELATIVE, needed=False),
        "resonance": Wanted(Quantity("frequency", 0.0, 1e9, above=True), needed=False),
        "resonance_damping": Wanted(Quantity("number", 0.0, 0.9, above=True), needed=False),
        "clips_at": Wanted(Quantity("voltage", 0.0, 1000.0, above=True), needed=False),
        **({"noise_spots": spots} if quantity == "acceleration" else {}),
    }
