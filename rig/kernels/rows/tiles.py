"""Rows of grains in tiles: `CHUNK` consecutive rows, each of their fields in a block of its own
(structure of arrays).

Fields of one tile are constant distances apart, so a loop over its rows compiles to vector
instructions, whatever it reads and writes (with an array for each field, the compiler first tests
whether any two overlap, and soon gives up). Indices are unsigned: signed ones could be negative and
count from the end. Sums go to `lanes`, one for each row of a tile, so their order is that of the
rows on any machine.
"""

import numpy as np

from daq.compiled import njit
from rig.kernels.waveform import Array

CHUNK = np.uint64(64)
FIELDS = np.uint64(9)
W, U, P, LO, HI, BAND, CLEARANCE, SLEEPS, GIVEN = (CHUNK * np.uint64(k) for k in range(9))
"""Offsets of the fields in a tile: velocity, position relative to the wall at 0, latest impulse per
mass, lower and upper limit of the acceleration by the box, friction, clearance; whether a row
sleeps (1 or 0), and the friction on it if so.
"""


@njit(cache=True, nogil=True)
def to_tiles(w: Array, u: Array, lo: Array, hi: Array, band: Array, clearance: Array) -> Array:
    """Return rows as flat tiles; impulses and unused places of the last tile are 0."""
    rows = np.uint64(w.shape[0])
    # Rounded up to whole tiles; unused places stay 0 and contribute nothing to sums.
    tiles = np.zeros((rows + CHUNK - np.uint64(1)) // CHUNK * CHUNK * FIELDS)
    for k in range(rows):
        i = at(np.uint64(k))
        tiles[i + W], tiles[i + U], tiles[i + LO], tiles[i + HI] = w[k], u[k], lo[k], hi[k]
        tiles[i + BAND], tiles[i + CLEARANCE] = band[k], clearance[k]
    return tiles


@njit(cache=True, nogil=True)
def from_tiles(tiles: Array, w: Array, u: Array, lo: Array, hi: Array) -> None:
    """Copy the fields that change from the tiles back to arrays."""
    for k in range(w.shape[0]):
        i = at(np.uint64(k))
        w[k], u[k], lo[k], hi[k] = tiles[i + W], tiles[i + U], tiles[i + LO], tiles[i + HI]


@njit(cache=True, nogil=True, inline="always")
def at(row: np.uint64) -> np.uint64:
    """Return the place of a row's first field; the others follow at W, U, ..."""
    return row // CHUNK * CHUNK * FIELDS + row % CHUNK


@njit(cache=True, nogil=True)
def clear(lanes: Array) -> None:
    """Zero the partial sums."""
    for j in range(lanes.shape[0]):
        lanes[j] = 0.0


@njit(cache=True, nogil=True)
def total(x: Array) -> float:
    """Return the sum of an array in eight lanes: independent additions, in a fixed order."""
    n = x.shape[0]
    a, b, c, d, e, f, g, h = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    # Eight independent chains of additions hide the latency of the adder; the compiler may not
    # reorder them itself.
    whole = n - n % 8
    for i in range(0, whole, 8):
        a += x[i]
        b += x[i + 1]
        c += x[i + 2]
        d += x[i + 3]
        e += x[i + 4]
        f += x[i + 5]
        g += x[i + 6]
        h += x[i + 7]
    for i in range(whole, n):
        a += x[i]
    return ((a + b) + (c + d)) + ((e + f) + (g + h))
