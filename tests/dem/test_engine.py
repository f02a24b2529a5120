"""Stretches, account and failures of the engine on LAMMPS, and the test of its walls."""

from dataclasses import replace

import numpy as np
import pytest
from grains_scenes import (
    MASS,
    PAIR_TIME,
    RADIUS,
    G,
    balls,
    box,
    cycles,
    down,
    hertzian,
    linear,
    shaken,
    steps_of,
    still,
)

from rig.errors import InputError
from rig.kernels.grains.arrays import Law, Room
from rig.kernels.grains.engine import Engine, LostGrains, Packing
from rig.lammps_engine.account import normal_energy
from rig.lammps_engine.commands import LammpsCommands, commands
from rig.lammps_engine.engine import LammpsEngine
from rig.lammps_engine.process import LammpsFailed, LammpsProcess
from rig.lammps_engine.wall_test import try_walls

DT = PAIR_TIME / 14.0
LAWS = (linear(0.6, 0.3), linear(1.0, 0.0), linear(0.2, 0.3), hertzian(0.4, 0.3), hertzian())


def test_many_stretches_are_one() -> None:
    """What a stretch ends with continues to rounding in the next: kicks, springs, lists."""
    scene = shaken("horizontal")
    motion = cycles(scene.acceleration, 1, steps_of(1.0 / 14.0))[:701]
    with LammpsEngine(scene.packing, scene.law, scene.room, DT) as one:
        whole = one.advance(motion)
        end = one.packing()
    with LammpsEngine(scene.packing, scene.law, scene.room, DT) as many:
        parts = [many.advance(motion[a : b + 1]) for a, b in ((0, 1), (1, 300), (300, 700))]
        np.testing.assert_allclose(many.packing().place, end.place, rtol=0.0, atol=1e-13)
        np.testing.assert_allclose(many.packing().spin, end.spin, rtol=0.0, atol=1e-8)
    impulse = np.concatenate([[0.0], *(part.impulse[1:] for part in parts)])
    np.testing.assert_allclose(impulse, whole.impulse, rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("name", ["horizontal", "vertical"])
def test_the_account_is_that_of_our_engine(name: str) -> None:
    """The work of the box is what the grains have and have lost. On LAMMPS what tangential springs
    hold counts as lost; our engine knows it: all elastic energy less that of normal springs."""
    scene = shaken(name)
    motion = cycles(scene.acceleration, 1, steps_of(1.0 / 14.0))[:1501]
    own = Engine(scene.packing, scene.law, scene.room, DT)
    ours = own.advance(motion)
    with LammpsEngine(scene.packing, scene.law, scene.room, DT) as other:
        theirs = other.advance(motion)
    assert theirs.work == pytest.approx(ours.work, abs=1e-9)
    assert np.isnan(theirs.loss).all()
    held = ours.energy[3] - normal_energy(own.packing(), scene.law, scene.room)
    assert held > 0.0
    assert theirs.lost == pytest.approx(float(ours.loss.sum()) + held, rel=1e-6)


@pytest.mark.parametrize("law", LAWS)
def test_our_walls_pass(law: Law) -> None:
    with LammpsProcess(1) as process:
        try_walls(process, law, RADIUS, MASS, DT)


def test_walls_without_a_tangential_spring_are_refused() -> None:
    """The classic tangential law of this release, as its classic walls have it."""

    def classic(
        packing: Packing, law: Law, room: Room, dt: float, file: str, turning: bool = True
    ) -> LammpsCommands:
        given = commands(packing, law, room, dt, file, turning)
        lines = (line.replace("linear_history", "linear_history_classic") for line in given.after)
        return replace(given, after=tuple(lines))

    with LammpsProcess(1) as process, pytest.raises(InputError, match="do not hold a ball"):
        try_walls(process, linear(0.6, 0.3), RADIUS, MASS, DT, classic)


def test_walls_that_return_a_ball_wrongly_are_refused() -> None:
    def stiff(
        packing: Packing, law: Law, room: Room, dt: float, file: str, turning: bool = True
    ) -> LammpsCommands:
        elastic = law._replace(wall_damping=0.0) if turning else law
        return commands(packing, elastic, room, dt, file, turning)

    with LammpsProcess(1) as process, pytest.raises(InputError, match=r"instead of 0\.6"):
        try_walls(process, linear(0.6, 0.3), RADIUS, MASS, DT, stiff)


def test_a_pushed_ball_rolls_without_slip() -> None:
    """5/7 of the push, and the spin of that speed; the spring of the contact swings by .1 %."""
    law = linear(0.6, 0.5)
    room = box(gravity=(0.05 * G, 0.0, -G))
    place = [[0.05, 0.05, RADIUS - MASS * G / law.wall_stiffness]]
    steps = round(0.1 / DT)
    with LammpsEngine(balls(place, np.zeros((1, 3))), law, room, DT) as engine:
        engine.advance(still(steps))
        found = engine.packing()
    speed = 5.0 / 7.0 * 0.05 * G * steps * DT
    assert found.velocity[0, 0] == pytest.approx(speed, rel=2e-3)
    assert found.spin[0, 1] * RADIUS == pytest.approx(speed, rel=2e-3)


def test_a_step_that_is_too_long_is_told() -> None:
    place = [[0.05, 0.05, 1.2 * RADIUS]]
    engine = LammpsEngine(balls(place, [[0.0, 0.0, -1.0]]), linear(), box(), DT)
    with pytest.raises(LostGrains, match="step is too long"):
        engine.advance(np.linspace(0.0, 1e6, 2001))


def test_what_lammps_says_is_passed_on() -> None:
    with LammpsProcess(1) as process, pytest.raises(LammpsFailed, match="Unknown command"):
        process.ask(
            {
                "do": "open",
                "before": np.array(["nonsense 1"]),
                "axis": 0,
                "dt": 1.0,
            }
        )


def test_weight_along_the_axis_and_an_empty_cavity() -> None:
    """A ball at rest on the floor: the wall's force is its weight, and no work is done."""
    law = linear(0.6, 0.3)
    place = [[0.05, 0.05, RADIUS - MASS * G / law.wall_stiffness]]
    room = box(axis=2, gravity=down(), pitch=0.2, cavities=2)
    with LammpsEngine(balls(place, np.zeros((1, 3))), law, room, DT) as engine:
        engine.advance(still(2000))
        end = engine.advance(still(100))
    assert end.force == pytest.approx(MASS * G, rel=1e-3)
    assert end.impulse[-1] - end.impulse[0] == pytest.approx(100 * DT * MASS * G, rel=1e-3)
    assert end.work == 0.0
