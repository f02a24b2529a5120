"""Rows from rest to their steady state: final energy per cycle of each, and energy of all in each
cycle.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from daq.compiled import njit
from rig.kernels.borrowed import borrowed
from rig.kernels.rows.many_rows import HISTORY, find_recurrence
from rig.kernels.rows.one_row import RowSet, cycle, no_events
from rig.kernels.waveform import Array, Ints


class Transient(NamedTuple):
    """Rows over some cycles from rest at one wall, units of the waveform.

    energy : steady energy per cycle of each row, shape (rows,): the mean over its period, or,
        without one, over the cycles after the first `HISTORY`
    period : of each row in cycles, 0 for none, -1 if it exceeds `MAX_EVENTS`
    work : of the box on all rows in each cycle, shape (cycles,)
    loose : loss of the rows without a period in each cycle, shape (cycles,)
    simulated : number of row cycles simulated; all others are copies of a period
    """

    energy: Array
    period: Ints
    work: Array
    loose: Array
    simulated: int


def transient(rows: RowSet, P: Array, Q: Array, cycles: int) -> Transient:
    """Follow rows through their first `cycles` cycles, more than `HISTORY` of them."""
    return Transient(*_transient(*rows, P, Q, cycles, no_events()))


@njit(cache=True, nogil=True)
def _transient(
    layer: Ints,
    clearance: Array,
    restitution: float,
    band: Array,
    tables: Array,
    P: Array,
    Q: Array,
    cycles: int,
    room: NDArray[np.void],
) -> tuple[Array, Ints, Array, Array, int]:
    count = layer.shape[0]
    energy, period = np.zeros(count), np.zeros(count, np.int64)
    total, loose = np.zeros(cycles), np.zeros(cycles)
    work, lost = np.empty(cycles), np.empty(cycles)
    history = np.empty((HISTORY, 3))
    tables, P, Q = borrowed(tables), borrowed(P), borrowed(Q)
    events = room[0]
    simulated = 0
    for r in range(count):
        i = layer[r]
        table = tables[i]
        mode, u, z = 0, 0.0, 0.0
        last, back = cycles, 0
        for n in range(cycles):
            # From a recurrence on, the remaining cycles are copies of the period.
            back = find_recurrence(history, n, mode, u, z)
            if back > 0:
                last = n
                break
            k = n % HISTORY
            history[k, 0], history[k, 1], history[k, 2] = mode, u, z
            after = cycle(mode, u, z, band[i], clearance[r], restitution, table, P, Q, events)
            mode, u, z = after.mode, after.u, after.z
            if after.events < 0:
                last, back = n, -1
                break
            work[n], lost[n] = after.work, after.friction + after.collision
        simulated += last
        period[r] = back
        if back < 0:
            continue
        for n in range(last, cycles):
            work[n], lost[n] = work[n - back], lost[n - back]
        # Mean of the last full period, or of everything after the longest period that is looked
        # for.
        energy[r] = lost[last - back : last].mean() if back > 0 else lost[HISTORY:].mean()
        total += work
        if back == 0:
            loose += lost
    return energy, period, total, loose, simulated
