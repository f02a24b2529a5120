"""Sleeping rows: rows that slide one way for a while, far from any wall, feel constant friction and
need no steps.

Most rows do so at any time. They are found by a bound: while the box velocity stays within a slack
of its initial value, their slip cannot end and no wall can be reached. All other rows are awake;
the steps work on copies of them in separate tiles. When the time is over, or the box leaves the
bound (detected before a step is committed), the sleeping rows are moved by the whole time at once,
as exactly as by steps.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from rig.kernels.rows.pages import BAND, CHUNK, DOZES, FIELDS, GIVEN, HI, LO, PLAY, P, U, W, at, clear, total
from rig.kernels.waveform import Array, Ints

LEAST_ROWS = np.uint64(128)
"""Smallest number of rows with sleeping: for fewer it does not pay."""

SPAN = 6
"""Longest sleep, in steps of full length."""

SINCE, PLACE, SPEED, SLACK, FARTHEST, FORCE = range(6)
"""Entries of the sleep state: elapsed time; box position and velocity at its start; bound on the
velocity change, and the largest change so far; sum of the impulses per mass and time on the
sleeping rows (an acceleration).
"""

MARGIN = 1.5
"""Slack, as a multiple of the largest velocity change of the box during the previous sleep."""


class Herd(NamedTuple):
    """A population of rows, and work space.

    everyone : tiles of all rows; those that are awake as they were at the start of the sleep
    awake, whose : tiles of the rows that are awake, and their places among all rows
    nap : sleep state, entries SINCE, PLACE, ...
    lanes : partial sums
    """

    everyone: Array
    awake: Array
    whose: Ints
    nap: Array
    lanes: Array


@njit(cache=True, nogil=True)
def herd(pages: Array, rows: np.uint64) -> Herd:
    """Return the population of all rows, none of them asleep."""
    nap = np.zeros(6)
    nap[SLACK] = 0.0 if rows >= LEAST_ROWS else math.inf
    return Herd(pages, np.zeros(pages.shape[0]), np.empty(rows + np.uint64(1), np.int64), nap, np.empty(CHUNK))


@njit(cache=True, nogil=True)
def again(
    place: float, speed: float, latest: float, ahead: float, pull: float, rows: np.uint64, count: np.uint64, of: Herd
) -> tuple[np.uint64, float]:
    """End a sleep and start another. Returns (number of rows awake, heat of those that slept, per
    mass, J/kg).
    """
    heat, nap = wake(place, latest, pull, rows, count, of), of.nap
    nap[SLACK], nap[FARTHEST] = MARGIN * nap[FARTHEST], 0.0
    return doze(place, speed, ahead, pull, rows, of), heat


@njit(cache=True, nogil=True)
def doze(place: float, speed: float, ahead: float, pull: float, rows: np.uint64, of: Herd) -> np.uint64:
    """Start a sleep of `ahead` (s) with the box at `place` (m) and `speed` (m/s). Returns the
    number of rows awake.

    The slip z of a row changes by at most (band + |pull|) t plus the slack, its position by (|z| +
    that) t.
    """
    pages, nap, lanes = of.everyone, of.nap, of.lanes
    nap[SINCE], nap[PLACE], nap[SPEED] = 0.0, place, speed
    slack = nap[SLACK]
    clear(lanes)
    for begin in range(np.uint64(0), rows, CHUNK):
        page = begin * FIELDS
        for j in range(np.uint64(0), min(CHUNK, rows - begin)):
            i = page + j
            z, band, u = speed - pages[i + W], pages[i + BAND], pages[i + U]
            change = (band + abs(pull)) * ahead + slack
            gap = min(u, pages[i + PLAY] - u)
            free = (abs(z) > change) & (gap > (abs(z) + change) * ahead) & (pages[i + HI] - pages[i + LO] < math.inf)
            given = band if z > 0.0 else -band
            given = given if free else 0.0
            pages[i + DOZES] = 1.0 if free else 0.0
            pages[i + GIVEN] = given
            lanes[j] += given
    nap[FORCE] = total(lanes)
    return _gather(pages, rows, of.awake, of.whose)


@njit(cache=True, nogil=True)
def _gather(pages: Array, rows: np.uint64, awake: Array, whose: Ints) -> np.uint64:
    """Copy the rows that are awake to separate tiles. Returns their number."""
    count = np.uint64(0)
    for row in range(rows):
        i = at(np.uint64(row))
        whose[count] = np.int64(i)
        # Written every time, counted only if awake: no branch in the loop.
        count += np.uint64(pages[i + DOZES] == 0.0)
    for k in range(count):
        i, to = np.uint64(whose[k]), at(np.uint64(k))
        awake[to + W], awake[to + U], awake[to + P] = pages[i + W], pages[i + U], pages[i + P]
        awake[to + LO], awake[to + HI] = pages[i + LO], pages[i + HI]
        awake[to + BAND], awake[to + PLAY] = pages[i + BAND], pages[i + PLAY]
    return count


@njit(cache=True, nogil=True)
def wake(place: float, latest: float, pull: float, rows: np.uint64, count: np.uint64, of: Herd) -> float:
    """End a sleep with the box at `place` and update all rows. Returns the heat of those that
    slept, per mass, J/kg.

    count : number of rows awake
    latest : duration of the latest step, s, from which the impulses `P` are set as if the sleeping
        rows had taken it
    """
    pages, awake, nap, lanes = of.everyone, of.awake, of.nap, of.lanes
    time, moved = nap[SINCE], place - nap[PLACE]
    clear(lanes)
    for begin in range(np.uint64(0), rows, CHUNK):
        page = begin * FIELDS
        for j in range(np.uint64(0), min(CHUNK, rows - begin)):
            i = page + j
            given, w, dozes = pages[i + GIVEN], pages[i + W], pages[i + DOZES]
            speed = (given + pull) * time
            way = moved - (w + 0.5 * speed) * time
            lanes[j] += given * way
            pages[i + U] -= dozes * way
            pages[i + W] = w + dozes * speed
            pages[i + P] = given * latest
    for k in range(count):
        i, now = np.uint64(of.whose[k]), at(np.uint64(k))
        pages[i + W], pages[i + U], pages[i + P] = awake[now + W], awake[now + U], awake[now + P]
        pages[i + LO], pages[i + HI] = awake[now + LO], awake[now + HI]
    return total(lanes)


@njit(cache=True, nogil=True)
def stays(speed: Array, nap: Array) -> bool:
    """Return whether the box stays within the slack at its velocities `speed` in a step; record the
    largest change.
    """
    for k in range(speed.shape[0]):
        nap[FARTHEST] = max(nap[FARTHEST], abs(speed[k] - nap[SPEED]))
    inside: bool = nap[FARTHEST] <= nap[SLACK]
    return inside
