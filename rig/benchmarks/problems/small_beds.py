"""A bed of few rows, whole: as the rig follows it, by scipy's solve_ivp and by compiled RK4."""

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
"""Rows per layer, and the share of the standard box that they fill: five layers, whose rows all settle at once."""

SETTLE = AVERAGE = 4
"""Cycles followed and not counted, and cycles counted."""

OURS = "bed `layers` (ours), with its force at 8 edges per cycle"
SETTINGS = {"RK4, events located": (64.0, 512.0), "solve_ivp RK45": (1e-6, 1e-9), "solve_ivp DOP853": (1e-6, 1e-9),
            "solve_ivp LSODA": (1e-6, 1e-9)}  # fmt: skip
"""Coarse to fine; quick: the first of each. An implicit method (Radau) takes ten times as long for the same."""


def small_bed(level: float) -> StandardBed:
    """Steel balls of 4 mm to 5 % of the height, at `level` m/s^2."""
    return bed(level, ROWS, (f"scene.grains.fill={FILL}",))


def sliding(found: StandardBed) -> list[Slider]:
    """The rows of a bed that slide, one by one, in units of the waveform."""
    level, omega = found.condition.drive.acceleration, 2.0 * np.pi * found.condition.drive.frequency
    return [
        Slider("", threshold / level, float(play) * omega**2 / level, found.stack.restitution, 0.0, 0.0)
        for threshold, plays in zip(found.stack.threshold, found.stack.play, strict=True)
        if threshold < level
        for play in plays
    ]


def unit(found: StandardBed) -> float:
    """m V^2 of a row, J."""
    drive = found.condition.drive
    return float(found.stack.row_mass * (drive.acceleration / (2.0 * np.pi * drive.frequency)) ** 2)


def followed(found: StandardBed) -> float:
    """W by the bed itself, J per cycle."""
    drive = found.condition.drive
    moving = LayersBed(found.stack, Sampling(Waveform(drive.frequency, drive.acceleration), 8.0))
    moving.advance(SETTLE)
    part = moving.advance(AVERAGE)
    return float((part.friction + part.collision).mean())


def by_rows(found: StandardBed, solve: Callable[[Slider], float]) -> float:
    """W as the sum over the rows, J per cycle."""
    return unit(found) * sum(map(solve, sliding(found)))


def exact(found: StandardBed) -> float:
    """W from closed flights with root finding of their own (`rig.benchmarks.problems.reference`), J per cycle."""

    def counted(row: Slider) -> float:
        lost = energies(row.band, row.play, row.restitution, 0.0, (0, 0.0, 0.0), SETTLE + AVERAGE)
        return sum(lost[SETTLE:]) / AVERAGE

    return by_rows(found, counted)


def small_beds(levels: tuple[float, ...], rounds: int, quick: bool) -> Iterator[Row]:
    """A row for each level, method and setting: error of W, milliseconds, and times as long as the bed takes."""
    for level in levels:
        yield from _compared(small_bed(level), level, rounds, quick)


def _compared(found: StandardBed, level: float, rounds: int, quick: bool) -> list[Row]:
    true = exact(found)
    calls: dict[tuple[str, float], Callable[[], float]] = {(OURS, 0.0): partial(followed, found)}
    methods = {method.name: method for method in METHODS}
    for name, settings in SETTINGS.items():
        for setting in settings[:1] if quick else settings:
            calls[name, setting] = partial(by_rows, found, partial(_energy, methods[name].solve, setting))
    rows: dict[tuple[str, float], Row] = {}
    for key, call in calls.items():
        row: Row = {
            "kind": "small_bed", "problem": f"{len(sliding(found))} rows, {level:g} m/s2", "level": level,
            "method": key[0], "setting": key[1], "cycles": SETTLE + AVERAGE, "failure": None,
        }  # fmt: skip
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
