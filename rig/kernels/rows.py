"""Many independent rows: their steady energy per cycle, and their momentum on a sampling grid."""

import math

import numpy as np
from numba import njit

from rig.kernels.row import MAX_EVENTS, cycle
from rig.kernels.waveform import TWO_PI, motion

HISTORY = 64
"""Longest period looked for, in cycles of the drive."""

STORED_CYCLES = 8
STORED_EVENTS = 64
"""What of a steady row is kept to be replayed; longer orbits are simulated on."""

SAME = 1e-10
"""Two states closer than this, in units of the waveform, are the same state."""


@njit(cache=True, nogil=True)
def _recurrence(history, row, now, mode, u, z):
    """Smallest period in cycles after which the state at cycle `now` has returned, 0 for none yet."""
    length = history.shape[1]
    for back in range(1, min(now, length) + 1):
        k = (now - back) % length
        if (
            abs(history[row, k, 1] - u) < SAME
            and abs(history[row, k, 2] - z) < SAME
            and history[row, k, 0] == mode
        ):
            return back
    return 0


@njit(cache=True, nogil=True)
def steady_energy(layer, play, restitution, band, counts, tables, regions, first, P, Q, average):
    """Energy per cycle of rows of unit mass in their steady state, units of the waveform.

    Rows start at rest at one wall. A row whose state recurs within `HISTORY` cycles gives the mean over its
    period, any other the mean over `average` further cycles. Returns friction, collision, period (0: none), each
    of shape (rows,); the period is -1 where a row exceeds `MAX_EVENTS`.
    """
    rows = layer.shape[0]
    friction = np.zeros(rows)
    collision = np.zeros(rows)
    period = np.zeros(rows, np.int64)
    history = np.empty((1, HISTORY, 3))
    losses = np.empty((HISTORY, 2))
    event_phase = np.empty(MAX_EVENTS)
    event_mode = np.empty(MAX_EVENTS, np.int64)
    event_w = np.empty(MAX_EVENTS)
    for r in range(rows):
        i = layer[r]
        mode, u, z = 0, 0.0, 0.0
        for n in range(HISTORY + average):
            k = n % HISTORY
            if n <= HISTORY:
                back = _recurrence(history, 0, n, mode, u, z)
                if back > 0:
                    period[r] = back
                    for b in range(1, back + 1):
                        friction[r] += losses[(n - b) % HISTORY, 0] / back
                        collision[r] += losses[(n - b) % HISTORY, 1] / back
                    break
                history[0, k, 0], history[0, k, 1], history[0, k, 2] = mode, u, z
            mode, u, z, events, _, f, c = cycle(
                mode, u, z, band[i], play[r], restitution, counts[i], tables[i], regions[i], first[i], P, Q,
                event_phase, event_mode, event_w,
            )  # fmt: skip
            if events < 0:
                period[r] = -1
                break
            if n < HISTORY:
                losses[k, 0], losses[k, 1] = f, c
            else:
                friction[r] += f / average
                collision[r] += c / average
    return friction, collision, period


@njit(cache=True, nogil=True)
def follow(
    first_cycle, cycles, edges_per_cycle, velocity, riding_rows, scale, layer, play, restitution, band, counts, tables, regions, first, P, Q,
    state, period, recorded, history, stored_phase, stored_mode, stored_w, stored_offset, stored_ledger, stored_state,
):  # fmt: skip
    """Advance rows of unit mass through whole cycles and give their total momentum, times `scale`, at the sampling edges.

    Edge j lies at phase 2 pi j / edges_per_cycle from the start of the motion; the call covers the edges of its
    cycles and takes the box's velocity there, shape (edges,), units of the waveform. `state` (rows, 3) and the history and store arrays carry the rows from call to call. A row whose state
    has recurred is replayed from its stored period. `riding_rows` more rows ride all the time. Returns momentum (edges,), a ledger (cycles, 4) of work on the
    rows, friction loss, collision loss and kinetic energy at the end of the cycle, and False where a row exceeds
    `MAX_EVENTS`.
    """
    origin = math.ceil(first_cycle * edges_per_cycle)
    step = np.zeros((velocity.shape[0], 3))
    base = np.zeros((cycles, 3))
    base[:, 0] = riding_rows
    ledger = np.zeros((cycles, 4))
    event_phase = np.empty(MAX_EVENTS)
    event_mode = np.empty(MAX_EVENTS, np.int64)
    event_w = np.empty(MAX_EVENTS)
    start_v = motion(0.0, P, Q)[1]
    per_phase = edges_per_cycle / TWO_PI
    for r in range(layer.shape[0]):
        i = layer[r]
        mode, u, z = int(state[r, 0]), state[r, 1], state[r, 2]
        for k in range(cycles):
            now = first_cycle + k
            if period[r] == 0:
                back = _recurrence(history, r, now, mode, u, z)
                if back > 0:
                    period[r] = back
                h = now % history.shape[1]
                history[r, h, 0], history[r, h, 1], history[r, h, 2] = mode, u, z
            start_mode, start_w = mode, start_v + z
            turn = recorded[r] % period[r] if period[r] > 0 else 0
            if period[r] > 0 and recorded[r] >= period[r]:
                begin, events = stored_offset[r, turn], stored_offset[r, turn + 1] - stored_offset[r, turn]
                for n in range(events):
                    event_phase[n] = stored_phase[r, begin + n]
                    event_mode[n] = stored_mode[r, begin + n]
                    event_w[n] = stored_w[r, begin + n]
                work, f, c = stored_ledger[r, turn, 0], stored_ledger[r, turn, 1], stored_ledger[r, turn, 2]
                mode, u, z = int(stored_state[r, turn, 0]), stored_state[r, turn, 1], stored_state[r, turn, 2]
                recorded[r] += 1
            else:
                mode, u, z, events, work, f, c = cycle(
                    mode, u, z, band[i], play[r], restitution, counts[i], tables[i], regions[i], first[i], P, Q,
                    event_phase, event_mode, event_w,
                )  # fmt: skip
                if events < 0:
                    return np.zeros(0), ledger, False
                if period[r] > 0:
                    begin = stored_offset[r, turn]
                    if begin + events > STORED_EVENTS:
                        period[r] = -1
                    else:
                        for n in range(events):
                            stored_phase[r, begin + n] = event_phase[n]
                            stored_mode[r, begin + n] = event_mode[n]
                            stored_w[r, begin + n] = event_w[n]
                        stored_offset[r, turn + 1] = begin + events
                        stored_ledger[r, turn, 0], stored_ledger[r, turn, 1], stored_ledger[r, turn, 2] = work, f, c
                        stored_state[r, turn, 0], stored_state[r, turn, 1], stored_state[r, turn, 2] = mode, u, z
                        recorded[r] += 1
            ledger[k, 0] += work
            ledger[k, 1] += f
            ledger[k, 2] += c
            ledger[k, 3] += 0.5 * (start_v + z) ** 2
            riding, level, slope = _branch(start_mode, 0.0, start_w, band[i])
            base[k, 0] += riding
            base[k, 1] += level
            base[k, 2] += slope
            here = math.ceil(now * edges_per_cycle)
            last = math.ceil((now + 1) * edges_per_cycle)
            offset = now * edges_per_cycle
            for n in range(events):
                edge = math.ceil(offset + event_phase[n] * per_phase)
                new_riding, new_level, new_slope = _branch(event_mode[n], event_phase[n], event_w[n], band[i])
                if here <= edge < last:
                    step[edge - origin, 0] += new_riding - riding
                    step[edge - origin, 1] += new_level - level
                    step[edge - origin, 2] += new_slope - slope
                riding, level, slope = new_riding, new_level, new_slope
        state[r, 0], state[r, 1], state[r, 2] = mode, u, z
    return _momentum(step, base, first_cycle, cycles, edges_per_cycle, velocity, scale), ledger, True


@njit(cache=True, nogil=True, inline="always")
def _branch(mode, phase, w, band):
    """Velocity of a row behind an event as riding * v_box + level + slope * phase."""
    if mode == 0:
        return 1.0, 0.0, 0.0
    slope = -mode * band
    return 0.0, w - slope * phase, slope


@njit(cache=True, nogil=True)
def _momentum(step, base, first_cycle, cycles, edges_per_cycle, velocity, scale):
    out = np.empty(step.shape[0])
    origin = math.ceil(first_cycle * edges_per_cycle)
    for k in range(cycles):
        riding, level, slope = base[k, 0], base[k, 1], base[k, 2]
        offset = (first_cycle + k) * edges_per_cycle
        here = math.ceil(offset) - origin
        last = math.ceil((first_cycle + k + 1) * edges_per_cycle) - origin
        for e in range(here, last):
            riding += step[e, 0]
            level += step[e, 1]
            slope += step[e, 2]
            phase = TWO_PI * (e + origin - offset) / edges_per_cycle
            out[e] = scale * (riding * velocity[e] + level + slope * phase)
    return out
