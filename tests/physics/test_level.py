"""The level loop on plants of known behaviour: lags, scatter, softening, a jump, limits, harmonics."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from rig.drive.level_control import Loop, Target, started, stepped

Plant = Callable[[complex], complex]


class Lag:
    """A linear plant whose phasor follows the command with a first-order lag: `keep` of a
    difference stays a cycle.
    """

    def __init__(self, gain: complex, keep: float) -> None:
        self.gain, self.keep, self.now = gain, keep, 0j

    def __call__(self, command: complex) -> complex:
        self.now = self.gain * command + self.keep * (self.now - self.gain * command)
        return self.now


class Softening:
    """Amplitude times an apparent mass that falls from 50 to 12 kg about 2 m/s^2 over `width`, per
    unit of force.
    """

    def __init__(self, width: float) -> None:
        self.width, self.now = width, 0.1

    def force(self, level: float) -> float:
        return level * (31.0 - 19.0 * math.tanh((level - 2.0) / self.width))

    def __call__(self, command: complex) -> complex:
        for _ in range(200):  # slides along to the nearest stable balance
            self.now += 0.002 * (abs(command) - self.force(self.now))
            self.now = max(self.now, 1e-3)
        return complex(self.now)


def controlled(plant: Plant, target: Target, guess: complex, most: float = math.inf) -> Loop:
    """Run the loop until it has ended; `most` is the command at the voltage limit."""
    loop = started(guess)
    while loop.status == "seeking":
        loop = stepped(
            loop, target, (plant(loop.command[0]),), {"voltage": abs(loop.command[0]) / most}
        )
    return loop


@pytest.mark.parametrize("guess", [0.3, 0.5, 1.0, 1.5])
@pytest.mark.parametrize("keep", [0.0, 0.3, 0.5])
@pytest.mark.parametrize("gain", [1e-3, 2j, -40.0])
def test_a_linear_plant_is_brought_within_one_per_cent_in_thirty_cycles(
    gain: complex, keep: float, guess: float
) -> None:
    target = Target(3.0)
    plant = Lag(gain, keep)
    loop = controlled(plant, target, guess * target.level / abs(gain))
    assert loop.status == "reached"
    assert loop.cycles <= 30
    assert abs(gain * loop.command[0]) == pytest.approx(
        3.0, rel=0.011
    )  # a last bit of the lag may be left
    assert loop.limit == ""


@pytest.mark.parametrize("seed", range(6))
def test_scatter_from_cycle_to_cycle_is_averaged(seed: int) -> None:
    """5 % scatter: a mean of 8 cycles is within 0.7 % of the target, the true level within 4 x 5
    %/sqrt(8) more.
    """
    rng = np.random.default_rng(seed)
    plant = Lag(0.5, 0.3)
    loop = controlled(lambda u: plant(u) * (1 + 0.05 * rng.standard_normal()), Target(5.0), 5.0)
    assert loop.status == "reached"
    assert loop.cycles <= 30
    assert abs(0.5 * loop.command[0]) == pytest.approx(5.0, rel=0.007 + 4 * 0.05 / math.sqrt(8))


@pytest.mark.parametrize("level", [1.0, 1.9, 2.3, 5.0])
def test_a_softening_plant_is_followed_where_one_command_gives_one_level(level: float) -> None:
    """Width 3 m/s^2: the force needed still rises with the level, by d(force)/d(level) > 0
    everywhere.
    """
    plant = Softening(3.0)
    force = [plant.force(x) for x in np.linspace(0.1, 8.0, 200)]
    assert np.all(np.diff(force) > 0)
    loop = controlled(plant, Target(level), 0.5 * 50.0 * level)
    assert loop.status == "reached"
    assert plant.now == pytest.approx(level, rel=0.011)


def test_a_jump_is_seen_and_a_level_inside_it_is_not_called_reached() -> None:
    """Width 0.3: between about 1.9 and 2.4 m/s^2 no command keeps the level; the loop says so, and
    does not hang.
    """
    plant = Softening(0.3)
    assert np.any(np.diff([plant.force(x) for x in np.linspace(1.9, 2.4, 50)]) < 0)
    loop = controlled(plant, Target(2.1, timeout=80), 50.0)
    assert loop.status == "timed out"
    assert loop.jumps > 0
    beyond = controlled(Softening(0.3), Target(5.0), 50.0)
    assert beyond.status == "reached"
    assert beyond.jumps > 0


@pytest.mark.parametrize("most", [0.1, 0.5, 0.9])
def test_a_limit_stops_the_command_and_is_named(most: float) -> None:
    plant = Lag(2.0, 0.4)
    loop = controlled(plant, Target(4.0), 1.0, most=2.0 * most)
    assert (loop.status, loop.limit) == ("limited", "voltage")
    assert abs(loop.command[0]) <= 2.0 * most * 1.01
    assert plant.now.real == pytest.approx(4.0 * most, rel=0.03)


def test_a_limit_that_is_not_needed_is_not_named() -> None:
    loop = controlled(Lag(2.0, 0.4), Target(4.0), 1.0, most=2.2)
    assert (loop.status, loop.limit) == ("reached", "")


def test_a_dead_plant_times_out() -> None:
    loop = controlled(lambda _: 0j, Target(4.0, timeout=20), 1.0)
    assert (loop.status, loop.cycles) == ("timed out", 20)


def test_the_phase_is_held_where_it_is_asked_for() -> None:
    plant = Lag(1.5 * np.exp(2.5j), 0.3)
    target = Target(3.0, phase=-0.5 * math.pi)
    controlled(plant, target, 2.0)
    assert np.angle(plant.now) == pytest.approx(-0.5 * math.pi, abs=0.05)


def test_harmonics_are_driven_out_through_the_response_of_the_box() -> None:
    """The plant adds a distortion of 40 % and 20 %; the box's response is known within 30 %."""
    target, loop = Target(3.0), started(2.0, 3)
    through = (1.5, 0.8 - 0.3j, -0.5j)
    wrong = tuple(1.3 * x for x in through)
    while loop.status == "seeking":
        u = loop.command
        seen = (through[0] * u[0], 1.2 * np.exp(1j) + through[1] * u[1], -0.6 + through[2] * u[2])
        loop = stepped(loop, target, seen, {}, wrong)
    assert loop.status == "reached"
    assert math.hypot(abs(seen[1]), abs(seen[2])) / abs(seen[0]) <= target.flat
