"""Steppers of fixed step and first order, under the name of a method of the comparison."""

from collections.abc import Callable

from rig.benchmarks.methods.method import Method, Work
from rig.benchmarks.sliders import Slider

LADDER = (100, 400, 1600, 6400, 25600, 102400, 409600)
QUICK = (100, 800, 6400, 51200)
"""Steps per cycle."""

Run = Callable[..., tuple[float, int, int, int, int, float, float]]


def first_order(name: str, run: Run) -> Method:
    """run(band, play, restitution, gravity, u, z, steps, settle, average) -> the fields of `Work`."""

    def solve(slider: Slider, setting: float, settle: int, average: int) -> Work:
        _, u, z = slider.start
        return Work(
            *run(
                slider.band, slider.play, slider.restitution, slider.gravity, u, z, int(setting), settle, average
            )
        )  # fmt: skip

    return Method(name, "compiled", "steps per cycle", LADDER, QUICK, solve, order=1)
