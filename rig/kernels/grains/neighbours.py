"""Sort the grains by cell, list who may touch whom, and carry the contacts' memory over."""

import numpy as np

from daq.compiled import njit
from rig.kernels.grains.arrays import (
    END_HIGH,
    END_LOW,
    FAULT,
    FLEW_AWAY,
    FLOOR,
    FX,
    FZ,
    LID,
    LISTS_FULL,
    NEIGHBOURS,
    RADIUS,
    REBUILDS,
    SHELL,
    SIDE_HIGH,
    SIDE_LOW,
    SPLIT,
    TRAVEL,
    WALL_ENTRIES,
    WALL_SPLIT,
    Cells,
    Floats,
    GrainArrays,
    Ints,
    Lists,
    Room,
    X,
    Y,
    Z,
)


@njit(cache=True, nogil=True)
def _cells(grains: GrainArrays, grid: Cells) -> bool:
    """Fill `grid.cell_of`, `head` and `order` (a counting sort, stable). False if a grain is lost."""
    place, head = grains.place, grid.head
    head[:] = 0
    n = place.shape[0]
    for i in range(n):
        x, y, z = place[i, X], place[i, Y], place[i, Z]
        if not (abs(x) + abs(y) + abs(z) < 1e6):
            return False
        kx = min(max(int(np.floor(x / grid.cell)), 0), grid.nx - 1)
        ky = min(max(int(np.floor(y / grid.cell)), 0), grid.ny - 1)
        kz = min(max(int(np.floor(z / grid.cell)), 0), grid.nz - 1)
        cell = (kx * grid.ny + ky) * grid.nz + kz
        grid.cell_of[i] = cell
        head[cell + 1] += 1
    for cell in range(head.size - 1):
        head[cell + 1] += head[cell]
    for i in range(n):
        cell = grid.cell_of[i]
        grid.order[head[cell]] = i
        head[cell] += 1
    for cell in range(head.size - 1, 0, -1):
        head[cell] = head[cell - 1]
    head[0] = 0
    return True


@njit(cache=True, nogil=True)
def _sort(grains: GrainArrays, old: GrainArrays, grid: Cells) -> None:
    """Put the grains into the order of their cells. `load` needs none: it is computed anew."""
    n = grains.place.shape[0]
    for k in range(n):
        i = grid.order[k]
        grains.place[k] = old.place[i]
        grains.motion[k] = old.motion[i]
        grains.ident[k] = old.ident[i]
        grains.cavity[k] = old.cavity[i]


@njit(cache=True, nogil=True)
def _scan(
    i: int, begin: int, end: int, place: Floats, reach: float, lists: Lists, count: int
) -> int:
    """List the neighbours of grain i among the grains begin .. end - 1; return the new count."""
    x, y, z, radius = place[i, X], place[i, Y], place[i, Z], place[i, RADIUS]
    for j in range(begin, end):
        dx, dy, dz = x - place[j, X], y - place[j, Y], z - place[j, Z]
        most = radius + place[j, RADIUS] + reach
        if dx * dx + dy * dy + dz * dz < most * most:
            if count < lists.other.size:
                lists.other[count] = j
            count += 1
    return count


@njit(cache=True, nogil=True)
def _pairs(grains: GrainArrays, lists: Lists, grid: Cells) -> int:
    """List all pairs of neighbours; return their number."""
    place, head = grains.place, grid.head
    count = 0
    for kx in range(grid.nx):
        for ky in range(grid.ny):
            for kz in range(grid.nz):
                cell = (kx * grid.ny + ky) * grid.nz + kz
                for i in range(head[cell], head[cell + 1]):
                    lists.first[i] = count
                    # This cell and the next along z are adjacent in memory.
                    above = min(kz + 1, grid.nz - 1)
                    end = head[(kx * grid.ny + ky) * grid.nz + above + 1]
                    count = _scan(i, i + 1, end, place, grid.reach, lists, count)
                    for along in range(2):
                        for across in range(-1, 2):
                            if along == 0 and across < 1:
                                continue
                            jx, jy = kx + along, ky + across
                            if jx >= grid.nx or jy < 0 or jy >= grid.ny:
                                continue
                            row = (jx * grid.ny + jy) * grid.nz
                            begin = head[row + max(kz - 1, 0)]
                            end = head[row + above + 1]
                            count = _scan(i, begin, end, place, grid.reach, lists, count)
    lists.first[place.shape[0]] = count
    return count


@njit(cache=True, nogil=True)
def _wall_entry(i: int, wall: int, lists: Lists, count: int) -> int:
    if count < lists.wall_grain.size:
        lists.wall_grain[count] = i
        lists.wall[count] = wall
        lists.wall_touching[count] = 0
    return count + 1


@njit(cache=True, nogil=True)
def _walls(grains: GrainArrays, lists: Lists, room: Room, reach: float) -> int:
    """List the grains near each wall; return the number of entries."""
    place, count = grains.place, 0
    for i in range(place.shape[0]):
        x, z = place[i, X], place[i, Z]
        y = place[i, Y] - room.pitch * grains.cavity[i]
        near = place[i, RADIUS] + 0.5 * reach
        if room.cylinder:
            dx, dy = x - 0.5 * room.length, y - 0.5 * room.length
            inside = 0.5 * room.length - near
            if inside < 0.0 or dx * dx + dy * dy > inside * inside:
                count = _wall_entry(i, SHELL, lists, count)
        else:
            if x < near:
                count = _wall_entry(i, END_LOW, lists, count)
            if room.length - x < near:
                count = _wall_entry(i, END_HIGH, lists, count)
            if y < near:
                count = _wall_entry(i, SIDE_LOW, lists, count)
            if room.width - y < near:
                count = _wall_entry(i, SIDE_HIGH, lists, count)
        if z < near:
            count = _wall_entry(i, FLOOR, lists, count)
        if room.lid and room.height - z < near:
            count = _wall_entry(i, LID, lists, count)
    return count


@njit(cache=True, nogil=True)
def _carry_over(lists: Lists, old: Lists, where: Ints) -> None:
    """Give the new pairs the memory of the old ones. `where` maps old to new indices."""
    rolls = lists.rolling.shape[0] > 0
    for i in range(where.size):
        for p in range(old.first[i], old.first[i + 1]):
            if not old.touching[p]:
                continue
            a, b = where[i], where[old.other[p]]
            sign = 1.0
            if a > b:
                a, b, sign = b, a, -1.0
            for q in range(lists.first[a], lists.first[a + 1]):
                if lists.other[q] == b:
                    lists.touching[q] = 1
                    for k in range(6):
                        lists.memory[q, k] = sign * old.memory[p, k]
                    if rolls:
                        # Rolling turns with the spins' difference and with the normal: both
                        # change their sign, the stretch keeps it; the torque is on the other.
                        lists.rolling[q] = old.rolling[p]
                        for k in range(FX, FZ + 1):
                            lists.rolling[q, k] *= sign
                    break


@njit(cache=True, nogil=True)
def _carry_over_walls(lists: Lists, old: Lists, where: Ints) -> None:
    """Give the new wall entries the memory of the old ones."""
    rolls = lists.wall_rolling.shape[0] > 0
    entries = lists.sizes[WALL_ENTRIES]
    first = np.searchsorted(lists.wall_grain[:entries], np.arange(where.size + 1))
    for p in range(old.sizes[WALL_ENTRIES]):
        if not old.wall_touching[p]:
            continue
        i = where[old.wall_grain[p]]
        for q in range(first[i], first[i + 1]):
            if lists.wall[q] == old.wall[p]:
                lists.wall_touching[q] = 1
                lists.wall_memory[q] = old.wall_memory[p]
                if rolls:
                    lists.wall_rolling[q] = old.wall_rolling[p]
                break


@njit(cache=True, nogil=True)
def _copy(lists: Lists, old: Lists) -> None:
    """Copy the used part of the lists."""
    pairs, entries = lists.sizes[NEIGHBOURS], lists.sizes[WALL_ENTRIES]
    old.first[:] = lists.first
    old.other[:pairs] = lists.other[:pairs]
    old.touching[:pairs] = lists.touching[:pairs]
    old.memory[:pairs] = lists.memory[:pairs]
    old.wall_grain[:entries] = lists.wall_grain[:entries]
    old.wall[:entries] = lists.wall[:entries]
    old.wall_touching[:entries] = lists.wall_touching[:entries]
    old.wall_memory[:entries] = lists.wall_memory[:entries]
    if lists.rolling.shape[0]:
        old.rolling[:pairs] = lists.rolling[:pairs]
        old.wall_rolling[:entries] = lists.wall_rolling[:entries]
    old.sizes[:] = lists.sizes


@njit(cache=True, nogil=True)
def make_lists(
    grains: GrainArrays,
    lists: Lists,
    old_grains: GrainArrays,
    old: Lists,
    grid: Cells,
    room: Room,
    totals: Floats,
) -> None:
    """Sort the grains and make their lists anew; contacts keep their memory.

    The work goes to the two slabs in equal numbers of pairs. On a fault `totals[FAULT]` is set.
    """
    n = grains.place.shape[0]
    _copy(lists, old)
    old_grains.place[:] = grains.place
    old_grains.motion[:] = grains.motion
    old_grains.ident[:] = grains.ident
    old_grains.cavity[:] = grains.cavity
    if not _cells(grains, grid):
        totals[FAULT] = FLEW_AWAY
        return
    _sort(grains, old_grains, grid)
    where = np.empty(n, np.int32)
    for k in range(n):
        where[grid.order[k]] = k
    pairs = _pairs(grains, lists, grid)
    entries = _walls(grains, lists, room, grid.reach)
    if pairs > lists.other.size or entries > lists.wall_grain.size:
        totals[FAULT] = LISTS_FULL
        return
    lists.sizes[NEIGHBOURS], lists.sizes[WALL_ENTRIES] = pairs, entries
    lists.touching[:pairs] = 0
    _carry_over(lists, old, where)
    _carry_over_walls(lists, old, where)
    split = 0
    while split < n and 2 * lists.first[split] < pairs:
        split += 1
    entry = 0
    while entry < entries and lists.wall_grain[entry] < split:
        entry += 1
    lists.sizes[SPLIT], lists.sizes[WALL_SPLIT] = split, entry
    lists.made_at[:] = grains.place[:, :3]
    totals[TRAVEL] = 0.0
    totals[REBUILDS] += 1.0
