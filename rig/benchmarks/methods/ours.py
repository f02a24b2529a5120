"""The rig's own method: event by event, closed form in between, phases by safeguarded Newton and
Halley steps.

Sliders are the rows of bed `layers` (rig.kernels.rows.one_row), masses with weight the single mass
(rig.kernels.single_mass.one_cycle).
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rig.benchmarks.methods.method import Failed, Method, Work
from rig.benchmarks.problems.sliders import WIDE, Slider
from rig.kernels.borrowed import borrowed
from rig.kernels.rows.one_row import cycle, no_events
from rig.kernels.single_mass.one_cycle import Events, World, world
from rig.kernels.single_mass.one_cycle import cycle as single_mass_cycle
from rig.kernels.single_mass.one_cycle import no_events as single_mass_room
from rig.kernels.waveform import Array, crossings, extrema


def solve(slider: Slider, setting: float, settle: int, average: int) -> Work:  # noqa: ARG001  there is no setting
    """Simulate every cycle, as the other methods do; the rig itself stops where a state recurs."""
    sine, cosine = np.ones(1), np.zeros(1)
    if slider.gravity > 0.0:
        upper = slider.clearance if slider.clearance < WIDE else math.inf
        place, table = world(slider.gravity, 0.0, 0.0, upper, slider.restitution, sine, cosine)
        found = _single_mass(
            *slider.start, place, table, sine, cosine, single_mass_room(), settle, average
        )
    else:
        table = crossings(np.array([slider.band]), sine, cosine, extrema(sine, cosine)).tables[0]
        found = _row(
            slider.band,
            slider.clearance,
            slider.restitution,
            *slider.start,
            table,
            sine,
            cosine,
            no_events(),
            settle,
            average,
        )
    if found[1] < 0:
        raise Failed("more events in a cycle than can be followed")
    return Work(*found)


@njit(cache=True, nogil=True)
def _row(
    band: float,
    clearance: float,
    restitution: float,
    mode: int,
    u: float,
    z: float,
    table: Array,
    P: Array,
    Q: Array,
    room: NDArray[np.void],
    settle: int,
    average: int,
) -> tuple[float, int, int, int, int, float, float]:
    """Follow a row through all cycles; return the fields of `Work`, events -1 where there are too
    many to follow.
    """
    energy, events, roots = 0.0, 0, 0
    table, P, Q = borrowed(table), borrowed(P), borrowed(Q)
    event = borrowed(room)[0]
    for k in range(settle + average):
        after = cycle(mode, u, z, band, clearance, restitution, table, P, Q, event)
        mode, u, z = after.mode, after.u, after.z
        if after.events < 0:
            return energy, -1, 0, 0, roots, u, z
        events += after.events
        roots += after.roots
        if k >= settle:
            energy += (after.friction + after.collision) / average
    return energy, events, roots, 0, roots, u, z


@njit(cache=True, nogil=True)
def _single_mass(
    mode: int,
    u: float,
    z: float,
    world: World,
    table: Array,
    P: Array,
    Q: Array,
    room: Events,
    settle: int,
    average: int,
) -> tuple[float, int, int, int, int, float, float]:
    """Follow a single mass as `_row` follows a row."""
    harmonics = np.empty((2, P.shape[0]))
    table, P, Q, S, C = (
        borrowed(table),
        borrowed(P),
        borrowed(Q),
        borrowed(harmonics[0]),
        borrowed(harmonics[1]),
    )
    room = Events(borrowed(room.phase), borrowed(room.mode), borrowed(room.w))
    energy, events, roots = 0.0, 0, 0
    for k in range(settle + average):
        after = single_mass_cycle(mode, u, z, world, table, P, Q, S, C, room)
        mode, u, z = after.mode, after.q, after.u
        if after.events < 0:
            return energy, -1, 0, 0, roots, u, z
        events += after.events
        roots += after.roots
        if k >= settle:
            energy += (after.friction + after.collision) / average
    return energy, events, roots, 0, roots, u, z


OURS = Method("event-driven (ours)", "ours", "", (0.0,), (0.0,), solve)
