"""The interface of a method of the comparison, and its result."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from rig.benchmarks.problems.sliders import Slider


class Work(NamedTuple):
    """Energy lost per cycle, m V^2 (mean over the cycles after `settle`), and the work done in all
    cycles.

    events: impacts, stops and starts. rhs: evaluations of the right-hand side, sin(theta) -
    gravity. steps: of the integrator. roots: iterations for the phases of events. u, z: position
    and velocity after the last cycle.
    """

    energy: float
    events: int
    rhs: int
    steps: int
    roots: int
    u: float
    z: float


class Failed(ArithmeticError):
    """A method cannot solve a problem; the message gives the reason."""


@dataclass(frozen=True)
class Method:
    """An integrator with its ladder of settings, coarse to fine.

    group: "ours", "compiled" or "solve_ivp". knob: meaning of a setting. solve(slider, setting,
    settle, average): follows a slider through settle + average cycles; raises `Failed`. order:
    convergence order in the step, None where a setting is a tolerance.
    """

    name: str
    group: str
    knob: str
    ladder: tuple[float, ...]
    quick: tuple[float, ...]
    solve: Callable[[Slider, float, int, int], Work]
    order: int | None = None
