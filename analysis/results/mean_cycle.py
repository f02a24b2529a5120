"""The example condition of the report: a mean cycle of force and acceleration by its harmonics, and
W of every cycle.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from analysis.results.condition import Result
from analysis.results.waveform_rows import RunCycles, Waveforms

__all__ = ["HARMONICS", "waveforms"]

HARMONICS = 100  # that are kept: enough for the steps of impacts at the size of a page
DIGITS = 7  # of phasors and energies in the report: beyond any drawing
MOST = 1000  # values of W of a run in the report


def waveforms(results: Sequence[Result]) -> Waveforms | None:
    """Return the waveforms of the condition with the largest energy; None without any."""
    if not results:
        return None
    top = max(results, key=lambda result: result.W_exp.value)
    first = top.runs[0]
    each = math.ceil(max(run.energy.W_cycles.size for run in top.runs) / MOST)
    return Waveforms(
        condition=top.setting.id,
        run=first.run,
        frequency=first.energy.frequency,
        force=_pairs(first.energy.force[:HARMONICS]),
        acceleration=_pairs(first.energy.acceleration[:HARMONICS]),
        thd_force=first.energy.thd_force,
        thd_acceleration=first.energy.thd_acceleration,
        runs=tuple(RunCycles(run.run, _means(run.energy.W_cycles, each)) for run in top.runs),
        cycles_each=max(each, 1),
    )


def _means(W: NDArray[np.float64], each: int) -> tuple[float, ...]:
    """Return means over groups of `each` cycles; the last group may be shorter."""
    starts = np.arange(0, W.size, each)
    return tuple(
        _short(mean)
        for mean in (np.add.reduceat(W, starts) / np.diff(starts, append=W.size)).tolist()
    )


def _pairs(phasors: NDArray[np.complex128]) -> tuple[tuple[float, float], ...]:
    """Return phasors as pairs of real and imaginary part."""
    return tuple((_short(value.real), _short(value.imag)) for value in phasors.tolist())


def _short(value: float) -> float:
    """Return a number rounded to DIGITS significant digits."""
    return float(f"{value:.{DIGITS}g}")
