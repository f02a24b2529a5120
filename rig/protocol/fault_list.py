"""The list `faults:` of a protocol: read strictly, written back, and checked against the runs that it is for."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from rig.documents.decode import Notes, Unreadable, describe, fill, plain
from rig.documents.nodes import Node
from rig.errors import Mistake
from rig.protocol.faults import SIZES, Fault

if TYPE_CHECKING:
    from rig.protocol.spec import Condition, Protocol


def read_faults(node: Node, notes: Notes) -> tuple[Fault, ...]:
    """The faults of a list node; what is wrong with one is noted and the rest is read."""
    if not isinstance(node.value, tuple):
        raise notes.reject(node.where, "faults", describe(node), "a list of faults")
    found = []
    for number, item in enumerate(node.value, start=1):
        path = f"faults[{number}]"
        try:
            fault = fill(Fault, item, path, notes)
        except Unreadable:
            continue
        _check_size(fault, item, path, notes)
        found.append(fault)
    return tuple(found)


def plain_faults(faults: Iterable[Fault]) -> list[dict[str, Any]]:
    """The faults as plain data that read_faults takes back; what is left out stays out."""
    every = (plain(Fault, fault) for fault in faults)
    return [{name: value for name, value in fault.items() if value is not None} for fault in every]


def misplaced(protocol: Protocol, conditions: Sequence[Condition], notes: Notes) -> list[Mistake]:
    """Faults that no run of these conditions would ever show."""
    longest = max((c.acquire.settle + c.acquire.record for c in conditions), default=0)
    exciter = any(c.acquire.exciter_channels for c in conditions)
    found = []
    for number, fault in enumerate(protocol.faults, start=1):
        path = f"faults[{number}]"
        if fault.start >= longest:
            allowed = f"before the end of the longest run, {longest} cycles"
            found.append(Mistake(notes.place_of(f"{path}.start"), f"{path}.start", f"{fault.start:g}", allowed))
        if fault.channel in ("current", "voltage") and not exciter:
            allowed = "force, acceleration; current and voltage with acquire.exciter_channels: true"
            found.append(Mistake(notes.place_of(f"{path}.channel"), f"{path}.channel", fault.channel, allowed))
        if fault.repeat is not None and fault.repeat > protocol.repeats.n:
            allowed = f"at most {protocol.repeats.n}, the repeats"
            found.append(Mistake(notes.place_of(f"{path}.repeat"), f"{path}.repeat", f"{fault.repeat}", allowed))
    return found


def _check_size(fault: Fault, node: Node, path: str, notes: Notes) -> None:
    """Note a size that the kind of fault does not have, lacks or cannot take."""
    full, quantity = f"{path}.size", SIZES.get(fault.kind)
    entry = node.value.get("size", node) if isinstance(node.value, dict) else node
    if full in notes.failed:
        return
    if quantity is None:
        if fault.size:
            notes.reject(entry.where, full, f"{fault.size:g}", f"no size: {fault.kind} has none")
    elif not fault.size or not quantity.holds(fault.size) or (fault.kind == "clock_slip" and fault.size % 1):
        what = "whole samples" if fault.kind == "clock_slip" else "not 0"
        notes.reject(entry.where, full, f"{fault.size:g}", f"{quantity.range()}, {what}, for {fault.kind}")
