"""Many independent rows: their steady energy per cycle, and their momentum on a sampling grid.

The loops over rows take arrays one by one and view them as `borrowed`; the memory of a row is a
record, whose references are not counted either.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from daq.compiled import njit
from rig.kernels.borrowed import borrowed
from rig.kernels.rows.one_row import RowCycle, RowSet, cycle, no_events
from rig.kernels.waveform import TWO_PI, Array, Ints, motion

HISTORY = 64
"""Longest period that is looked for, in cycles of the drive."""

LONGEST_SPAN = 64
"""Most cycles that a row may take to cross its clearance: exceeded by a frictionless row in a
clearance of more than 400 X.
"""

CROSSINGS, FORGETTING = 16, 40
"""CROSSINGS: number of spans averaged. FORGETTING: number of spans after which friction alone has
reduced the memory of the start to e^-10.
"""

STORED_CYCLES = 8
STORED_EVENTS = 64
"""Capacity for the replay of a periodic row, in cycles and events; longer orbits are simulated
throughout.
"""

REPEATS = 8
"""Longest common period of all rows, in cycles, that is reported to the caller."""

SAME = 1e-10
"""Distance, in units of the waveform, below which two states are identical."""


class EdgeGrid(NamedTuple):
    """Sampling edges of whole cycles: edge j lies at phase 2 pi j / per_cycle from the start of the
    motion.
    """

    first_cycle: int
    cycles: int
    per_cycle: float


MEMORY = np.dtype(
    [
        ("mode", np.int64),
        ("u", np.float64),
        ("z", np.float64),
        ("history", np.float64, (STORED_CYCLES, 3)),
        ("period", np.int64),
        ("recorded", np.int64),
        ("phase", np.float64, (STORED_EVENTS,)),
        ("event_mode", np.int64, (STORED_EVENTS,)),
        ("w", np.float64, (STORED_EVENTS,)),
        ("offset", np.int64, (STORED_CYCLES + 1,)),
        ("energy", np.float64, (STORED_CYCLES, 3)),
        ("after", np.float64, (STORED_CYCLES, 3)),
    ]
)
"""State of a row between calls; all zero is a row at rest at the end wall u = 0.

mode, u, z : its state
history : states at the start of the latest cycles
period : of its orbit in cycles, 0 if not found yet, -1 for an orbit with more events than can be
    stored
recorded : cycles stored or replayed since the period was found
phase, event_mode, w : events of one period; cycle n has those from offset[n] to offset[n + 1]
energy, after : work, friction and collision of each of these cycles, and the state after it
"""

Memory = NDArray[np.void]
"""Memories of the rows, dtype `MEMORY`, shape (rows,)."""


@njit(cache=True, nogil=True)
def find_recurrence(history: Array, now: int, mode: int, u: float, z: float) -> int:
    """Return the smallest period in cycles after which the state at cycle `now` recurs, 0 for none
    yet.
    """
    length = history.shape[0]
    for back in range(1, min(now, length) + 1):
        k = (now - back) % length
        # The mode must be equal, position and velocity equal within round-off.
        if (
            abs(history[k, 1] - u) < SAME
            and abs(history[k, 2] - z) < SAME
            and history[k, 0] == mode
        ):
            return back
    return 0


def steady_energy(rows: RowSet, P: Array, Q: Array, average: int) -> tuple[Array, Array, Ints]:
    """Return the energy per cycle of rows in their steady state, units of the waveform.

    Rows start at rest at one wall. A row whose state recurs within `HISTORY` cycles gives the mean
    over that period, however long it wandered before. Any other gives the mean over the last
    `average` of `HISTORY` + `average` cycles; for a row in a wide clearance both numbers grow
    (`_span`).

    Returns friction, collision and period (0: none), each of shape (rows,). The period is -1 if a
    row exceeds `MAX_EVENTS`, -2 if its span exceeds `LONGEST_SPAN`.
    """
    return steady_and_window(rows, P, Q, average, (0, 0))[:3]


def steady_and_window(
    rows: RowSet, P: Array, Q: Array, average: int, window: tuple[int, int]
) -> tuple[Array, Array, Ints, Array]:
    """Return the results of `steady_energy`, and each row's mean energy per cycle in a window of
    the same motion.

    window : (first cycle, one past the last); the energy has shape (rows,). The rows are at rest
        when cycle 0 begins, so this is the energy in a record after that many cycles of settling.
    """
    found: tuple[Array, Array, Ints, Array] = _steady_energy(
        *rows, P, Q, average, *window, no_events()
    )
    return found


@njit(cache=True, nogil=True, inline="always")
def _span(band: float, clearance: float) -> tuple[int, int]:
    """Return the cycles of one span, and the number of spans to leave out before averaging.

    A span is the time that a row thrown at speed 1 needs to cross its clearance, or until friction
    has stopped it, after 1/(2 band). Friction leaves the fraction e^(-pi band) of the memory of the
    start in each cycle; a plastic hit leaves none.
    """
    crosses = 2.0 * band * clearance < 1.0
    reach = clearance if crosses else 0.5 / band
    return math.ceil(min(reach / TWO_PI, LONGEST_SPAN + 1.0)), CROSSINGS if crosses else FORGETTING


@njit(cache=True, nogil=True)
def _steady_energy(
    layer: Ints,
    clearance: Array,
    restitution: float,
    band: Array,
    tables: Array,
    P: Array,
    Q: Array,
    average: int,
    first: int,
    last: int,
    room: NDArray[np.void],
) -> tuple[Array, Array, Ints, Array]:
    tables, P, Q = borrowed(tables), borrowed(P), borrowed(Q)
    count = layer.shape[0]
    friction = np.zeros(count)
    collision = np.zeros(count)
    period = np.zeros(count, np.int64)
    seen = np.zeros(count)
    history = np.empty((HISTORY, 3))
    losses = np.empty((HISTORY, 2))
    events = room[0]
    for r in range(count):
        i = layer[r]
        table = tables[i]
        mode, u, z = 0, 0.0, 0.0
        span, left_out = _span(band[i], clearance[r])
        if span > LONGEST_SPAN:
            period[r] = -2
            continue
        # Wide clearances: several crossings must pass before a mean is representative.
        settled, averaged = max(HISTORY, left_out * span), max(average, CROSSINGS * span)
        for n in range(settled + averaged):
            k = n % HISTORY
            # A recurring state repeats for ever: the mean over one period is exact, and the loop
            # may end.
            back = find_recurrence(history, n, mode, u, z)
            if back > 0:
                period[r] = back
                friction[r], collision[r] = 0.0, 0.0
                for b in range(1, back + 1):
                    friction[r] += losses[(n - b) % HISTORY, 0] / back
                    collision[r] += losses[(n - b) % HISTORY, 1] / back
                # The rest of the window lies in the periodic part: take it from the stored period.
                for m in range(max(n, first), last):
                    b = (n - back + (m - n) % back) % HISTORY
                    seen[r] += losses[b, 0] + losses[b, 1]
                break
            history[k, 0], history[k, 1], history[k, 2] = mode, u, z
            after = cycle(mode, u, z, band[i], clearance[r], restitution, table, P, Q, events)
            mode, u, z = after.mode, after.u, after.z
            # More events than can be stored: reported by a negative period.
            if after.events < 0:
                period[r] = -1
                break
            losses[k, 0], losses[k, 1] = after.friction, after.collision
            if first <= n < last:
                seen[r] += after.friction + after.collision
            if n >= settled:
                friction[r] += after.friction / averaged
                collision[r] += after.collision / averaged
        if period[r] == 0:
            # Beyond the simulated cycles the mean is the best estimate.
            seen[r] += max(last - max(settled + averaged, first), 0) * (friction[r] + collision[r])
    return friction, collision, period, seen / max(last - first, 1)


def follow(
    grid: EdgeGrid,
    velocity: Array,
    riding_rows: float,
    scale: float,
    rows: RowSet,
    P: Array,
    Q: Array,
    memory: Memory,
) -> tuple[Array, Array, int]:
    """Advance rows through the cycles of a grid and return their total momentum, times `scale`, at
    its edges.

    velocity : of the box at the edges, units of the waveform, shape (edges,)
    riding_rows : number of additional rows, which ride all the time
    memory : modified in place

    Returns momentum (edges,); a ledger (cycles, 4) of work on the rows, friction loss, collision
    loss and kinetic energy at the end of the cycle; and the period in cycles with which everything
    from the first of these cycles on is replayed. The period is 0 if a row is still simulated or
    there is no common period up to `REPEATS`, -1 if a row exceeds `MAX_EVENTS`.
    """
    step = np.zeros((velocity.size, 3))
    base = np.zeros((grid.cycles, 3))
    base[:, 0] = riding_rows
    first_cycle, cycles, per_cycle = grid
    ledger, repeats = _follow(
        first_cycle, cycles, per_cycle, *rows, P, Q, memory, step, base, no_events()
    )
    return _momentum(*grid, step, base, velocity, scale), ledger, repeats


@njit(cache=True, nogil=True)
def _follow(
    first_cycle: int,
    cycles: int,
    per_cycle: float,
    layer: Ints,
    clearance: Array,
    restitution: float,
    band: Array,
    tables: Array,
    P: Array,
    Q: Array,
    memory: Memory,
    step: Array,
    base: Array,
    room: NDArray[np.void],
) -> tuple[Array, int]:
    """Return the ledger of the rows and their common period (`follow`); add their velocities to
    `step` and `base`.

    Between events the velocity of a row is riding * v_box + level + slope * phase. `base` holds the
    sum of these three coefficients at the start of each cycle, `step` their changes at the edges:
    summed up in `_momentum`, so that no loop over rows times edges is needed.
    """
    tables, P, Q = borrowed(tables), borrowed(P), borrowed(Q)
    ledger = np.zeros((cycles, 4))
    events = room[0]
    start_v = motion(0.0, P, Q)[1]
    origin = math.ceil(first_cycle * per_cycle)
    per_phase = per_cycle / TWO_PI
    repeats = 1
    for r in range(layer.shape[0]):
        i, row = layer[r], memory[r]
        table = tables[i]
        # All rows replay: the sum has their least common multiple as its period.
        repeats = _common(repeats, row.period) if row.recorded >= row.period else 0
        for k in range(cycles):
            now = first_cycle + k
            mode, w = row.mode, start_v + row.z
            _look_back(row, now)
            if row.period > 0 and row.recorded >= row.period:
                after = _replay(row, events)
            else:
                after = cycle(
                    row.mode, row.u, row.z, band[i], clearance[r], restitution, table, P, Q, events
                )
                if after.events < 0:
                    return ledger, -1
                _store(row, after, events)
            row.mode, row.u, row.z = after.mode, after.u, after.z
            ledger[k, 0] += after.work
            ledger[k, 1] += after.friction
            ledger[k, 2] += after.collision
            # Kinetic energy in the laboratory frame: box velocity plus relative velocity.
            ledger[k, 3] += 0.5 * (start_v + after.z) ** 2
            riding, level, slope = _branch(mode, 0.0, w, band[i])
            base[k, 0] += riding
            base[k, 1] += level
            base[k, 2] += slope
            here, last = math.ceil(now * per_cycle), math.ceil((now + 1) * per_cycle)
            for n in range(after.events):
                edge = math.ceil(now * per_cycle + events.phase[n] * per_phase)
                new_riding, new_level, new_slope = _branch(
                    events.mode[n], events.phase[n], events.w[n], band[i]
                )
                # An event after the last edge of the cycle first shows at the next cycle's base.
                if here <= edge < last:
                    step[edge - origin, 0] += new_riding - riding
                    step[edge - origin, 1] += new_level - level
                    step[edge - origin, 2] += new_slope - slope
                riding, level, slope = new_riding, new_level, new_slope
    return ledger, repeats


@njit(cache=True, nogil=True, inline="always")
def _common(one: int, other: int) -> int:
    """Return the least common multiple of two periods, 0 if one of them is none or the result
    exceeds `REPEATS`.
    """
    if one <= 0 or other <= 0:
        return 0
    both = one
    while both % other:
        both += one
        if both > REPEATS:
            return 0
    return both


@njit(cache=True, nogil=True, inline="always")
def _look_back(row: Any, now: int) -> None:
    """Find the period of a row's orbit from its state at cycle `now`, unless it is known."""
    if row.period == 0:
        row.period = find_recurrence(row.history, now, row.mode, row.u, row.z)
        h = now % STORED_CYCLES
        row.history[h, 0], row.history[h, 1], row.history[h, 2] = row.mode, row.u, row.z


@njit(cache=True, nogil=True)
def _replay(row: Any, events: Any) -> RowCycle:
    """Return the cached cycle for the current position in the period."""
    turn = row.recorded % row.period
    begin = row.offset[turn]
    count = row.offset[turn + 1] - begin
    for n in range(count):
        events.phase[n] = row.phase[begin + n]
        events.mode[n] = row.event_mode[begin + n]
        events.w[n] = row.w[begin + n]
    row.recorded += 1
    return RowCycle(
        int(row.after[turn, 0]), row.after[turn, 1], row.after[turn, 2], count,
        row.energy[turn, 0], row.energy[turn, 1], row.energy[turn, 2], 0,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def _store(row: Any, after: RowCycle, events: Any) -> None:
    """Store a cycle of a periodic row; if its events exceed the capacity, the row is simulated from
    then on.
    """
    if row.period <= 0:
        return
    turn = row.recorded % row.period
    begin = row.offset[turn]
    if begin + after.events > STORED_EVENTS:
        row.period = -1
        return
    for n in range(after.events):
        row.phase[begin + n] = events.phase[n]
        row.event_mode[begin + n] = events.mode[n]
        row.w[begin + n] = events.w[n]
    row.offset[turn + 1] = begin + after.events
    row.energy[turn, 0], row.energy[turn, 1], row.energy[turn, 2] = (
        after.work,
        after.friction,
        after.collision,
    )
    row.after[turn, 0], row.after[turn, 1], row.after[turn, 2] = after.mode, after.u, after.z
    row.recorded += 1


@njit(cache=True, nogil=True, inline="always")
def _branch(mode: int, phase: float, w: float, band: float) -> tuple[float, float, float]:
    """Return (riding, level, slope) of a row's velocity after an event: riding * v_box + level +
    slope * phase.
    """
    if mode == 0:
        return 1.0, 0.0, 0.0
    # Sliding rows are decelerated uniformly, w - mode band (theta - phase).
    slope = -mode * band
    return 0.0, w - slope * phase, slope


@njit(cache=True, nogil=True)
def _momentum(
    first_cycle: int,
    cycles: int,
    per_cycle: float,
    step: Array,
    base: Array,
    velocity: Array,
    scale: float,
) -> Array:
    """Return momentum times `scale` at every edge: the running sum of the coefficients along each
    cycle.
    """
    out = np.empty(step.shape[0])
    origin = math.ceil(first_cycle * per_cycle)
    for k in range(cycles):
        riding, level, slope = base[k, 0], base[k, 1], base[k, 2]
        offset = (first_cycle + k) * per_cycle
        here = math.ceil(offset) - origin
        last = math.ceil((first_cycle + k + 1) * per_cycle) - origin
        for e in range(here, last):
            riding += step[e, 0]
            level += step[e, 1]
            slope += step[e, 2]
            phase = TWO_PI * (e + origin - offset) / per_cycle
            out[e] = scale * (riding * velocity[e] + level + slope * phase)
    return out
