"""A row of grains thrown onto a wall, hit by hit: in exact fractions, by the rig, and by fixed
steps.
"""

from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
from numba import njit

from rig.benchmarks.timing import interleaved, peak_memory, spread
from rig.kernels.chain import rebound

Row = dict[str, Any]

LONGEST = 1_000_000_000


def exact_rebound(
    grains: int, restitution: Fraction, restitution_wall: Fraction
) -> tuple[float, int]:
    """Return (rebound ratio of the centre of mass, number of hits) without any rounding.

    The grains start at 1, 2, ... with velocity -1.
    """
    x = [Fraction(k) for k in range(1, grains + 1)]
    v = [Fraction(-1)] * grains
    hits = 0
    while True:
        waits = [(-x[0] / v[0], 0)] if v[0] < 0 else []
        waits += [
            ((x[k] - x[k - 1]) / (v[k - 1] - v[k]), k) for k in range(1, grains) if v[k - 1] > v[k]
        ]
        if not waits:
            return float(sum(v) / grains), hits
        wait, k = min(waits)
        x = [place + wait * speed for place, speed in zip(x, v, strict=True)]
        hits += 1
        if k == 0:
            v[0] = -restitution_wall * v[0]
            continue
        mean, half = (v[k - 1] + v[k]) / 2, restitution * (v[k - 1] - v[k]) / 2
        v[k - 1], v[k] = mean - half, mean + half


@njit(cache=True, nogil=True)
def stepped_rebound(
    grains: int, restitution: float, restitution_wall: float, step: float
) -> tuple[float, int]:
    """Return (rebound ratio, number of steps) by fixed steps: all grains move, then every
    overlapping and closing pair is hit once.
    """
    x = np.arange(1.0, grains + 1.0)
    v = -np.ones(grains)
    taken = 0
    while taken < LONGEST:
        taken += 1
        x += step * v
        closing = v[0] < 0.0
        if x[0] <= 0.0 and v[0] < 0.0:
            v[0] = -restitution_wall * v[0]
        for k in range(1, grains):
            if v[k - 1] > v[k]:
                closing = True
                if x[k] <= x[k - 1]:
                    mean, half = 0.5 * (v[k - 1] + v[k]), 0.5 * restitution * (v[k - 1] - v[k])
                    v[k - 1], v[k] = mean - half, mean + half
        if not closing:
            break
    return v.mean(), taken


def chain(grains: int, rounds: int, quick: bool) -> list[Row]:
    """Compare the rig's hit-by-hit collision and fixed steps with exact fractions, e = 9/10, e0 =
    3/4.
    """
    exact, hits = exact_rebound(grains, Fraction(9, 10), Fraction(3, 4))
    calls: dict[str, Any] = {"event-driven (ours)": partial(rebound, grains, 0.9, 0.75)}
    for step in (0.5, 0.05) if quick else (2.0, 0.5, 0.1, 0.01, 0.001):
        calls[f"fixed steps, {step:g} gaps"] = partial(_mean, grains, step)
    rows: dict[str, Row] = {}
    for name, call in calls.items():
        call()
        found, memory = peak_memory(call)
        rows[name] = {
            "kind": "part",
            "problem": f"chain of {grains} grains",
            "method": name,
            "error": abs(found / exact - 1.0),
            "what": "rebound of the centre of mass, against exact fractions",
            "events": hits,
            "memory_kB": memory,
            "failure": None,
        }
    for name, seconds in interleaved(calls, rounds).items():
        rows[name]["ms"] = spread([1e3 * value for value in seconds])
    return list(rows.values())


def _mean(grains: int, step: float) -> float:
    return float(stepped_rebound(grains, 0.9, 0.75, step)[0])
