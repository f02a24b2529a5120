"""Faults between stand and transducer: what each does, whatever the sizes of the reads; other
channels pass.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from daq.chain.source import FloatArray, PhysicalSource
from daq.faults.in_sources import AcCoupled, Drifting, Late, Offset

RATE, TONE = 4096.0, 8.0


class Sines:
    """Two sines of TONE Hz, a quarter of a cycle apart, at the middles of the intervals."""

    names = ("force", "acceleration")
    rate = RATE

    def __init__(self) -> None:
        self._next = 0

    def read(self, n: int) -> FloatArray:
        phase = 2 * np.pi * TONE * (np.arange(self._next, self._next + n) + 0.5) / RATE
        self._next += n
        return np.stack([np.cos(phase), np.sin(phase)])


FAULTS: dict[str, Callable[[PhysicalSource], PhysicalSource]] = {
    "AC": lambda source: AcCoupled(source, (0.5, 0.55)),
    "late": lambda source: Late(source, 1, 24),
    "drifting": lambda source: Drifting(source, 1, 1e-3),
    "offset": lambda source: Offset(source, 1, 0.25),
}


def lead(signal: FloatArray, reference: FloatArray) -> float:
    """Phase of a signal over whole cycles before that of another, rad."""
    turn = np.exp(-2j * np.pi * TONE * np.arange(signal.size) / RATE)
    return float(np.angle((signal * turn).sum() / (reference * turn).sum()))


@pytest.mark.parametrize("fault", FAULTS)
@given(cuts=st.lists(st.integers(1, 700), min_size=1, max_size=8))
def test_reads_of_any_size_give_the_same(fault: str, cuts: Sequence[int]) -> None:
    source, whole = FAULTS[fault](Sines()), FAULTS[fault](Sines())
    parts = [source.read(n).copy() for n in cuts]
    assert np.array_equal(np.concatenate(parts, axis=1), whole.read(sum(cuts)))


@pytest.mark.parametrize("fault", ["late", "drifting", "offset"])
def test_the_other_channel_passes_and_the_source_stays(fault: str) -> None:
    clean = Sines().read(5000)
    assert np.array_equal(FAULTS[fault](Sines()).read(5000)[0], clean[0])
    assert FAULTS[fault](Sines()).names == Sines.names
    assert FAULTS[fault](Sines()).rate == RATE


def test_late_is_late_and_offset_an_offset() -> None:
    clean = Sines().read(3000)[1]
    late, offset = (FAULTS[name](Sines()).read(3000)[1] for name in ("late", "offset"))
    assert np.array_equal(late[24:], clean[:-24])
    assert not late[:24].any()
    assert np.array_equal(offset, clean + 0.25)


def test_a_fast_clock_shows_earlier_times() -> None:
    """Sample j shows interval j / (1 + e), to the (w h)^2/8 of a straight line between intervals."""
    n = 40960
    found = Drifting(Sines(), 1, 1e-3).read(n)[1]
    wanted = np.sin(2 * np.pi * TONE * (np.arange(n) / 1.001 + 0.5) / RATE)
    assert np.abs(found - wanted).max() < (2 * math.pi * TONE / RATE) ** 2 / 8 * 1.01


def test_ac_coupling_leads_by_its_corner() -> None:
    """atan(f_c/f) each; ten time constants of 0.32 s before the two cycles that are looked at."""
    settled, cycles = int(RATE * 4), int(2 * RATE / TONE)
    found, clean = FAULTS["AC"](Sines()).read(settled + cycles), Sines().read(settled + cycles)
    for row, corner in enumerate((0.5, 0.55)):
        angle = lead(found[row, settled:], clean[row, settled:])
        assert angle == pytest.approx(math.atan(corner / TONE), rel=1e-3)
