"""Error, time, work and memory of every method on one slider or single mass, timed side by side."""

from collections.abc import Callable
from functools import partial
from typing import Any

from rig.benchmarks.methods import METHODS
from rig.benchmarks.methods.method import Failed, Method, Work
from rig.benchmarks.problems.reference import followed
from rig.benchmarks.problems.sliders import Slider
from rig.benchmarks.timing import interleaved, peak_memory, spread

Row = dict[str, Any]

COMPILED_CYCLES = 4096
"""Largest number of cycles for a compiled method, so that its set-up is a small part of the time.
"""

COMPILED_STEPS = 200_000
"""Largest number of steps for a compiled method."""


def precision(
    slider: Slider, rounds: int, quick: bool, methods: tuple[Method, ...] = METHODS
) -> list[Row]:
    """Return a row for every method and setting; a failed one keeps its row, with the reason
    instead of numbers.
    """
    rows, calls = [], {}
    place, velocity = _steady(slider)
    for method in methods:
        for setting in method.quick if quick else method.ladder:
            average = _averaged(slider, method, setting)
            row: Row = {
                "kind": "precision",
                "problem": slider.name,
                "method": method.name,
                "group": method.group,
                "knob": method.knob,
                "setting": setting,
                "source": slider.source,
                "failure": None,
            }
            call = partial(method.solve, slider, setting, slider.settle, average)
            try:
                work, memory = _first(call)
            except Failed as error:
                rows.append({**row, "failure": str(error)})
                continue
            cycles = slider.settle + average
            rows.append({**row, "error": abs(work.energy / slider.exact - 1.0), "memory_kB": memory,
                         "state_error": max(abs(work.u - place), abs(work.z - velocity)),
                         **{name: getattr(work, name) / cycles for name in ("events", "rhs", "steps", "roots")},
                         "cycles": cycles})  # fmt: skip
            calls[str(len(rows) - 1)] = call
    for name, seconds in interleaved(calls, rounds).items():
        row = rows[int(name)]
        each = [1e6 * value / row["cycles"] for value in seconds]
        row["us_per_cycle"], row["us_each"] = (
            spread(each),
            [float(f"{value:.5g}") for value in each],
        )
    return rows


def _steady(slider: Slider) -> tuple[float, float]:
    """Return position and velocity at the start of every period of the steady orbit, from closed
    flights.
    """
    cycles = slider.settle + slider.period
    _, u, z = followed(
        slider.band, slider.clearance, slider.restitution, slider.gravity, slider.start, cycles
    )
    return u, z


def _first(call: Callable[[], Work]) -> tuple[Work, float]:
    call()  # compiles
    return peak_memory(call)


def _averaged(slider: Slider, method: Method, setting: float) -> int:
    """Return the number of cycles after settling over which W is averaged: whole periods, two for
    slow methods.
    """
    if method.group == "solve_ivp":
        return 2 * slider.period
    most = (
        COMPILED_CYCLES
        if method.order is None
        else max(int(COMPILED_STEPS / setting), slider.settle)
    )
    return slider.period * max((min(most, COMPILED_CYCLES) - slider.settle) // slider.period, 2)
