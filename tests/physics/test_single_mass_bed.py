"""Bed `single_mass` in the stand and in W_T: joules against closed forms, ledger, static weight,
and orbits that jump.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from rig.beds.janssen_stack import Filling, bed_mass, nominal, refill
from rig.beds.single_mass import SingleMassBed, free_gap, single_mass
from rig.catalog.entries import Rig
from rig.drive.waveform import Sampling, Waveform, waveform
from rig.errors import InputError
from rig.prediction.document import model_row, prediction_document
from rig.prediction.model import predict, predict_about
from rig.prediction.own import READ, SINGLE_MASS_LEVELS, misread
from rig.protocol.spec import Acquire, Axis, Cavity, Condition, Drive, Grains, Scene, SingleMass
from rig.stand.box import box_mass
from rig.stand.ledger import CLOSES, COLUMNS
from rig.stand.prescribed import Stand
from rig.theory.single_mass import plastic_energy

CYCLE = 4096
RATE = CYCLE * 20.0
OMEGA = 2 * np.pi * 20.0
G = 9.80665
LOSS = [COLUMNS.index(name) for name in ("W_f", "W_c", "W_viscous", "W_noise", "W_air", "dKE_bed")]


def scene_of(axis: Axis, losses: tuple[str, ...] = (), **settings: object) -> Scene:
    """A small box with 0.4 kg of steel."""
    cavity = Cavity(length=0.06, width=0.06, height=0.1, wall=0.003)
    grains = Grains(density=7900.0, diameter=0.002, fill=0.2)
    return Scene(
        cavity=cavity,
        axis=axis,
        grains=grains,
        bed="single_mass",
        losses=losses,
        single_mass=SingleMass(**settings),
    )  # type: ignore[arg-type]


def condition(scene: Scene, acceleration: float) -> Condition:
    return Condition("c01", scene, Drive(acceleration=acceleration), Acquire(), "")


def test_the_gap_is_what_the_fill_leaves(rig: Rig) -> None:
    """(1 - w) H above a settled bed, whatever its packing; L (1 - w phi_b/phi_f) beside one on a
    horizontal axis, nothing above w = phi_f/phi_b there.
    """
    scene = scene_of("vertical")
    filling = nominal(scene, rig)
    for axis in ("vertical", "zero_gravity"):
        for packing in (0.6, 0.63, 0.66):
            found = free_gap(replace(scene, axis=axis), rig, Filling(packing, 1.0))
            assert found == pytest.approx(0.1 * (1 - 0.2), rel=1e-12)
    across = replace(scene, axis="horizontal")
    assert free_gap(across, rig, filling) == pytest.approx(0.06 * (1 - 0.2 * 0.63 / 0.57))
    dense = replace(across, grains=replace(scene.grains, fill=0.91))
    assert free_gap(dense, rig, filling) == 0.0
    full = replace(scene, grains=replace(scene.grains, fill=1.0))
    assert free_gap(full, rig, filling) == 0.0
    point = predict(condition(full, 3 * G), rig)
    assert (point.W_T, point.carried, point.period) == (0.0, True, 1)


@pytest.mark.parametrize("level", [3.31, 3.5, 3.7])
def test_joules_of_a_locked_single_mass(rig: Rig, level: float) -> None:
    """W_T = 2 pi^2 m g^2/w^2, whatever the level; bound m g V/f."""
    scene = scene_of("vertical")
    point = predict(condition(scene, level * G), rig)
    mass = 0.63 * 7900.0 * 0.06 * 0.06 * 0.1 * 0.2
    assert point.bed_mass == pytest.approx(mass, rel=1e-12)
    energy = point.W_T
    assert energy == pytest.approx(2 * np.pi**2 * mass * (G / OMEGA) ** 2, rel=1e-9)
    assert point.bound == pytest.approx(mass * G * level * G / OMEGA / 20.0, rel=1e-12)
    assert (point.W_f, point.W_T_as_printed, point.periodic_share) == (0.0, None, 1.0)


def test_joules_without_weight_and_on_a_rough_floor(rig: Rig) -> None:
    unit = bed_mass(scene_of("vertical"), rig.packing_shaken) * (10.0 / OMEGA) ** 2
    floating = predict(condition(scene_of("zero_gravity", gap=0.0015), 10.0), rig)
    t = brentq(lambda t: t - np.sin(t) - 0.0015 * OMEGA**2 / 10.0, 0.5, np.pi, xtol=1e-15)
    energy = floating.W_T
    assert energy == pytest.approx((1 - np.cos(t)) ** 2 * unit, rel=1e-9)
    assert floating.bound == pytest.approx(4 * unit, rel=1e-12)
    eta = 0.3 * G / 10.0
    block = predict(condition(scene_of("horizontal", gap="none", friction=0.3), 10.0), rig)
    assert block.W_f == pytest.approx(
        4 * eta * np.sqrt(1 - (np.pi * eta / 2) ** 2) * unit, rel=1e-9
    )
    assert block.W_c == 0.0


def test_what_is_carried_and_what_floats(rig: Rig) -> None:
    """Below 1 g, or held by friction, the mass rides; between no walls it does not, though it loses
    nothing.
    """
    riding = [(scene_of("vertical"), 0.9 * G), (scene_of("horizontal", friction=1.1), G)]
    assert all(predict(condition(scene, a), rig).carried for scene, a in riding)
    floating = predict(condition(scene_of("zero_gravity", gap="none"), 10.0), rig)
    assert (floating.W_T, floating.carried) == (0.0, False)


def test_an_elastic_single_mass_has_no_bound(rig: Rig) -> None:
    asked = condition(scene_of("zero_gravity", gap=0.001, restitution=1.0), 10.0)
    point, table = predict_about(asked, rig)
    assert point.bound == math.inf
    assert model_row(asked, point)["bound"] is None
    assert prediction_document({"c01": (point, table)})["conditions"]["c01"]["bound"] is None


def test_a_jump_between_orbits_is_an_uncertainty(rig: Rig) -> None:
    """At 2 g neighbours 0.2 % apart predict each level; near 4.6 g the long flights of period 2
    lose their landing, and W falls to a hundredth within 2 %."""
    smooth, _ = predict_about(condition(scene_of("vertical"), 2.0 * G), rig)
    steep, table = predict_about(condition(scene_of("vertical"), 4.59 * G), rig)
    near = [2.0 * level for level in SINGLE_MASS_LEVELS[9:22]]
    exact = [plastic_energy(level) * level**2 for level in near]
    assert smooth.u_rel < 1e-5
    assert smooth.u_levels == pytest.approx(
        READ * misread(near, exact) / exact[6], rel=1e-3
    )  # 1e-5: a curve, no jump
    assert steep.u_levels > 1e-2
    assert (steep.period, len(table["W_T"])) == (2, 31)


@given(
    axis=st.sampled_from(["vertical", "zero_gravity", "horizontal"]),
    acceleration=st.floats(1.0, 60.0),
    e=st.floats(0.0, 0.95),
    friction=st.floats(0.0, 1.5),
    gap=st.sampled_from([None, "none", 0.0, 1e-5, 1e-3]),
    start=st.floats(0.0, 0.02),
    velocity=st.floats(-0.5, 0.5),
    seed=st.integers(0, 2**32),
)
@example(
    axis="vertical", acceleration=1.0, e=0.0, friction=0.0, gap=0.0, start=0.0, velocity=0.5, seed=0
)
@settings(max_examples=40, deadline=None)
def test_the_account_closes_in_the_stand(
    rig: Rig,
    axis: Axis,
    acceleration: float,
    e: float,
    friction: float,
    gap: object,
    start: float,
    velocity: float,
    seed: int,
) -> None:
    friction = friction if axis == "horizontal" else 0.0
    scene = scene_of(
        axis, ("noise",), restitution=e, friction=friction, gap=gap, start=start, velocity=velocity
    )  # start above the lid is at the lid
    rng = np.random.default_rng(seed)
    motion = waveform(Drive(acceleration=acceleration), 0.003, 0.01, rng)
    stand = Stand(scene, rig, motion, refill(scene, rig, rng), 512 * 20.0)
    signal = stand.read(10 * 512)
    ledger = stand.drain_ledger()
    assert np.isfinite(signal).all()
    assert np.isfinite(ledger).all()
    assert np.abs(ledger[:, COLUMNS.index("closure")]).max() < CLOSES
    assert (ledger[:, LOSS[:5]] >= 0.0).all()


def test_the_gauge_carries_the_weight_and_cords_take_it(rig: Rig) -> None:
    """The mean force over whole cycles is (M_box + m_gauge + m) g; its work is nothing. With cords
    it is zero.
    """
    scene, motion = scene_of("vertical"), Waveform(20.0, 2.0 * G)
    total = (
        box_mass(scene.cavity, rig.wall_density)
        + rig.gauge_mass
        + bed_mass(scene, rig.packing_shaken)
    )
    stand = Stand(scene, rig, motion, nominal(scene, rig), RATE)
    force = stand.read(21 * CYCLE)[0, CYCLE:]
    assert force.mean() == pytest.approx(total * rig.gravity, rel=1e-9)
    hung = Stand(replace(scene, support="cords"), rig, motion, nominal(scene, rig), RATE)
    # the box's own inertia, 80 N, cancels over whole cycles to rounding
    assert abs(hung.read(21 * CYCLE)[0, CYCLE:].mean()) < 1e-9 * total * rig.gravity


@pytest.mark.parametrize(
    ("axis", "acceleration"), [("vertical", 2.0 * G), ("zero_gravity", 10.0), ("vertical", 3.5 * G)]
)
def test_the_records_hold_the_ledgers_work(rig: Rig, axis: Axis, acceleration: float) -> None:
    """Closed-loop integral of force and velocity against losses + dKE_bed.

    A hit counts whole in its interval: its phase is off by h/2 = pi/4096 at most, the box's
    velocity there by as much of V: m u V pi/4096 of m u^2/2 each, for u >= V 1.5e-3 at most.
    """
    scene = scene_of(axis, gap=0.0015 if axis == "zero_gravity" else None)
    motion = Waveform(20.0, acceleration)
    stand = Stand(scene, rig, motion, nominal(scene, rig), RATE)
    force, seen = stand.read(12 * CYCLE)[:, -8 * CYCLE :]
    spectra = (np.fft.rfft(x)[8::8] * 2 / (8 * CYCLE) for x in (force, seen))
    F, A = spectra
    work = float(-np.pi / motion.omega**2 * np.sum((F * A.conj()).imag / np.arange(1, F.size + 1)))
    true = stand.drain_ledger()[4:12, LOSS].sum(axis=1).mean()
    assert work == pytest.approx(true, rel=1.6e-3)


def test_a_single_mass_that_rests_at_the_cycle_start_repeats_to_the_last_bit(rig: Rig) -> None:
    scene = scene_of("vertical")
    bed = SingleMassBed(
        single_mass(scene, rig, nominal(scene, rig)), Sampling(Waveform(20.0, 2.0 * G), 512.0)
    )
    turns = [bed.advance(2) for _ in range(4)]
    assert [turn.repeats for turn in turns] == [0, 2, 2, 2]
    np.testing.assert_array_equal(turns[2].momentum, turns[1].momentum)
    np.testing.assert_array_equal(turns[2].work, turns[1].work)


def test_bouncing_without_end_is_a_named_error(rig: Rig) -> None:
    scene = scene_of("vertical", restitution=1.0, velocity=1e-9)
    for ask in (
        lambda: predict(condition(scene, 0.5 * G), rig),
        lambda: Stand(scene, rig, Waveform(20.0, 0.5 * G), nominal(scene, rig), RATE).read(10),
    ):
        with pytest.raises(InputError, match=r"scene\.single_mass.*events.*65536 in one cycle"):
            ask()
