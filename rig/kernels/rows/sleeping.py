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

from daq.compiled import njit
from rig.kernels.rows.tiles import (
    BAND,
    CHUNK,
    CLEARANCE,
    FIELDS,
    GIVEN,
    HI,
    LO,
    SLEEPS,
    P,
    U,
    W,
    at,
    clear,
    total,
)
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


class Population(NamedTuple):
    """A population of rows, and work space.

    everyone : tiles of all rows; those that are awake as they were at the start of the sleep
    awake, whose : tiles of the rows that are awake, and their places among all rows
    nap : sleep state, entries SINCE, PLACE, ...
    lanes : partial sums
    """

    all_rows: Array
    awake: Array
    places: Ints
    sleep: Array
    lanes: Array


@njit(cache=True, nogil=True)
def population(tiles: Array, rows: np.uint64) -> Population:
    """Return the population of all rows, none of them asleep."""
    sleep = np.zeros(6)
    sleep[SLACK] = 0.0 if rows >= LEAST_ROWS else math.inf
    return Population(
        tiles,
        np.zeros(tiles.shape[0]),
        np.empty(rows + np.uint64(1), np.int64),
        sleep,
        np.empty(CHUNK),
    )


@njit(cache=True, nogil=True)
def sleep_again(
    place: float,
    speed: float,
    latest: float,
    ahead: float,
    pull: float,
    rows: np.uint64,
    count: np.uint64,
    of: Population,
) -> tuple[np.uint64, float]:
    """End a sleep and start another. Returns (number of rows awake, heat of those that slept, per
    mass, J/kg).
    """
    heat, sleep = wake(place, latest, pull, rows, count, of), of.sleep
    sleep[SLACK], sleep[FARTHEST] = MARGIN * sleep[FARTHEST], 0.0
    return fall_asleep(place, speed, ahead, pull, rows, of), heat


@njit(cache=True, nogil=True)
def fall_asleep(
    place: float, speed: float, ahead: float, pull: float, rows: np.uint64, of: Population
) -> np.uint64:
    """Start a sleep of `ahead` (s) with the box at `place` (m) and `speed` (m/s). Returns the
    number of rows awake.

    The slip z of a row changes by at most (band + |pull|) t plus the slack, its position by (|z| +
    that) t.
    """
    tiles, sleep, lanes = of.all_rows, of.sleep, of.lanes
    sleep[SINCE], sleep[PLACE], sleep[SPEED] = 0.0, place, speed
    slack = sleep[SLACK]
    clear(lanes)
    for begin in range(np.uint64(0), rows, CHUNK):
        tile = begin * FIELDS
        for j in range(np.uint64(0), min(CHUNK, rows - begin)):
            i = tile + j
            z, band, u = speed - tiles[i + W], tiles[i + BAND], tiles[i + U]
            # Worst case over the whole sleep: friction, gravity and box all act against the slip.
            change = (band + abs(pull)) * ahead + slack
            gap = min(u, tiles[i + CLEARANCE] - u)
            # Still sliding the same way at the end, not at a wall on the way, and not leaning on
            # one (infinite limit).
            free = (
                (abs(z) > change)
                & (gap > (abs(z) + change) * ahead)
                & (tiles[i + HI] - tiles[i + LO] < math.inf)
            )
            # Friction on the row in the direction of the slip z of the box relative to it.
            given = band if z > 0.0 else -band
            given = given if free else 0.0
            tiles[i + SLEEPS] = 1.0 if free else 0.0
            tiles[i + GIVEN] = given
            lanes[j] += given
    sleep[FORCE] = total(lanes)
    return _gather(tiles, rows, of.awake, of.places)


@njit(cache=True, nogil=True)
def _gather(tiles: Array, rows: np.uint64, awake: Array, places: Ints) -> np.uint64:
    """Copy the rows that are awake to separate tiles. Returns their number."""
    count = np.uint64(0)
    for row in range(rows):
        i = at(np.uint64(row))
        places[count] = np.int64(i)
        # Written every time, counted only if awake: no branch in the loop.
        count += np.uint64(tiles[i + SLEEPS] == 0.0)
    for k in range(count):
        i, to = np.uint64(places[k]), at(np.uint64(k))
        awake[to + W], awake[to + U], awake[to + P] = tiles[i + W], tiles[i + U], tiles[i + P]
        awake[to + LO], awake[to + HI] = tiles[i + LO], tiles[i + HI]
        awake[to + BAND], awake[to + CLEARANCE] = tiles[i + BAND], tiles[i + CLEARANCE]
    return count


@njit(cache=True, nogil=True)
def wake(
    place: float, latest: float, pull: float, rows: np.uint64, count: np.uint64, of: Population
) -> float:
    """End a sleep with the box at `place` and update all rows. Returns the heat of those that
    slept, per mass, J/kg.

    count : number of rows awake
    latest : duration of the latest step, s, from which the impulses `P` are set as if the sleeping
        rows had taken it
    """
    tiles, awake, sleep, lanes = of.all_rows, of.awake, of.sleep, of.lanes
    time, moved = sleep[SINCE], place - sleep[PLACE]
    clear(lanes)
    for begin in range(np.uint64(0), rows, CHUNK):
        tile = begin * FIELDS
        for j in range(np.uint64(0), min(CHUNK, rows - begin)):
            i = tile + j
            given, w, sleeps = tiles[i + GIVEN], tiles[i + W], tiles[i + SLEEPS]
            # Constant acceleration over the sleep: velocity and slip in closed form.
            speed = (given + pull) * time
            way = moved - (w + 0.5 * speed) * time
            lanes[j] += given * way
            tiles[i + U] -= sleeps * way
            tiles[i + W] = w + sleeps * speed
            tiles[i + P] = given * latest
    for k in range(count):
        i, now = np.uint64(of.places[k]), at(np.uint64(k))
        tiles[i + W], tiles[i + U], tiles[i + P] = awake[now + W], awake[now + U], awake[now + P]
        tiles[i + LO], tiles[i + HI] = awake[now + LO], awake[now + HI]
    return total(lanes)


@njit(cache=True, nogil=True)
def stays(speed: Array, sleep: Array) -> bool:
    """Return whether the box stays within the slack at its velocities `speed` in a step; record the
    largest change.
    """
    for k in range(speed.shape[0]):
        sleep[FARTHEST] = max(sleep[FARTHEST], abs(speed[k] - sleep[SPEED]))
    inside: bool = sleep[FARTHEST] <= sleep[SLACK]
    return inside
