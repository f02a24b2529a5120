"""Shaker-coupled drive in its limits: momentum, a heavy box, stiff and soft stingers, overload; and
how errors fall.
"""

from dataclasses import replace

import numpy as np
import pytest

from rig.beds.janssen_stack import nominal, refill
from rig.catalog.entries import Rig
from rig.drive.amplifier_command import Command
from rig.drive.electrodynamic import XB, V, response
from rig.drive.waveform import Waveform
from rig.protocol.spec import Amplifier, Drive, Layers, Scene
from rig.stand.box import box_mass
from rig.stand.ledger import COLUMNS, COUPLED_COLUMNS
from rig.stand.prescribed import Stand
from rig.stand.shaker import CoupledStand

RATE = 4096 * 20.0
CURRENT = Drive(mode="shaker", amplifier="current")
W_F, W_C = COLUMNS.index("W_f"), COLUMNS.index("W_c")


def weighing(rig: Rig, scene: Scene, mass: float) -> Rig:
    """The rig with a box of this mass, kg."""
    return replace(
        rig, wall_density=rig.wall_density * mass / box_mass(scene.cavity, rig.wall_density)
    )


def closure(stand: CoupledStand) -> np.ndarray:
    """Largest error of both accounts in each cycle since the last call."""
    ledger = stand.drain_ledger()
    return np.abs(
        ledger[:, [COUPLED_COLUMNS.index(name) for name in ("closure", "closure_exciter")]]
    ).max(axis=1)


def test_what_the_gauge_gives_is_the_momentum_of_box_and_bed(rig: Rig, steel: Scene) -> None:
    """Without losses the impulse of the recorded force is the change of momentum, impacts included:
    1e-10 of what has gone through the gauge, which is round-off of 1e5 additions."""
    scene = replace(steel, losses=())
    tested = CoupledStand(scene, rig, CURRENT, nominal(scene, rig), RATE)
    for _ in range(6):
        before = tested.plant.box * tested.state[V] + tested.bed_momentum
        force = tested.advance(Command((15.0 + 0j,), 20.0))[0]
        after = tested.plant.box * tested.state[V] + tested.bed_momentum
        assert after - before == pytest.approx(
            force.sum() / RATE, abs=1e-10 * np.abs(force).sum() / RATE
        )
    assert tested.drain_ledger()[-1, W_C] > 0.0


def test_without_bed_the_coil_moves_the_body_as_much_as_the_rest(rig: Rig, steel: Scene) -> None:
    """Coil, flexure and stinger are between the masses: only the isolation changes their momentum
    together.
    """
    soft = replace(rig.exciter, isolation_stiffness=1e-6, isolation_damping_ratio=0.0)
    scene = replace(steel, bed="empty", losses=())
    tested = CoupledStand(scene, replace(rig, exciter=soft), CURRENT, nominal(scene, rig), RATE)
    tested.advance(Command((10.0 + 0j,), 20.0, 3))
    p, y = tested.plant, tested.state
    parts = np.array([p.armature * y[1], p.body * y[XB + 1], p.box * y[V]])
    assert np.abs(parts).max() > 0.01
    assert parts.sum() == pytest.approx(0.0, abs=1e-10 * np.abs(parts).max())


def test_a_heavier_box_moves_more_as_a_prescribed_would(rig: Rig, steel: Scene) -> None:
    """From the same start W tends to that of the programmed sine, the error falling with the mass
    ratio, to what the step leaves. (From rest, through a ramp, rows settle on other orbits: that is
    the bed's, not the drive's.)"""
    scene = replace(steel, losses=(), layers=Layers(rows=2))
    filling, a, cycles = nominal(scene, rig), 5.0, 3
    prescribed = Stand(scene, rig, Waveform(20.0, a), filling, RATE)
    prescribed.read(4096 * cycles)
    exact = prescribed.drain_ledger()[:cycles, [W_F, W_C]].sum()
    strong = replace(
        rig.exciter, current_peak=1e9, voltage_peak=1e9, stinger_stiffness=1e9, stinger_damping=1e3,
        body_mass=1e6, isolation_stiffness=1e9,
    )  # fmt: skip
    errors = []
    for mass in (3e2, 3e3, 3e4, 3e5):
        heavy = replace(weighing(rig, scene, mass), exciter=strong)
        tested = CoupledStand(scene, heavy, CURRENT, filling, RATE)
        phasor = 1j * a / response(tested.plant, "current", 20.0).acceleration[0]
        command = Command((complex(phasor),), 20.0, cycles)
        tested.begin(command)
        tested.advance(command)
        errors.append(abs(tested.drain_ledger()[:, [W_F, W_C]].sum() / exact - 1.0))
    assert errors[0] > errors[1] > errors[2] > errors[3]
    assert errors[3] < 1e-3


@pytest.mark.parametrize("stiffness", [1e5, 1e7, 1e9])
@pytest.mark.parametrize("mass", [1.0, 30.0, 1000.0])
def test_stiff_and_soft_stingers_on_light_and_heavy_boxes(
    rig: Rig, steel: Scene, stiffness: float, mass: float
) -> None:
    """Bed over box 38, 1.3 and 0.04: no nan, no energy from nothing, and the accounts close to 1e-6
    everywhere.
    """
    scene = replace(steel, layers=Layers(rows=2))
    exciter = replace(rig.exciter, stinger_stiffness=stiffness)
    tested = CoupledStand(
        scene,
        replace(weighing(rig, scene, mass), exciter=exciter),
        CURRENT,
        nominal(scene, rig),
        RATE,
    )
    out = tested.advance(Command((15.0 + 0j,), 20.0, 12))
    assert np.isfinite(out).all()
    ledger = tested.drain_ledger()
    # rows that ride give back what the step takes: |a a'| h^3/12 of their mass, 1e-6 of the heat
    # there is on the way
    assert (
        ledger[:, [W_F, W_C]].min()
        >= -1e-6 * np.abs(ledger[:, COUPLED_COLUMNS.index("W_electric")]).max()
    )
    assert np.abs(ledger[1:, COUPLED_COLUMNS.index("closure")]).max() < 1e-6
    assert np.abs(ledger[1:, COUPLED_COLUMNS.index("closure_exciter")]).max() < 1e-6
    assert np.abs(tested.state).max() < 100.0


@pytest.mark.parametrize(
    ("amplifier", "command", "limit"), [("voltage", 50.0, "current"), ("current", 50.0, "voltage")]
)
def test_an_overload_is_limited_and_flagged(
    rig: Rig, steel: Scene, amplifier: Amplifier, command: float, limit: str
) -> None:
    """Either amplifier meets either limit: it holds there to what one interval lets through, 2 %,
    and says so.
    """
    scene = replace(steel, layers=Layers(rows=2))
    weak = replace(
        rig, exciter=replace(rig.exciter, voltage_peak=60.0 if amplifier == "voltage" else 8.0)
    )
    tested = CoupledStand(
        scene,
        weak,
        Drive(mode="shaker", amplifier=amplifier),
        nominal(scene, rig),
        RATE,
        names=("voltage", "current"),
    )
    out = tested.advance(Command((command + 0j,), 20.0, 12))
    voltage, current = np.abs(out).max(axis=1)
    assert voltage <= 1.02 * weak.exciter.voltage_peak
    assert current <= 1.02 * weak.exciter.current_peak
    assert tested.limits[0].clipped == 0.0
    assert tested.limits[-1].clipped > 0.3
    assert getattr(tested.limits[-1], limit) == pytest.approx(1.0, abs=0.02)
    assert closure(tested)[1:].max() < 1e-6


def test_the_account_closes_with_the_fourth_power_of_the_interval(rig: Rig, steel: Scene) -> None:
    """The quadrature's order, on the ringing of the stinger: half the interval, a sixteenth of the
    error (+-20 %).
    """
    scene = replace(steel, layers=Layers(rows=2))
    found = []
    for refine in (1, 2):
        tested = CoupledStand(scene, rig, CURRENT, nominal(scene, rig), RATE, refine=refine)
        tested.advance(Command((15.0 + 0j,), 20.0, 6))
        found.append(closure(tested)[2:].mean())
    assert found[0] < 1e-6
    assert found[0] / found[1] == pytest.approx(16.0, rel=0.2)


def test_heat_converges_with_the_step(rig: Rig, steel: Scene) -> None:
    """Root mean square over four refills, against 1/32 of the step: first order at least, 1e-3 at
    the default step and less in proportion to it (where in a step a slip begins is chance, so
    single errors scatter below that line); two cycles, before small differences grow (rows are
    chaotic)."""
    scene = replace(steel, losses=(), layers=Layers(rows=2))
    refines = np.array([1, 2, 4, 8, 32])
    heat = np.zeros((4, refines.size))
    for seed, k in np.ndindex(heat.shape):
        filling = refill(scene, rig, np.random.default_rng(seed))
        tested = CoupledStand(scene, rig, CURRENT, filling, RATE, refine=int(refines[k]))
        tested.advance(Command((8.0 + 0j,), 20.0, 2))
        heat[seed, k] = tested.drain_ledger()[:, [W_F, W_C]].sum()
    errors = np.sqrt(np.mean((heat[:, :-1] / heat[:, -1:] - 1.0) ** 2, axis=0))
    assert (errors * refines[:-1] < 1e-3).all()
