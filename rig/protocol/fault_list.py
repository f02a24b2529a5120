"""Read the list `faults:` of a protocol, write it back, and check it against the protocol's runs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, get_args

from daq.documents.classes import keys_of
from daq.documents.notes import Node, Notes
from daq.documents.shapes import List, Then, plain
from rig.errors import Mistake
from rig.protocol.faults import SIZES, Fault, Kind

if TYPE_CHECKING:
    from rig.protocol.spec import Condition, Protocol

FAULT_KINDS = get_args(Kind)


def faults_shape() -> List:
    """Return the shape of `faults`."""
    return List(
        Then(keys_of(Fault), _check_size, {"allOf": [_rule(kind) for kind in FAULT_KINDS]}),
        what="faults",
    )


def plain_faults(faults: Iterable[Fault]) -> list[dict[str, Any]]:
    """Return the faults as plain data, without fields that are None."""
    every = (plain(keys_of(Fault), fault) for fault in faults)
    return [{name: value for name, value in fault.items() if value is not None} for fault in every]


def misplaced(protocol: Protocol, conditions: Sequence[Condition], notes: Notes) -> list[Mistake]:
    """Return a mistake for each fault that would happen in no run: too late, on a channel that is
    not recorded, or in a repeat that is not made.
    """
    longest = max((c.acquire.settle + c.acquire.record for c in conditions), default=0)
    exciter = any(c.acquire.exciter_channels for c in conditions)
    found = []
    for number, fault in enumerate(protocol.faults, start=1):
        path = f"faults[{number}]"
        if fault.start >= longest:
            allowed = f"before the end of the longest run, {longest} cycles"
            found.append(
                Mistake(
                    notes.place_of(f"{path}.start"), f"{path}.start", f"{fault.start:g}", allowed
                )
            )
        if fault.channel in ("current", "voltage") and not exciter:
            allowed = "force, acceleration; current and voltage with acquire.exciter_channels: true"
            found.append(
                Mistake(
                    notes.place_of(f"{path}.channel"), f"{path}.channel", fault.channel, allowed
                )
            )
        if fault.repeat is not None and fault.repeat > protocol.repeats.n:
            allowed = f"at most {protocol.repeats.n}, the repeats"
            found.append(
                Mistake(
                    notes.place_of(f"{path}.repeat"), f"{path}.repeat", f"{fault.repeat}", allowed
                )
            )
    return found


def _check_size(fault: Fault, node: Node, path: str, notes: Notes) -> Fault:
    """Note a size that is missing, out of range, or given for a kind of fault without a size."""
    full, quantity = f"{path}.size", SIZES.get(fault.kind)
    entry = node.value.get("size", node) if isinstance(node.value, dict) else node
    if full in notes.failed:
        return fault
    if quantity is None:
        if fault.size:
            notes.reject(entry.where, full, f"{fault.size:g}", f"no size: {fault.kind} has none")
    elif not fault.size or not quantity.holds(fault.size) or (quantity.whole and fault.size % 1):
        what = "whole samples" if quantity.whole else "not 0"
        notes.reject(
            entry.where, full, f"{fault.size:g}", f"{quantity.range()}, {what}, for {fault.kind}"
        )
    return fault


def _rule(kind: str) -> dict[str, Any]:
    """Return the check of `_check_size` for one kind as a JSON Schema rule."""
    then: dict[str, Any] = {"properties": {"size": {"enum": [0, "0"]}}}
    if kind in SIZES:
        then = {
            "properties": {"size": {**SIZES[kind].schema({}), "not": {"const": 0}}},
            "required": ["size"],
        }
    return {"if": {"properties": {"kind": {"const": kind}}, "required": ["kind"]}, "then": then}
