"""A whole bed of few rows: by the rig's bed, by scipy's solve_ivp and by compiled RK4."""

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np

from rig.beds.layers import LayersBed
from rig.benchmarks.methods import METHODS
from rig.benchmarks.methods.method import Failed
from rig.benchmarks.problems.beds import StandardBed, bed
from rig.benchmarks.problems.reference import energies
from rig.benchmarks.problems.sliders import Slider
from rig.benchmarks.timing import interleaved, ratios, spread
from rig.drive.waveform import Sampling, Waveform

Row = dict[str, Any]

ROWS, FILL = 3, 0.05
"""Rows per layer, and filled fraction of the standard box: five layers, all of whose rows settle at
once.
"""

SETTLE = AVERAGE = 4
"""Cycles settled, and cycles averaged."""

OURS = "bed `layers` (ours), with its force at 8 edges per cycle"
SETTINGS = {"RK4, events located": (64.0, 512.0), "solve_ivp RK45": (1e-6, 1e-9), "solve_ivp DOP853": (1e-6, 1e-9),
            "solve_ivp LSODA": (1e-6, 1e-9)}  # fmt: skip
"""Settings, coarse to fine; quick: the first of each.

An implicit method (Radau) takes ten times as long for the same error.
"""


def small_bed(level: float) -> StandardBed:
    """Return a bed of 4 mm steel balls filled to 5 % of the height, at `level` m/s^2."""
    return bed(level, ROWS, (f"scene.grains.fill={FILL}",))


def sliding(found: StandardBed) -> list[Slider]:
    """Return the rows of a bed that slide, in units of the waveform."""
    level, omega = found.condition.drive.acceleration, 2.0 * np.pi * found.condition.drive.frequency
    rows = []
    for threshold, clearances in zip(found.stack.threshold, found.stack.clearance, strict=True):
        if threshold >= level:
            continue  # the friction holds this layer throughout
        for clearance in clearances:
            length = float(clearance) * omega**2 / level
            rows.append(Slider("", threshold / level, length, found.stack.restitution, 0.0, 0.0))
    return rows


def unit(found: StandardBed) -> float:
    """Return the energy unit m V^2 of a row, J."""
    drive = found.condition.drive
    return float(found.stack.row_mass * (drive.acceleration / (2.0 * np.pi * drive.frequency)) ** 2)


def followed(found: StandardBed) -> float:
    """Return W by the bed itself, J per cycle."""
    drive = found.condition.drive
    moving = LayersBed(found.stack, Sampling(Waveform(drive.frequency, drive.acceleration), 8.0))
    moving.advance(SETTLE)
    part = moving.advance(AVERAGE)
    return float((part.friction + part.collision).mean())


def by_rows(found: StandardBed, solve: Callable[[Slider], float]) -> float:
    """Return W as the sum of `solve` over the rows, J per cycle."""
    return unit(found) * sum(map(solve, sliding(found)))


def exact(found: StandardBed) -> float:
    """Return W from closed flights with independent root finding
    (`rig.benchmarks.problems.reference`), J per cycle.
    """

    def counted(row: Slider) -> float:
        lost = energies(
            row.band, row.clearance, row.restitution, 0.0, (0, 0.0, 0.0), SETTLE + AVERAGE
        )
        return sum(lost[SETTLE:]) / AVERAGE

    return by_rows(found, counted)


def small_beds(levels: tuple[float, ...], rounds: int, quick: bool) -> Iterator[Row]:
    """Yield a row for each level, method and setting: error of W, milliseconds, and time relative
    to the bed's.
    """
    for level in levels:
        yield from _compared(small_bed(level), level, rounds, quick)


def _compared(found: StandardBed, level: float, rounds: int, quick: bool) -> list[Row]:
    true = exact(found)
    calls: dict[tuple[str, float], Callable[[], float]] = {(OURS, 0.0): partial(followed, found)}
    methods = {method.name: method for method in METHODS}
    for name, settings in SETTINGS.items():
        for setting in settings[:1] if quick else settings:
            calls[name, setting] = partial(
                by_rows, found, partial(_energy, methods[name].solve, setting)
            )
    rows: dict[tuple[str, float], Row] = {}
    for key, call in calls.items():
        row: Row = {
            "kind": "small_bed",
            "problem": f"{len(sliding(found))} rows, {level:g} m/s2",
            "level": level,
            "method": key[0],
            "setting": key[1],
            "cycles": SETTLE + AVERAGE,
            "failure": None,
        }
        try:
            energy = call()
        except Failed as error:
            rows[key] = {**row, "failure": str(error)}
            continue
        rows[key] = {**row, "error": abs(energy / true - 1.0)}
    done = [key for key, row in rows.items() if row["failure"] is None]
    seconds = interleaved({repr(key): calls[key] for key in done}, rounds)
    for key in done:
        rows[key]["ms"] = spread([1e3 * value for value in seconds[repr(key)]])
        rows[key]["times_ours"] = ratios(seconds[repr(key)], seconds[repr((OURS, 0.0))])
    return list(rows.values())


def _energy(solve: Callable[..., Any], setting: float, row: Slider) -> float:
    return float(solve(row, setting, SETTLE, AVERAGE).energy)
