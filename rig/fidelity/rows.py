"""How many rows a layer needs: a ladder of them against the rows that lie side by side in the box."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from rig.beds.janssen_stack import nominal
from rig.catalog.entries import Rig
from rig.fidelity.pilot import Pilot, rows_pilot
from rig.fidelity.scene_rows import resolved_rows, with_rows
from rig.kernels.rows.many_rows import HISTORY
from rig.protocol.spec import Drive, Scene

Array = NDArray[np.float64]

LADDER = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128)
"""Rows per layer that are tried, below the resolved number."""

SHARE = 0.5
"""Most of the tolerance that rows may take; settling, record and noise share what they leave."""

COVERAGE = 2.0
"""Standard deviations that stand for a scatter."""

LAGS = 20
"""Distances between rows at which their semivariance is taken."""

LOOKS = (HISTORY + 448, HISTORY + 1984, HISTORY + 8128)
"""Cycles over which a bed is looked at, as many as rows without a period need to be averaged: some wander for hundreds
of cycles before they repeat themselves, and take up to half as much then."""

AVERAGING = 0.1
"""Share of the tolerance that averaging rows without a period should not exceed; it is counted in any case."""

LATE = 0.5
"""Most that the energy of rows without a period may change once they repeat themselves, as a share of theirs: what they
are taken to leave open until a longer look shows what they do."""

MOST_REFERENCE_ROWS = 200_000
"""Rows in all sliding layers of a reference; a bed with more is compared with fewer rows than lie side by side."""


@dataclass(frozen=True)
class RowsChoice:
    """Rows per layer and what they cost in accuracy, relative to W.

    resolved : rows side by side, L2/d; reference : rows compared with, fewer where these are too many
    cycles : over which the beds were looked at
    bias : of W_T as the closed tier finds it, rows in the middle of their strata
    scatter, scatter_resolved : standard deviation of one pouring's W from where rows lie in their strata, with these
        rows and with the resolved ones
    error : what is counted against the tolerance
    pilot : the bed with these rows, nominal filling; planning : cycles of rows simulated to find them
    """

    rows: int
    resolved: int
    reference: int
    cycles: int
    bias: float
    scatter: float
    scatter_resolved: float
    error: float
    pilot: Pilot
    planning: int


def choose_rows(scene: Scene, rig: Rig, drive: Drive, tolerance: float, drawn: int) -> RowsChoice:
    """The fewest rows of the ladder whose error is within `SHARE` of the tolerance; the resolved rows where none are.

    drawn : runs whose mean is compared, each with a draw of its own (packing or waveform); 0 where all are alike and
        the nominal filling is what is run

    The error is the larger of the bias of W_T and, where runs are drawn, `COVERAGE` standard deviations of the mean
    over the runs that the strata add to the scatter of resolved rows; and what the look leaves open of the resolved
    rows' own energy.
    """
    resolved = resolved_rows(scene)
    flowing = _look(with_rows(scene, 1), rig, drive, LOOKS[0]).flowing
    reference = min(resolved, max(MOST_REFERENCE_ROWS // max(flowing, 1), 1))
    best, cycles, left, planning = _long_enough(with_rows(scene, reference), rig, drive, AVERAGING * tolerance)
    if not best.W > 0.0:
        return RowsChoice(1, resolved, resolved, cycles, 0.0, 0.0, 0.0, 0.0, best, planning)
    least = scatter(best.energy, reference) / best.W
    short = left + (COVERAGE * least if reference < resolved else 0.0)
    for rows in _candidates(reference):
        found = scatter(best.energy, rows) / best.W
        added = COVERAGE * math.sqrt(max(found**2 - least**2, 0.0) / max(drawn, 1))
        if added > (1.0 if drawn else 2.0 * COVERAGE) * SHARE * tolerance:
            continue
        tried = best if rows == reference else _look(with_rows(scene, rows), rig, drive, cycles)
        planning += tried.simulated if tried is not best else 0
        bias = tried.W / best.W - 1.0
        error = max(abs(bias), added if drawn else 0.0) + short
        if error <= SHARE * tolerance or rows == reference:
            break
    return RowsChoice(rows, resolved, reference, cycles, bias, found, least, error, tried, planning)


def scatter(energy: Array, rows: int) -> float:
    """Standard deviation of the sum of the rows' energies where each of `rows` rows lies anywhere in its stratum.

    energy : of resolved rows, (layers, resolved), in the order of their play

    The variance of one row over its stratum is the mean semivariance of pairs inside it (the dispersion variance of
    geostatistics): (2/L^2) integral of (L - l) gamma(l) dl, with gamma from the resolved rows of all layers.
    """
    layers, resolved = energy.shape
    if resolved == 1:
        return 0.0
    lags = np.unique(np.geomspace(1, resolved - 1, LAGS).round().astype(int))
    whole = energy * resolved
    gamma = [0.5 * float(np.mean((whole[:, lag:] - whole[:, :-lag]) ** 2)) for lag in lags]
    stratum = resolved / rows
    lag = (np.arange(256) + 0.5) * stratum / 256
    inside = np.interp(lag, np.concatenate(([0.0], lags)), np.concatenate(([0.0], gamma)))
    variance = 2.0 * float(np.mean((1.0 - lag / stratum) * inside))
    return math.sqrt(layers * variance / rows)


def _long_enough(scene: Scene, rig: Rig, drive: Drive, allowed: float) -> tuple[Pilot, int, float, int]:
    """The shortest look that leaves at most `allowed` of the energy open, or the longest one; its cycles, what it
    leaves open, and the cycles of rows simulated for it and for those before.

    Open is what averaging leaves, and what rows without a period may still change: at most `LATE` of what they take,
    and what they did since a shorter look, where there was one.
    """
    before, simulated = 0.0, 0
    for cycles in LOOKS:
        found = _look(scene, rig, drive, cycles)
        simulated += found.simulated
        late = LATE * (1.0 - found.repeating)
        if before > 0.0:
            late = min(late, abs(found.W / before - 1.0))
        left = max(found.averaging, late)
        if left <= allowed:
            break
        before = found.W
    return found, cycles, left, simulated


def _candidates(reference: int) -> Iterator[int]:
    yield from (rows for rows in LADDER if rows < reference)
    yield reference


def _look(scene: Scene, rig: Rig, drive: Drive, cycles: int) -> Pilot:
    return rows_pilot(scene, rig, drive, nominal(scene, rig), cycles)
