"""Whole drive cycles of a record: their start, their number, and interpolation to a whole number of
points in each.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["SEGMENT_CYCLES", "Grid", "Window", "clear_of", "on_grid", "whole_cycles"]

Array = NDArray[np.float64]

SEGMENT_CYCLES = 64  # cycles analysed at a time, so that memory does not grow with the record
REACH = 3  # samples that the interpolation needs on each side


@dataclass(frozen=True, slots=True)
class Grid:
    """The sampling of a cycle; period: record samples per drive cycle; points: analysed points per
    cycle (integer).
    """

    period: float
    points: int

    @property
    def exact(self) -> bool:
        """Whether record samples are used as they are, without interpolation."""
        return self.period == self.points


@dataclass(frozen=True, slots=True)
class Window:
    """A window of `cycles` whole cycles from sample position `start` (fractional where the grid is
    not exact).
    """

    grid: Grid
    start: float
    cycles: int

    def segments(self) -> tuple["Window", ...]:
        """Return consecutive windows of at most SEGMENT_CYCLES cycles."""
        return tuple(
            Window(
                self.grid,
                self.start + first * self.grid.period,
                min(SEGMENT_CYCLES, self.cycles - first),
            )
            for first in range(0, self.cycles, SEGMENT_CYCLES)
        )

    def sample_range(self) -> tuple[int, int]:
        """Return the first sample needed, and one past the last."""
        end = self.start + self.cycles * self.grid.period
        if self.grid.exact:
            return int(self.start), int(end)
        # Half a step before the end lies past the last point, however the sum above was rounded.
        last = end - self.grid.period / self.grid.points / 2
        return math.floor(self.start) - REACH + 1, math.ceil(last) + REACH


def whole_cycles(
    samples: int,
    rate: float,
    frequency: float,
    *,
    filter_delay: float = 0.0,
    settle: float = 0,
    cycles: int | None = None,
) -> Window:
    """Return the whole drive cycles of a record after settling.

    samples: length of the record; rate, frequency: Hz; filter_delay: samples by which the record
    lags the drive; settle: drive cycles left out; cycles: largest number (None: all that fit). The
    window starts where a cycle of the drive starts: to the nearest sample where a cycle has a whole
    number of samples, exactly otherwise. Where the record is a few samples too short for the last
    cycle, the window starts earlier by these. ValueError where fewer than 4 samples make a cycle or
    no whole cycle fits.
    """
    period = rate / frequency
    if not 4 <= period < math.inf:
        raise ValueError(
            f"{period:.3g} samples per cycle at {rate:g} S/s and {frequency:g} Hz: at least 4 are needed"
        )
    nearest = round(period)
    begin = settle * period + filter_delay
    # Off by less than 1e-6 sample over the whole record: 1e-8 rad at 512 samples per cycle, far below
    # the resolution of the arithmetic.
    if abs(period - nearest) * (samples / period + 1) < 1e-6:
        grid, start, last = (
            Grid(float(nearest), nearest),
            float(max(round(begin), 0)),
            float(samples),
        )
    else:
        grid = Grid(period, 2 * math.ceil(period / 2))
        start, last = max(begin, REACH - 1.0), samples - REACH
    if cycles is not None:
        start = _moved(start, start + cycles * grid.period - last, grid)
    fit = math.floor((last - start) / grid.period + 1e-9)
    count = fit if cycles is None else min(fit, cycles)
    if count < 1:
        raise ValueError(
            f"no whole cycle: {samples} samples, {begin:.1f} before the window, {period:.1f} to a cycle"
        )
    return Window(grid, start, count)


def _moved(start: float, short: float, grid: Grid) -> float:
    """Return the start, earlier by the samples that the interpolation of the last cycle lacks;
    unchanged where these are more than a few.
    """
    if not 0 < short <= REACH + 1 or start - short < REACH - 1:
        return start
    return start - (math.ceil(short) if grid.exact else short)


def clear_of(window: Window, bad: Sequence[tuple[int, int]]) -> tuple[Window, ...]:
    """Return the stretches of a window's whole cycles that need no sample of the ranges `bad`
    (first, one past the last).
    """
    period, kept = window.grid.period, np.ones(window.cycles, dtype=bool)
    for cycle in range(window.cycles):
        first, last = Window(window.grid, window.start + cycle * period, 1).sample_range()
        kept[cycle] = all(last <= start or first >= stop for start, stop in bad)
    edges = np.flatnonzero(np.diff(np.concatenate(([0], kept.astype(np.int8), [0]))))
    return tuple(
        Window(window.grid, window.start + int(first) * period, int(last - first))
        for first, last in zip(edges[::2], edges[1::2], strict=True)
    )


def on_grid(samples: Array, first: int, window: Window) -> Array:
    """Return the samples of a window, `window.grid.points` to a cycle.

    samples: (..., n), the first of which is sample `first` of the record. Off the integer grid a
    local quintic (six-point Lagrange) interpolation is used: relative error (w dt)^6 / 204.8 at
    most, 2e-14 for the fundamental at 512 samples per cycle and 1e-5 for its 30th harmonic. Every
    point depends on its six neighbours only, so cutting a record into segments changes nothing.
    """
    grid = window.grid
    if grid.exact:
        begin = int(window.start) - first
        return samples[..., begin : begin + window.cycles * grid.points]
    position = (
        window.start - first + np.arange(window.cycles * grid.points) * (grid.period / grid.points)
    )
    base = np.floor(position).astype(np.intp)
    return sum(
        (
            weight * samples[..., base + (k - 2)]
            for k, weight in enumerate(_lagrange(position - base))
        ),
        start=np.zeros(samples.shape[:-1] + base.shape),
    )


def _lagrange(t: Array) -> tuple[Array, ...]:
    """Return the weights of samples -2, -1, 0, 1, 2, 3 for the value at t in [0, 1)."""
    a, b, c, d, e = t + 2, t + 1, t - 1, t - 2, t - 3
    ab, de, bt = a * b, d * e, b * t
    cde, abt = c * de, ab * t
    return (
        bt * cde / -120, a * t * cde / 24, ab * cde / -12,
        abt * de / 12, abt * c * e / -24, abt * c * d / 120,
    )  # fmt: skip
