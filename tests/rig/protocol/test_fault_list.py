"""Faults in a protocol: read strictly, written back, told where they cannot be."""

import pytest

from daq.documents.classes import keys_of
from daq.faults.in_blocks import KINDS
from rig.errors import InputError
from rig.protocol.faults import Fault
from rig.protocol.grid import conditions
from rig.protocol.load import dump_protocol, load_protocol
from rig.protocol.spec import Protocol

PLAIN = "schema: rig/protocol/1\nname: x\nrepeats: 2\n"


def test_the_kinds_are_those_of_the_acquisition() -> None:
    assert keys_of(Fault).every()["kind"].words == KINDS


def test_a_list_is_read_and_written_back() -> None:
    text = PLAIN + (
        "faults:\n"
        "  - {kind: bias, channel: acceleration, start: 20 cycles, duration: 5 cycles, size: 1 %}\n"
        "  - {kind: dropout, channel: force, start: 12.5, duration: 0.1, repeat: 2}\n"
        "  - {kind: clock_slip, channel: force, start: 0, size: 3}\n"
    )
    protocol = load_protocol(text)
    assert protocol.faults == (
        Fault("bias", "acceleration", 20.0, 5.0, 0.01),
        Fault("dropout", "force", 12.5, 0.1, repeat=2),
        Fault("clock_slip", "force", 0.0, size=3.0),
    )
    assert load_protocol(dump_protocol(protocol)) == protocol
    assert conditions(Protocol("x", faults=protocol.faults[:1]))


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("{kind: dropot, channel: force, start: 12}", "did you mean 'dropout'?"),
        ("{kind: dropout, channel: forse, start: 12}", "did you mean 'force'?"),
        ("{kind: dropout, chanel: force, start: 12}", "did you mean 'channel'?"),
        ("{kind: dropout, channel: force}", "no start"),
        ("{kind: dropout, channel: force, start: 12 mm}", "units cycles"),
        ("{kind: dropout, channel: force, start: 60}", "the longest run, 50 cycles"),
        ("{kind: dropout, channel: force, start: 12, size: 1 %}", "dropout has none"),
        ("{kind: bias, channel: force, start: 12}", "not 0, for bias"),
        ("{kind: noise, channel: force, start: 12, size: -0.1}", "above 0"),
        ("{kind: clock_slip, channel: force, start: 12, size: 1.5}", "whole samples"),
        ("{kind: bias, channel: current, start: 12, size: 0.1}", "exciter_channels"),
        ("{kind: stuck, channel: force, start: 12, repeat: 3}", "at most 2"),
        ("stuck", "a mapping"),
    ],
)
def test_mistakes_are_reported_with_their_place(fault: str, words: str) -> None:
    with pytest.raises(InputError) as caught:
        load_protocol(PLAIN + f"faults:\n  - {fault}\n")
    mistake = caught.value.mistakes[0]
    assert len(caught.value.mistakes) == 1 + (
        "chanel" in fault
    )  # a key of another name is a missing one, too
    assert words in str(caught.value)
    assert mistake.where.startswith("protocol:5")
    assert mistake.field.startswith("faults[1]")


def test_a_value_that_is_not_a_list_is_reported() -> None:
    with pytest.raises(InputError, match="a list of faults"):
        load_protocol(PLAIN + "faults: {kind: stuck}\n")


def test_a_fault_built_in_python_is_checked_too() -> None:
    with pytest.raises(InputError, match="for bias"):
        conditions(Protocol("x", faults=(Fault("bias", "force", 1.0),)))
