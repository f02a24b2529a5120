"""Fixed-step methods of first order as methods of the comparison, with their sines from a table."""

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from rig.benchmarks.methods.method import Method, Work
from rig.benchmarks.problems.sliders import Slider
from rig.kernels.waveform import Array

LADDER = (100, 400, 1600, 6400, 25600, 102400, 409600)
QUICK = (100, 800, 6400, 51200)
"""Steps per cycle."""

Run = Callable[..., tuple[float, int, int, int, int, float, float]]


@lru_cache
def sines(steps: int, place: float) -> Array:
    """Return the drive in every step of a cycle, evaluated at the fraction `place` of the step."""
    return np.asarray(np.sin(2.0 * np.pi / steps * (np.arange(steps) + place)))


def first_order(name: str, run: Run, place: float) -> Method:
    """Return a method from its compiled loop.

    run(band, clearance, restitution, gravity, u, z, sine, settle, average) returns the fields of
    `Work`; sine: `sines` at `place`, the fraction of a step at which the method evaluates the
    drive.
    """

    def solve(slider: Slider, setting: float, settle: int, average: int) -> Work:
        _, u, z = slider.start
        return Work(
            *run(
                slider.band,
                slider.clearance,
                slider.restitution,
                slider.gravity,
                u,
                z,
                sines(int(setting), place),
                settle,
                average,
            )
        )

    return Method(name, "compiled", "steps per cycle", LADDER, QUICK, solve, order=1)
