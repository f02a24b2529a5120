"""What a method of the comparison is, and what it gives back."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from rig.benchmarks.problems.sliders import Slider


class Work(NamedTuple):
    """Energy lost per cycle, m V^2 (mean over the cycles behind `settle`), and the work done in all cycles.

    events : impacts, stops and starts; rhs : evaluations of the right-hand side, sin(theta) - gravity; steps : of the
    integrator; roots : iterations towards an event's phase; u, z : place and velocity behind the last cycle
    """

    energy: float
    events: int
    rhs: int
    steps: int
    roots: int
    u: float
    z: float


class Failed(ArithmeticError):
    """A method cannot solve a problem; the message says why."""


@dataclass(frozen=True)
class Method:
    """An integrator with its ladder of settings, coarse to fine.

    group : "ours", "compiled" or "solve_ivp"; knob : what the settings are; solve(slider, setting, settle, average) :
    follows a slider through settle + average cycles; raises `Failed`
    order : by which the error falls with the step, None where a setting is a tolerance
    """

    name: str
    group: str
    knob: str
    ladder: tuple[float, ...]
    quick: tuple[float, ...]
    solve: Callable[[Slider, float, int, int], Work]
    order: int | None = None
