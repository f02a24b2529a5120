"""A triggered record begins where it should, whatever the sizes of the reads, and is the same
samples all the same.
"""

from collections.abc import Sequence

import numpy as np
import pytest
from daq_signals import RATE, Analytic, front_end, tone
from hypothesis import given, settings
from hypothesis import strategies as st

from daq.chain.acquisition import Acquisition, Emulated
from daq.chain.trigger import ARMED, NoTrigger, Triggered

FULL = 2**23
PERIOD = 400


def plain() -> Emulated:
    return Emulated(Analytic(tone(4.0, 1 / PERIOD), tone(2.0, 1 / PERIOD, 1.0)), front_end(2))


def triggered(**how: object) -> Triggered:
    return Triggered(plain(), **{"row": 0, "level": 0.1 * FULL, **how})  # type: ignore[arg-type]


WHOLE = plain().read(40000).codes


@pytest.mark.parametrize("slope", ["rising", "falling"])
@pytest.mark.parametrize("kind", ["edge", "level"])
@pytest.mark.parametrize("before", [0, 1, 77, 500, 5000])
@pytest.mark.parametrize("row", [0, 1])
def test_it_begins_at_the_first_sample_that_passes(
    slope: str, kind: str, before: int, row: int
) -> None:
    source = triggered(row=row, slope=slope, kind=kind, before=before)
    block = source.read(1000)
    assert source.first is not None
    at = source.first + before
    beyond = WHOLE[row] > 0.1 * FULL if slope == "rising" else WHOLE[row] < 0.1 * FULL
    hits = beyond & ~np.concatenate(([True], beyond[:-1])) if kind == "edge" else beyond
    armed = max(ARMED, before)
    assert at == armed + np.flatnonzero(hits[armed:])[0]
    assert block.start == 0
    np.testing.assert_array_equal(block.codes, WHOLE[:, source.first : source.first + 1000])


@settings(max_examples=30, deadline=None)
@given(cuts=st.lists(st.integers(1, 3000), min_size=1, max_size=8))
def test_reads_of_any_size_give_the_same(cuts: Sequence[int]) -> None:
    cut, whole = triggered(before=300), triggered(before=300)
    blocks = [cut.read(n) for n in cuts]
    np.testing.assert_array_equal(
        np.concatenate([b.codes for b in blocks], axis=1), whole.read(sum(cuts)).codes
    )
    assert [b.start for b in blocks] == np.cumsum([0, *cuts[:-1]]).tolist()


def test_overload_is_counted_in_the_samples_that_are_handed_on() -> None:
    loud = Emulated(Analytic(tone(11.0, 1 / PERIOD)), front_end())
    source = Triggered(loud, 0, 0.0)
    for _ in range(20):
        block = source.read(64)
        assert block.clipped[0] == np.count_nonzero(
            (block.codes == FULL - 1) | (block.codes == -FULL)
        )
        assert bool(block.flags[0] & 3) == bool(block.clipped[0])


def test_a_level_that_is_not_passed_ends_the_waiting() -> None:
    with pytest.raises(NoTrigger, match="5000 samples"):
        triggered(level=0.9 * FULL, patience=5000).read(10)


def test_it_is_an_acquisition() -> None:
    source = triggered()
    assert isinstance(source, Acquisition)
    assert (source.channels, source.rate) == (("a", "b"), RATE)
    with pytest.raises(ValueError, match="0 samples"):
        source.read(0)
    with pytest.raises(ValueError, match="before a trigger"):
        triggered(before=-1)
