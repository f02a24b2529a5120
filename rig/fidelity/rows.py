"""Number of rows per layer: an increasing series of trials against the number of rows side by side
in the box.
"""

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
"""Trial numbers of rows per layer, below the resolved number."""

SHARE = 0.5
"""Largest fraction of the tolerance for the rows; the remainder is for settling, record
and noise.
"""

COVERAGE = 2.0
"""Coverage factor: the number of standard deviations counted as error."""

LAGS = 20
"""Number of distances between rows at which their semivariance is computed."""

PILOT_CYCLES = (HISTORY + 448, HISTORY + 1984, HISTORY + 8128)
"""Lengths of pilot runs, in cycles, as averaging rows without a period requires: some wander for
hundreds of cycles before they become periodic, and then dissipate up to half as much.
"""

AVERAGING = 0.1
"""Target for the error of averaging rows without a period, as a fraction of the tolerance; the
error counts in any case.
"""

LATE = 0.5
"""Relative error assigned to rows whose motion has not become periodic within the pilot run;
replaced by the observed change after a longer run.
"""

MOST_REFERENCE_ROWS = 200_000
"""Most rows in all sliding layers of a reference; for a bed with more, the reference has fewer rows
than lie side by side.
"""


@dataclass(frozen=True)
class RowsChoice:
    """Rows per layer and their errors, relative to W.

    resolved : rows side by side, L2/d
    reference : rows of the reference, fewer if the resolved ones are too many
    cycles : length of the pilot runs
    bias : of W_T by the layers variant, rows in the middle of their strata
    scatter, scatter_resolved : standard deviation of one refill's W due to the positions of rows in
        their strata, with these rows and with the resolved ones
    error : counted against the tolerance
    pilot : the bed with these rows, nominal filling
    planning : row cycles simulated for the choice
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
    """Return the smallest trial number of rows with an error within `SHARE` of the tolerance, or
    the resolved number if there is none.

    drawn : number of runs in the mean, each with random draws of its own (packing or waveform); 0
        if all are alike and use the nominal filling

    The error is the larger of the bias of W_T and, for drawn runs, `COVERAGE` standard deviations
    of the mean over the runs that the strata add to the scatter of resolved rows; plus the
    uncertainty of the resolved rows' own energy after the pilot run.
    """
    resolved = resolved_rows(scene)
    flowing = _pilot(with_rows(scene, 1), rig, drive, PILOT_CYCLES[0]).flowing
    reference = min(resolved, max(MOST_REFERENCE_ROWS // max(flowing, 1), 1))
    best, cycles, left, planning = _long_enough(
        with_rows(scene, reference), rig, drive, AVERAGING * tolerance
    )
    if not best.W > 0.0:
        return RowsChoice(1, resolved, resolved, cycles, 0.0, 0.0, 0.0, 0.0, best, planning)
    least = scatter(best.energy, reference) / best.W
    short = left + (COVERAGE * least if reference < resolved else 0.0)
    for rows in _candidates(reference):
        found = scatter(best.energy, rows) / best.W
        added = COVERAGE * math.sqrt(max(found**2 - least**2, 0.0) / max(drawn, 1))
        # Far too much scatter: skip the pilot run of this number.
        if added > (1.0 if drawn else 2.0 * COVERAGE) * SHARE * tolerance:
            continue
        tried = best if rows == reference else _pilot(with_rows(scene, rows), rig, drive, cycles)
        planning += tried.simulated if tried is not best else 0
        bias = tried.W / best.W - 1.0
        error = max(abs(bias), added if drawn else 0.0) + short
        if error <= SHARE * tolerance or rows == reference:
            break
    return RowsChoice(rows, resolved, reference, cycles, bias, found, least, error, tried, planning)


def scatter(energy: Array, rows: int) -> float:
    """Return the standard deviation of the sum of the rows' energies, each of `rows` rows lying
    anywhere in its stratum.

    energy : of resolved rows, (layers, resolved), in order of their clearance

    The variance of one row over its stratum is the mean semivariance of pairs inside it (the
    dispersion variance of geostatistics): (2/L^2) integral of (L - l) gamma(l) dl, with gamma from
    the resolved rows of all layers.
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


def _long_enough(
    scene: Scene, rig: Rig, drive: Drive, allowed: float
) -> tuple[Pilot, int, float, int]:
    """Return the shortest pilot run with an energy uncertainty of at most `allowed`, or the longest
    one; its cycles; its relative uncertainty; and the row cycles simulated, including shorter runs.

    The uncertainty is that of averaging, or the possible change of rows without a period: at most
    `LATE` of their energy, and at most the change observed since a shorter run, if there was one.
    """
    before, simulated = 0.0, 0
    for cycles in PILOT_CYCLES:
        found = _pilot(scene, rig, drive, cycles)
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


def _pilot(scene: Scene, rig: Rig, drive: Drive, cycles: int) -> Pilot:
    """Run a pilot of the nominal filling."""
    return rows_pilot(scene, rig, drive, nominal(scene, rig), cycles)
