"""The checks of a protocol file for a protocol that was built in Python."""

from __future__ import annotations

from contextlib import suppress

from rig.axes import plain_axes, read_axes
from rig.errors import InputError
from rig.expect import plain_expect, read_expect
from rig.faultlist import plain_faults, read_faults
from rig.scene import Protocol
from rig.strict import Notes, Unreadable, grammar, plain, value_of
from rig.tree import node_of

CHECKED = ("scene", "drive", "acquire", "repeats", "seed", "mistake", "fidelity", "tolerance")


def verify(protocol: Protocol) -> None:
    """Raise InputError for every value that a protocol file could not hold."""
    notes = Notes()
    for name in CHECKED:
        annotation = grammar(Protocol)[name]
        try:
            value_of(annotation, node_of(plain(annotation, getattr(protocol, name))), name, notes)
        except Unreadable:
            continue
    read_axes(node_of(plain_axes(protocol.vary)), notes)
    with suppress(Unreadable):
        read_expect(node_of([plain_expect(claim) for claim in protocol.expect]), notes)
    with suppress(Unreadable):
        read_faults(node_of(plain_faults(protocol.faults)), notes)
    if notes.mistakes:
        raise InputError(*notes.mistakes)
