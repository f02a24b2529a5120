"""Each fault does what it says, to its own channel and samples, and sets the bits that a converter
would.
"""

import numpy as np
import pytest
from daq_signals import Analytic, front_end, tone

from daq.chain.acquisition import Emulated
from daq.chain.block import Block, Flag
from daq.faults.in_blocks import FULL, KINDS, BlockFault, Faulted

START, STOP, N = 1000, 1600, 3000


def clean() -> Emulated:
    return Emulated(Analytic(tone(4.0, 0.003), tone(2.0, 0.003, 1.0)), front_end(2))


def block(kind: str, size: float = 0.0, stop: int = STOP, iepe: bool = False) -> Block:
    fault = BlockFault(kind, 1, START, stop, size)
    return Faulted(clean(), [fault], [np.random.default_rng(1)], (4.0, 4.0), (False, iepe)).read(N)


@pytest.mark.parametrize("kind", KINDS)
def test_the_other_channel_and_the_other_samples_pass(kind: str) -> None:
    found, whole = block(kind, 2.0 if kind == "clock_slip" else 0.01), clean().read(N)
    np.testing.assert_array_equal(found.codes[0], whole.codes[0])
    np.testing.assert_array_equal(found.codes[1, :START], whole.codes[1, :START])
    np.testing.assert_array_equal(found.codes[1, STOP:], whole.codes[1, STOP:])
    assert np.any(found.codes[1, START:STOP] != whole.codes[1, START:STOP])
    assert found.flags[0] == whole.flags[0]


def test_the_codes_of_each_fault() -> None:
    before = clean().read(N).codes[1].astype(float)
    part = slice(START, STOP)
    one = before[part]
    place = np.arange(STOP - START)
    rounding = 0.5 + 1e-6
    for kind, size, expected in (
        ("dropout", 0.0, np.zeros(STOP - START)),
        ("stuck", 0.0, np.full(STOP - START, before[START - 1])),
        ("bias", 0.01, one + 0.01 * FULL),
        ("spike", -0.02, one - 0.02 * FULL),
        ("drift", 0.01, one + 0.01 * FULL * place / (STOP - START)),
        ("gain_step", 0.05, 1.05 * one),
        ("clock_slip", 3.0, before[START - 3 : STOP - 3]),
    ):
        found = block(kind, size).codes[1, part]
        assert np.abs(found - expected).max() <= rounding, kind


def test_noise_has_its_size() -> None:
    added = block("noise", 0.001).codes[1, START:STOP] - clean().read(N).codes[
        1, START:STOP
    ].astype(float)
    assert added.std() == pytest.approx(0.001 * FULL, rel=5 / np.sqrt(2 * added.size))
    open_input = block("cable_open").codes[1, START:STOP]
    assert open_input.std() == pytest.approx(
        np.hypot(4.0, 1 / np.sqrt(12)), rel=5 / np.sqrt(2 * open_input.size)
    )


def test_the_converter_flags_lost_samples_and_an_open_sensor_only() -> None:
    known = {"dropout": Flag.GAP, "cable_open": Flag.IEPE_OPEN}
    for kind in KINDS:
        found = block(kind, 2.0 if kind == "clock_slip" else 0.01, iepe=True)
        assert found.flags[1] & ~Flag.NOT_SETTLED == known.get(kind, 0), kind
    assert (
        not block("cable_open").flags[1] & Flag.IEPE_OPEN
    )  # an input that feeds nothing cannot tell


def test_what_is_pushed_to_the_rail_is_overload() -> None:
    found = block("bias", 1.5)
    assert found.flags[1] & Flag.OVERLOAD_HI
    assert found.clipped[1] == np.count_nonzero(found.codes[1] == FULL - 1) == STOP - START
    assert not found.flags[0] & Flag.OVERLOAD_HI


def test_bits_stand_in_the_blocks_that_the_fault_touches() -> None:
    fault = BlockFault("dropout", 0, 1000, 1100)
    acquisition = Faulted(clean(), [fault], [np.random.default_rng(1)], (0.0, 0.0), (False, False))
    gaps = [bool(acquisition.read(500).flags[0] & Flag.GAP) for _ in range(6)]
    assert gaps == [False, False, True, False, False, False]


def test_an_unknown_fault_is_refused() -> None:
    with pytest.raises(ValueError, match="there are dropout"):
        block("gremlin")
