"""A single row of bed `layers` in units of the waveform, and the loss of a block on a rough floor
in 40 digits.
"""

import math
from decimal import Decimal
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rig.benchmarks.hard.exact import PI, Flight, arcsine
from rig.kernels.rows.many_rows import steady_energy
from rig.kernels.rows.one_row import RowCycle, RowSet, cycle, no_events
from rig.kernels.waveform import crossings, extrema

Array = NDArray[np.float64]
Wave = tuple[Array, Array]

SINE: Wave = (np.ones(1), np.zeros(1))
STUCK = 2.0 / math.sqrt(4.0 + math.pi**2)
"""eta above which a block on a rough floor sticks twice per cycle: 0.537."""


class Happened(NamedTuple):
    """The motion that begins at each event of a cycle: phase, mode, velocity in the laboratory,
    shape (events,).
    """

    phase: Array
    mode: NDArray[np.int64]
    w: Array


def one_row(band: float, clearance: float, restitution: float, wave: Wave = SINE) -> RowSet:
    """Return a single row on a waveform."""
    bands = np.array([band])
    return RowSet(
        np.zeros(1, np.int64),
        np.array([clearance]),
        restitution,
        bands,
        crossings(bands, *wave, extrema(*wave)).tables,
    )


def followed(rows: RowSet, cycles: int, wave: Wave = SINE) -> tuple[list[RowCycle], list[Happened]]:
    """Follow a single row from rest at u = 0; return (result, events) of each cycle, fewer where it
    was given up.
    """
    mode, u, z = 0, 0.0, 0.0
    ends, happened, room = [], [], no_events()
    for _ in range(cycles):
        after = cycle(
            mode,
            u,
            z,
            rows.band[0],
            rows.clearance[0],
            rows.restitution,
            rows.tables[0],
            *wave,
            room[0],
        )
        if after.events < 0:
            break
        mode, u, z = after.mode, after.u, after.z
        ends.append(after)
        n = after.events
        happened.append(Happened(*(room[name][0, :n].copy() for name in ("phase", "mode", "w"))))
    return ends, happened


def steady(
    band: float, clearance: float, restitution: float = 0.0, average: int = 64, wave: Wave = SINE
) -> tuple[float, int]:
    """Return (loss per cycle of a row in its steady state, its period)."""
    friction, collision, period = steady_energy(
        one_row(band, clearance, restitution, wave), *wave, average
    )
    return float(friction[0] + collision[0]), int(period[0])


def block(eta: Decimal) -> Decimal:
    """Return W of a block on a rough floor, 40 digits: sliding throughout below .537, one slide per
    half cycle above.
    """
    edge = 1 / (1 + PI * PI / 4).sqrt()
    if eta >= 1:
        return Decimal(0)
    if eta <= edge:
        return 4 * eta * (1 - (PI * eta / 2) ** 2).sqrt()
    flight = Flight(arcsine(eta), Decimal(0), Decimal(0), eta)
    # The push ends at pi - t0, the slide later. Its velocity starts as (t - t0)^2, near zero, so
    # the search starts where it is largest.
    at = PI - flight.t0
    while flight.velocity(at) > 0:
        at += (PI / 2 - flight.t0) / 8
    stop = at if flight.velocity(at) == 0 else _between(flight, PI - flight.t0, at)
    return 2 * eta * flight.position(stop)


def _between(flight: Flight, low: Decimal, high: Decimal) -> Decimal:
    """Return the zero of a flight's velocity by bisection."""
    for _ in range(130):
        middle = (low + high) / 2
        low, high = (middle, high) if flight.velocity(middle) > 0 else (low, middle)
    return (low + high) / 2


def closed_form(eta: float) -> float:
    """Return W of a block that slides throughout, eta below .537."""
    return 4.0 * eta * math.sqrt(1.0 - (math.pi * eta / 2.0) ** 2)
