"""Loss channels against their closed forms and their force against their energy."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rig.beds.janssen_stack import nominal, stack
from rig.catalog.entries import Rig
from rig.catalog.rig_file import load_rig
from rig.drive.losses import (
    LOST,
    Losses,
    by_order,
    drag_of_box,
    friction_energy,
    loss_coefficients,
    mean_cord_force,
    mean_force,
    mean_sign,
    over_first_principles,
    quadratic_energy,
    sound_of_box,
    structural_energy,
    way,
)
from rig.drive.waveform import Waveform, viscous_energy
from rig.kernels.rows.one_row import RowSet
from rig.kernels.rows.slip_moments import slip_moments
from rig.kernels.waveform import crossings, extrema
from rig.protocol.spec import Cavity, Scene
from rig.stand.box import box_mass, losses_of
from rig.stand.gas import LEAST_SHARE, ergun, gas_damping, gas_energy, share_of_weight
from rig.stand.ledger import CLOSES, COLUMNS
from rig.stand.prescribed import Stand

SINE = Waveform(20.0, 5.0)
IMPERFECT = Waveform(20.0, 5.0, (1.0, 0.0, 0.1), (0.0, 0.0, 0.05))
CYCLE = 4096


def test_viscous_loss_of_a_sine() -> None:
    assert viscous_energy(7.0, SINE) == pytest.approx(
        np.pi * 7.0 * SINE.omega * SINE.length_unit**2, rel=1e-13
    )


def test_quadratic_loss_of_a_sine() -> None:
    """8/3 k w^2 X^3; |v|^3 has a jump in its third derivative: midpoint error O(n^-4) at 4096
    points.
    """
    exact = 8.0 / 3.0 * 7.0 * SINE.omega**2 * SINE.length_unit**3
    assert quadratic_energy(7.0, SINE) == pytest.approx(exact, rel=1e-10)


def test_friction_and_structural_loss_of_a_sine() -> None:
    """4 f X and pi eta k X^2."""
    assert friction_energy(3.0, SINE) == pytest.approx(4.0 * 3.0 * SINE.length_unit, rel=1e-13)
    assert structural_energy(900.0, SINE) == pytest.approx(
        np.pi * 900.0 * SINE.length_unit**2, rel=1e-13
    )


@given(st.floats(1.0, 60.0), st.floats(0.5, 20.0))
@settings(max_examples=20, deadline=None)
def test_the_mount_does_not_know_the_frequency(frequency: float, acceleration: float) -> None:
    """At equal stroke, friction and structural damping take the same energy at any frequency."""
    slow = Waveform(1.0, acceleration)
    fast = Waveform(frequency, acceleration * frequency**2)
    for energy in (friction_energy, structural_energy):
        assert energy(2.0, fast) == pytest.approx(energy(2.0, slow), rel=1e-12)


def test_the_way_counts_every_turning_point() -> None:
    """A strong third harmonic turns the box six times a cycle: extrema of the position on a fine
    grid, off by (pi/2^20)^2/2 = 5e-12 of it each."""
    motion = Waveform(20.0, 5.0, (1.0, 0.0, 6.0), (0.0, 0.0, 2.0))
    position = motion.at(2 * np.pi * np.arange(2**20 + 1) / 2**20)[0]
    assert way(motion) == pytest.approx(float(np.abs(np.diff(position)).sum()), rel=1e-10)


@pytest.mark.parametrize(
    "losses",
    [
        Losses(noise=50.0),
        Losses(air=3000.0),
        Losses(50.0, 3000.0),
        Losses(gas=4.0),
        Losses(guide=3.0),
    ],
)
@pytest.mark.parametrize("motion", [SINE, IMPERFECT])
def test_mean_force_does_the_work_of_its_channel(losses: Losses, motion: Waveform) -> None:
    # an odd shift: turning points fall inside intervals
    position, velocity = motion.at(2 * np.pi * (np.arange(CYCLE + 1) + 0.31) / CYCLE)
    force = mean_force(losses, position, velocity, 1.0 / (motion.frequency * CYCLE))
    done = -float(np.sum(force * np.diff(position)))
    # means of F and v multiply: (w h)^2/12 relative per harmonic, 2e-7 for the first, 2e-6 for the
    # third
    assert done == pytest.approx(float(losses.energies(motion).sum()), rel=3e-6)


@pytest.mark.parametrize("motion", [SINE, IMPERFECT])
def test_cords_do_the_work_of_structural_damping(motion: Waveform) -> None:
    phase = 2 * np.pi * np.arange(CYCLE + 1) / CYCLE
    force = mean_cord_force(
        800.0, motion.omega, by_order(motion).at(phase)[0], 1.0 / (motion.frequency * CYCLE)
    )
    done = -float(np.sum(force * np.diff(motion.at(phase)[0])))
    assert done == pytest.approx(structural_energy(800.0, motion), rel=3e-6)  # as above


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_mean_sign_is_the_integral_of_the_sign(before: float, after: float) -> None:
    """Over a straight velocity, against 10001 midpoints: one of them may fall on the wrong side."""
    share = (np.arange(10001) + 0.5) / 10001
    fine = float(np.mean(np.sign(before + (after - before) * share)))
    assert mean_sign(np.array([before, after]))[0] == pytest.approx(fine, abs=2.5e-4)


def test_a_box_at_rest_feels_no_friction() -> None:
    assert (mean_sign(np.zeros(4)) == 0.0).all()


@pytest.mark.parametrize("support", ["guide", "cords"])
@pytest.mark.parametrize("bed", ["empty", "locked", "layers"])
def test_the_mount_takes_its_closed_form_of_the_moving_mass(
    rig: Rig, steel: Scene, support: str, bed: str
) -> None:
    """4 mu M g X and pi eta k X^2, k of the 2 Hz mode, M of box, gauge side and bed; nothing where
    it is not listed.
    """
    scene = replace(steel, bed=bed, losses=("mount",), support=support)
    grains = 0.0 if bed == "empty" else stack(scene, rig, nominal(scene, rig)).mass
    mass = box_mass(scene.cavity, rig.wall_density) + rig.gauge_mass + grains
    X = SINE.length_unit
    expected = {
        "guide": 4.0 * rig.guide_friction * mass * rig.gravity * X,
        "cords": np.pi
        * rig.cord_loss_factor
        * mass
        * (2.0 * np.pi * rig.cord_frequency) ** 2
        * X**2,
    }[support]
    stand = Stand(scene, rig, SINE, nominal(scene, rig), CYCLE * 20.0)
    signal = stand.read(8 * CYCLE)
    ledger = stand.drain_ledger()[:8]
    assert ledger[:, COLUMNS.index("W_mount")] == pytest.approx(np.full(8, expected), rel=1e-12)
    assert np.abs(ledger[:, COLUMNS.index("closure")]).max() < CLOSES
    bare = Stand(replace(scene, losses=()), rig, SINE, nominal(scene, rig), CYCLE * 20.0).read(
        8 * CYCLE
    )
    velocity = SINE.velocity_unit * np.cos(2 * np.pi * (np.arange(8 * CYCLE) + 0.5) / CYCLE)
    done = float(np.mean((signal[0] - bare[0])[: 4 * CYCLE] * velocity[: 4 * CYCLE])) / 20.0
    # the first interval ends one edge late; interval means against points: (2 pi/4096)^2/24 = 1e-7
    assert done == pytest.approx(expected, rel=1e-6)
    assert (signal[1] == bare[1]).all()


@pytest.mark.parametrize(
    ("losses", "support"), [((), "guide"), (("noise", "air"), "cords"), (("mount",), "none")]
)
def test_the_mount_is_off_unless_listed_and_supported(
    rig: Rig, steel: Scene, losses: tuple[str, ...], support: str
) -> None:
    found = losses_of(replace(steel, losses=losses, support=support), rig, 50.0, 20.0)
    assert found.guide == found.cords == 0.0


@given(st.floats(0.02, 1.0), st.floats(0.2, 5.0), st.floats(5.0, 200.0), st.floats(0.2, 5.0))
def test_losses_of_the_clean_rig_grow_as_sound_and_drag_do(
    side: float, larger: float, frequency: float, faster: float
) -> None:
    """Dipole sound of a box: the square of the mass of air that it moves, w^4; drag: its face, no w."""
    clean = load_rig("clean")
    box = Cavity(side, 1.5 * side, 2.0 * side, 0.1 * side)
    grown = Cavity(*(larger * edge for edge in (side, 1.5 * side, 2.0 * side, 0.1 * side)))
    here, there = (
        losses_of(Scene(cavity=cavity, losses=("noise", "air")), clean, 1.0, f)
        for cavity, f in ((box, frequency), (grown, faster * frequency))
    )
    assert there.noise == pytest.approx(here.noise * larger**6 * faster**4, rel=1e-12)
    assert there.air == pytest.approx(here.air * larger**2, rel=1e-12)
    told = over_first_principles(loss_coefficients(clean, box, frequency), box, frequency)
    assert told == {"noise": 1.0, "air": 1.0}


def test_the_clean_rigs_stand_loses_sound_and_drag_and_no_more(steel: Scene) -> None:
    """pi c w X^2 and 8/3 k w^2 X^3 of the outer box, in the ledger; a rig file's own value instead."""
    scene, clean = replace(steel, bed="empty", losses=("noise", "air")), load_rig("clean")
    outer = (0.41, 0.16, 0.16)
    sound, drag = sound_of_box(*outer, SINE.omega), drag_of_box(0.41, 0.16)
    for rig, viscous in ((clean, sound), (replace(clean, loss_noise=3.0), 3.0)):
        stand = Stand(scene, rig, SINE, nominal(scene, rig), 20.0 * CYCLE)
        stand.read(2 * CYCLE)
        ledger = stand.drain_ledger()
        X = SINE.length_unit
        noise, air = (ledger[:, COLUMNS.index(name)] for name in ("W_noise", "W_air"))
        assert noise == pytest.approx(np.pi * viscous * SINE.omega * X**2, rel=1e-12)
        assert air == pytest.approx(8.0 / 3.0 * drag * SINE.omega**2 * X**3, rel=1e-10)


def test_every_channel_has_a_column() -> None:
    energies = Losses(1.0, 1.0, 1.0, 1.0, 1.0).energies(SINE)
    assert energies.shape == (len(LOST),)
    assert set(LOST) <= set(COLUMNS)
    assert (energies > 0).all()


@pytest.mark.parametrize("clearance", [0.05, 0.7, 2.0, 3.1])
def test_slip_moments_of_a_plastic_row_without_friction(clearance: float) -> None:
    """It leaves one wall at each reversal of a, z = 1 - cos t, and lands where t - sin t is the
    clearance (clearance < pi).
    """
    lo, hi = 0.0, np.pi
    for _ in range(80):
        mid = 0.5 * (lo + hi)
        lo, hi = (mid, hi) if mid - np.sin(mid) < clearance else (lo, mid)
    t = lo
    P, Q = np.ones(1), np.zeros(1)
    band = np.array([1e-12])
    rows = RowSet(
        np.zeros(1, np.int64),
        np.array([clearance]),
        0.0,
        band,
        crossings(band, P, Q, extrema(P, Q)).tables,
    )
    second, third, peak = slip_moments(rows, P, Q)
    sine, double = np.sin(t), np.sin(2.0 * t)
    # Gauss on trigonometric polynomials, 12 points over half a cycle at most: below 1e-9
    assert second == pytest.approx(2.0 * (1.5 * t - 2.0 * sine + 0.25 * double), rel=1e-8)
    assert third == pytest.approx(
        2.0 * (2.5 * t - 4.0 * sine + 0.75 * double + sine**3 / 3.0), rel=1e-8
    )
    assert peak == pytest.approx(1.0 - np.cos(t), rel=1e-9)


def test_ergun_at_one_point() -> None:
    """4 mm, 37 % voids, 0.1 m/s: 150 mu .63^2/(.37^3 d^2) U = 132.96 and 1.75 rho .63/(.37^3 d) U^2
    = 65.51 Pa/m.
    """
    viscous, inertial = ergun(0.004, 0.63)
    assert 0.1 * viscous == pytest.approx(132.96, rel=1e-4)
    assert 0.01 * inertial == pytest.approx(65.51, rel=1e-4)


def test_gas_does_not_know_the_grains_density_and_finer_grains_feel_it_more(
    rig: Rig, steel: Scene
) -> None:
    fine, light = (
        replace(steel, grains=replace(steel.grains, **change))
        for change in ({"diameter": 1e-3}, {"density": 3400.0})
    )
    energy = {name: gas_energy(s, rig, nominal(s, rig), SINE) for name, s in
              (("steel", steel), ("fine", fine), ("light", light))}  # fmt: skip
    assert energy["light"] == pytest.approx(energy["steel"], rel=1e-9)
    assert energy["fine"] > energy["steel"] > 0.0
    shares = [share_of_weight(s, rig, 5.0, 20.0) for s in (steel, light, fine)]
    assert shares[1] == pytest.approx(shares[0] * 7900.0 / 3400.0, rel=1e-9)
    assert shares[0] < LEAST_SHARE < shares[2]


def test_gas_is_switched_on_by_its_share_of_the_weight(rig: Rig, steel: Scene) -> None:
    """Off below 1 %: no force at all. On, the ledger holds Ergun's energy, and so does the force at
    the gauge.
    """
    assert gas_damping(steel, rig, nominal(steel, rig), SINE) == 0.0
    fine = replace(steel, grains=replace(steel.grains, diameter=1e-3), losses=("gas",))
    filling = nominal(fine, rig)
    signals = []
    for scene in (fine, replace(fine, losses=())):
        stand = Stand(scene, rig, SINE, filling, CYCLE * 20.0)
        signals.append(stand.read(8 * CYCLE))
        ledger = stand.drain_ledger()[:8]
        expected = gas_energy(fine, rig, filling, SINE) if scene.losses else 0.0
        assert ledger[:, COLUMNS.index("W_gas")] == pytest.approx(np.full(8, expected), rel=1e-12)
        assert np.abs(ledger[:, COLUMNS.index("closure")]).max() < CLOSES
    velocity = SINE.velocity_unit * np.cos(2 * np.pi * (np.arange(4 * CYCLE) + 0.5) / CYCLE)
    done = float(np.mean((signals[0][0] - signals[1][0])[: 4 * CYCLE] * velocity)) / 20.0
    assert done == pytest.approx(
        gas_energy(fine, rig, filling, SINE), rel=1e-6
    )  # interval means against points


@pytest.mark.parametrize("bed", ["empty", "locked", "dashpot"])
def test_no_gas_without_slip(rig: Rig, steel: Scene, bed: str) -> None:
    scene = replace(steel, bed=bed)
    assert (
        gas_energy(scene, rig, nominal(scene, rig), SINE)
        == share_of_weight(scene, rig, 5.0, 20.0)
        == 0.0
    )


def test_the_shipped_losses_are_reported_beside_first_principles() -> None:
    """Sound goes as w^4, the viscous coefficient does not know w: the quotient falls by 16 from 20
    to 40 Hz.
    """
    rig, cavity = load_rig("paper"), Scene().cavity
    at_20, at_40 = (
        over_first_principles(loss_coefficients(rig, cavity, f), cavity, f) for f in (20.0, 40.0)
    )
    assert at_20["noise"] == pytest.approx(16.0 * at_40["noise"], rel=1e-12)
    assert at_20["air"] == at_40["air"]
    assert at_20 == pytest.approx(
        {name: rig.provenance[f"{name}_over_first_principles"] for name in ("noise", "air")},
        rel=1e-9,
    )
