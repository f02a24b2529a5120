"""Moments of the slip velocity of rows over one cycle in their steady state, for the drag in the
voids.
"""

import numpy as np
from numpy.typing import NDArray

from daq.compiled import njit
from rig.kernels.borrowed import borrowed
from rig.kernels.rows.many_rows import SAME
from rig.kernels.rows.one_row import RowSet, cycle, no_events
from rig.kernels.waveform import TWO_PI, Array, Ints, motion

SETTLE = 8
AVERAGE = 24
"""Cycles left out, and cycles averaged after them, for a row that does not repeat from one cycle to
the next.
"""

NODES = 12
"""Gauss points per slide: exact to 1e-9 for a slide of half a cycle."""


def slip_moments(rows: RowSet, P: Array, Q: Array) -> tuple[float, float, float]:
    """Return the integrals of z^2 and |z|^3 over the phase of one cycle, summed over the rows, and
    the largest |z| of any row.

    z is the velocity of a row relative to the box, units of the waveform. Rows start at rest at one
    wall. A row whose state recurs after one cycle counts with that cycle, any other with the mean
    of `AVERAGE` cycles after `SETTLE`. A row with more than `MAX_EVENTS` events counts up to that
    point.
    """
    nodes, weights = np.polynomial.legendre.leggauss(NODES)
    second, third, peak = _slip_moments(*rows, P, Q, nodes, weights, no_events())
    return float(second), float(third), float(peak)


@njit(cache=True, nogil=True)
def _slip_moments(
    layer: Ints,
    clearance: Array,
    restitution: float,
    band: Array,
    tables: Array,
    P: Array,
    Q: Array,
    nodes: Array,
    weights: Array,
    room: NDArray[np.void],
) -> tuple[float, float, float]:
    tables, P, Q = borrowed(tables), borrowed(P), borrowed(Q)
    events = room[0]
    start_v = motion(0.0, P, Q)[1]
    second, third, peak = 0.0, 0.0, 0.0
    for r in range(layer.shape[0]):
        i = layer[r]
        mode, u, z = 0, 0.0, 0.0
        for n in range(SETTLE + AVERAGE):
            after = cycle(mode, u, z, band[i], clearance[r], restitution, tables[i], P, Q, events)
            if after.events < 0:
                break
            steady = after.mode == mode and abs(after.u - u) < SAME and abs(after.z - z) < SAME
            if steady or n >= SETTLE:
                # A row that becomes periodic represents all remaining cycles of the average.
                share = min(SETTLE + AVERAGE - n, AVERAGE) / AVERAGE if steady else 1.0 / AVERAGE
                now, phase, w = mode, 0.0, start_v + z
                for k in range(after.events + 1):
                    end = events.phase[k] if k < after.events else TWO_PI
                    # A riding row has no slip.
                    if now != 0:
                        two, three, top = _slide(phase, end, w, now * band[i], P, Q, nodes, weights)
                        second += share * two
                        third += share * three
                        peak = max(peak, top)
                    if k < after.events:
                        now, phase, w = events.mode[k], end, events.w[k]
            if steady:
                break
            mode, u, z = after.mode, after.u, after.z
    return second, third, peak


@njit(cache=True, nogil=True)
def _slide(
    begin: float,
    end: float,
    w: float,
    slope: float,
    P: Array,
    Q: Array,
    nodes: Array,
    weights: Array,
) -> tuple[float, float, float]:
    """Return the integrals of z^2 and |z|^3 over a slide, and its largest |z|: z = w - slope (phase
    - begin) - v_box.
    """
    half = 0.5 * (end - begin)
    peak = max(
        abs(w - motion(begin, P, Q)[1]),
        abs(w - slope * (end - begin) - motion(end, P, Q)[1]),
    )
    second, third = 0.0, 0.0
    for k in range(nodes.shape[0]):
        t = half * (1.0 + nodes[k])
        speed = abs(w - slope * t - motion(begin + t, P, Q)[1])
        second += half * weights[k] * speed * speed
        third += half * weights[k] * speed * speed * speed
        peak = max(peak, speed)
    return second, third, peak
