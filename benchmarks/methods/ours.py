"""The rig's own way: from event to event, closed form between them, phases by safeguarded Newton."""

import numpy as np
from numba import njit

from benchmarks.methods.method import Failed, Method, Work
from benchmarks.sliders import Slider
from rig.kernels.row import MAX_EVENTS, Events, cycle
from rig.kernels.waveform import Array, crossings, extrema


def solve(slider: Slider, setting: float, settle: int, average: int) -> Work:  # noqa: ARG001  there is no setting
    """Every cycle simulated, as by the other methods: the rig itself stops where a state recurs."""
    sine, cosine = np.ones(1), np.zeros(1)
    table = crossings(np.array([slider.band]), sine, cosine, extrema(sine, cosine)).tables[0]
    energy, events = _rows(
        slider.band, slider.play, slider.restitution, *slider.start, table, sine, cosine, settle, average
    )
    if events < 0:
        raise Failed("more events in a cycle than can be followed")
    return Work(energy, events, 0, 0, 0)


@njit(cache=True, nogil=True)
def _rows(
    band: float, play: float, restitution: float, mode: int, u: float, z: float, table: Array, P: Array, Q: Array,
    settle: int, average: int,
) -> tuple[float, int]:  # fmt: skip
    room = Events(np.empty(MAX_EVENTS), np.empty(MAX_EVENTS, np.int64), np.empty(MAX_EVENTS))
    energy, events = 0.0, 0
    for k in range(settle + average):
        after = cycle(mode, u, z, band, play, restitution, table, P, Q, room)
        mode, u, z = after.mode, after.u, after.z
        if after.events < 0:
            return energy, -1
        events += after.events
        if k >= settle:
            energy += (after.friction + after.collision) / average
    return energy, events


OURS = Method("event-driven (ours)", "ours", "", (0.0,), (0.0,), solve)
