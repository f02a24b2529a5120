"""The laws that every implementation of `Acquisition` must keep. A new implementation joins by one line
in MAKERS.
"""

import atexit
import shutil
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from daq.chain.acquisition import Acquisition, Emulated
from daq.chain.block import Block, Flag
from daq.chain.channel import AnalyzerSpec, Channel, TransducerSpec, channel_info, draw_state
from daq.chain.frontend import FrontEnd
from daq.chain.replay import Replayed
from daq.chain.transducer import Transduced
from daq.faults.in_blocks import KINDS, BlockFault, Faulted
from daq.random_streams import stream
from daq.session.plan import RunPlan, SessionPlan
from daq.session.record import Record, open_session
from daq.session.writer import Recorder

RATE = 10240.0
ANALYZER = AnalyzerSpec("INV-3118", (RATE,))
CHANNELS = (
    Channel(
        "force",
        TransducerSpec("208C03", "force", "N", 2.248e-3, 2200.0, 2000.0, 0.1, 0.02, 1e4, 0.01),
        0.1,
        "",
        "+x",
    ),
    Channel(
        "acceleration",
        TransducerSpec(
            "352C33", "acceleration", "m/s^2", 0.0102, 490.0, 1.6, 0.1, 1.5e-3, 1e4, 0.01
        ),
        0.1,
        "",
        "+x",
    ),
)


class Shaking:
    """Force and acceleration of a 20 Hz drive; the force overloads the 0.1 V range near its crests."""

    names = ("force", "acceleration")
    rate = 8 * RATE

    def __init__(self) -> None:
        self._next = 0

    def read(self, n: int) -> np.ndarray:
        t = (np.arange(self._next, self._next + n) + 0.5) / self.rate
        self._next += n
        wave = np.sin(2 * np.pi * 20.0 * t)
        return np.stack([50.0 * wave, -5.0 * wave])


def emulated() -> Emulated:
    states = [
        draw_state(channel, ANALYZER, stream(7, "instrument", channel.name)) for channel in CHANNELS
    ]
    noise = [stream(7, "condition", "1", channel.name) for channel in CHANNELS]
    return Emulated(
        Transduced(Shaking(), states), FrontEnd(ANALYZER, CHANNELS, states, RATE, noise)
    )


PIECES = [50] * 20 + [4096] * 12
"""Sizes of the recorded blocks: small ones where the settling ends, then larger ones, 50152 samples
in all.
"""


@cache
def recorded() -> Record:
    """The emulated acquisition, recorded in PIECES."""
    acquisition = emulated()
    table = tuple(channel_info(channel, ANALYZER, RATE, 38.9375) for channel in CHANNELS)
    run = RunPlan("run_0001", "c01", 1, 1, sum(PIECES), 0, len(PIECES))
    path = Path(tempfile.mkdtemp()) / "session.h5"
    with Recorder.create(
        path, SessionPlan(RATE, table, (run,), ({"id": "c01"},), "", {})
    ) as recorder:
        for size in PIECES:
            recorder.append("run_0001", acquisition.read(size))
        recorder.finish("run_0001", {})
    record = open_session(path)
    atexit.register(shutil.rmtree, path.parent)
    atexit.register(record.close)
    return record


def replayed() -> Replayed:
    return Replayed(recorded(), "run_0001")


def faulted() -> Faulted:
    """One fault of every kind, over the first 20000 samples and across each other."""
    faults = [
        BlockFault(
            kind, k % 2, 300 + 1900 * k, 2500 + 1900 * k, 3.0 if kind == "clock_slip" else 0.01
        )
        for k, kind in enumerate(KINDS)
    ]
    noise = [stream(7, "fault", kind) for kind in KINDS]
    return Faulted(emulated(), faults, noise, (4.0, 4.0), (True, False))


MAKERS = {"emulated": emulated, "faulted": faulted, "replayed": replayed}


@pytest.fixture(params=MAKERS.values(), ids=MAKERS.keys())
def make(request: pytest.FixtureRequest) -> Callable[[], Acquisition]:
    return request.param


def joined(blocks: list[Block]) -> np.ndarray:
    return np.concatenate([block.codes for block in blocks], axis=1)


def test_it_is_an_acquisition(make: Callable[[], Acquisition]) -> None:
    acquisition = make()
    assert isinstance(acquisition, Acquisition)
    assert acquisition.channels == ("force", "acceleration")
    assert acquisition.rate == RATE


def test_a_block_is_well_formed(make: Callable[[], Acquisition]) -> None:
    block = make().read(1000)
    assert (block.start, block.count) == (0, 1000)
    assert (block.codes.shape, block.codes.dtype) == ((2, 1000), np.int32)
    assert (block.flags.shape, block.flags.dtype) == ((2,), np.uint16)
    assert (block.clipped.shape, block.clipped.dtype) == ((2,), np.uint32)


def test_blocks_follow_each_other_without_a_gap(make: Callable[[], Acquisition]) -> None:
    acquisition = make()
    sizes = [1, 511, 512, 5120, 6000]
    assert [acquisition.read(n).start for n in sizes] == [0, 1, 512, 1024, 6144]


@settings(max_examples=20, deadline=None)
@given(cuts=st.lists(st.integers(1, 7000), min_size=1, max_size=6))
def test_codes_do_not_depend_on_how_they_are_read(cuts: list[int]) -> None:
    for make in MAKERS.values():
        cut, whole = make(), make()
        blocks = [cut.read(n) for n in cuts]
        one = whole.read(sum(cuts))
        np.testing.assert_array_equal(joined(blocks), one.codes)
        np.testing.assert_array_equal(
            sum(block.clipped.astype(int) for block in blocks), one.clipped
        )
        np.testing.assert_array_equal(
            np.bitwise_or.reduce([block.flags for block in blocks]), one.flags
        )


def test_a_block_is_not_changed_by_later_reads(make: Callable[[], Acquisition]) -> None:
    acquisition = make()
    block = acquisition.read(700)
    before = block.codes.copy()
    acquisition.read(20000)
    np.testing.assert_array_equal(block.codes, before)


def test_equal_seeds_give_equal_codes(make: Callable[[], Acquisition]) -> None:
    np.testing.assert_array_equal(make().read(6000).codes, make().read(6000).codes)


def test_overload_is_a_code_at_the_rail(make: Callable[[], Acquisition]) -> None:
    acquisition = make()
    seen = 0
    for _ in range(100):
        block = acquisition.read(64)
        high, low = block.codes == 2**23 - 1, block.codes == -(2**23)
        assert np.array_equal(block.clipped, (high | low).sum(axis=1))
        assert np.array_equal(block.flags & Flag.OVERLOAD_HI != 0, high.any(axis=1))
        assert np.array_equal(block.flags & Flag.OVERLOAD_LO != 0, low.any(axis=1))
        seen |= int(block.flags[0])
    assert seen & Flag.OVERLOAD_HI
    assert seen & Flag.OVERLOAD_LO


def test_settling_is_marked_and_ends(make: Callable[[], Acquisition]) -> None:
    acquisition = make()
    blocks = [acquisition.read(50) for _ in range(8)]
    settling = [block.settling for block in blocks]
    assert settling == sorted(settling, reverse=True)
    assert settling[-1] is False
    assert [bool(block.flags[0] & Flag.NOT_SETTLED) for block in blocks] == settling


@pytest.mark.parametrize("n", [0, -1])
def test_reading_nothing_is_an_error(make: Callable[[], Acquisition], n: int) -> None:
    with pytest.raises(ValueError, match="samples"):
        make().read(n)
