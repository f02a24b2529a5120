"""The stand as a whole: signs, masses, the ledger, and interval means against exact integrals."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rig.beds.janssen_stack import Filling, nominal, refill, stack
from rig.catalog.entries import Rig
from rig.catalog.entries_by_name import material, names
from rig.drive.waveform import Waveform, waveform
from rig.protocol.grid import conditions
from rig.protocol.load import load_protocol
from rig.protocol.spec import Cavity, Dashpot, Drive, Grains, Layers, Scene
from rig.stand.box import box_mass
from rig.stand.ledger import CLOSES, COLUMNS
from rig.stand.prescribed import Stand

RATE = 4096 * 20.0
CYCLE = 4096
LOSS = [COLUMNS.index(name) for name in ("W_f", "W_c", "W_viscous", "W_noise", "W_air", "dKE_bed")]


def work(signal: np.ndarray, cycles: int, motion: Waveform) -> float:
    """Closed-loop integral of F v dt per cycle from interval means, by the harmonics that the
    velocity has.

    The mean over an interval multiplies a harmonic by sinc, in F and a alike: (pi h/4096)^2/3 =
    2e-7 for h = 1.
    """
    force, acceleration = (
        np.fft.rfft(row[-cycles * CYCLE :])[cycles::cycles] * 2 / (cycles * CYCLE) for row in signal
    )
    h = np.arange(1, force.size + 1)
    return float(-np.pi / motion.omega**2 * np.sum((force * acceleration.conj()).imag / h))


def run(
    scene: Scene, rig: Rig, motion: Waveform, filling: Filling, cycles: int
) -> tuple[np.ndarray, np.ndarray]:
    """Interval means and ledger rows over whole cycles."""
    stand = Stand(scene, rig, motion, filling, RATE)
    return stand.read(cycles * CYCLE), stand.drain_ledger()[:cycles]


def test_box_mass_is_that_of_its_walls() -> None:
    """Six plates: outer volume less cavity, 7850 kg/m3: (.16^2 x .41 - .15^2 x .4) m3 = 1.496e-3
    m3.
    """
    assert box_mass(Cavity(), 7850.0) == pytest.approx(7850.0 * 1.496e-3, rel=1e-12)


@given(
    *(st.floats(0.01, 1.0) for _ in range(3)),
    st.floats(1e-3, 0.1),
    st.sampled_from(names("material")),
)
def test_a_box_weighs_its_six_plates(
    length: float, width: float, height: float, wall: float, name: str
) -> None:
    """Two end plates over the whole face, two side plates and two lids between them.

    box_mass takes the cavity from the outer volume: each of a few roundings of 1.1e-16 grows by
    outer volume over plates, at most 1/(6 wall/side) = 170.
    """
    text = f"{{length: {length!r}, width: {width!r}, height: {height!r}, wall: {wall!r}, material: {name}}}"
    protocol = load_protocol(
        f"schema: rig/protocol/1\nname: x\nscene: {{bed: empty, grains: {{diameter: 1 mm}}, cavity: {text}}}\n"
    )
    cavity = conditions(protocol)[0].scene.cavity
    ends = wall * (width + 2.0 * wall) * (height + 2.0 * wall)
    sides, lids = length * wall * (height + 2.0 * wall), length * width * wall
    expected = material(name).density * 2.0 * (ends + sides + lids)
    assert box_mass(cavity, 1.0) == pytest.approx(expected, rel=2e-13)


def test_a_density_of_the_box_comes_before_its_materials_and_the_rigs() -> None:
    def mass(text: str) -> float:
        source = f"schema: rig/protocol/1\nname: x\nscene: {{cavity: {text}}}\n"
        return box_mass(conditions(load_protocol(source))[0].scene.cavity, 7850.0) / 1.496e-3

    assert mass("{}") == pytest.approx(7850.0, rel=1e-12)
    assert mass("{material: aluminium}") == pytest.approx(2700.0, rel=1e-12)
    assert mass("{material: aluminium, density: 2.8 g/cm3}") == pytest.approx(2800.0, rel=1e-12)
    assert mass("{density: 1 g/cm3}") == pytest.approx(1000.0, rel=1e-12)
    assert mass("{material: {density: 600}}") == pytest.approx(600.0, rel=1e-12)


def test_an_aluminium_box_is_lighter_at_the_gauge_by_its_plates(rig: Rig, steel: Scene) -> None:
    """In the stand too, and nothing else of the force changes: (7850 - 2700) 1.496e-3 kg."""
    motion, found = Waveform(20.0, 3.0), []
    for density in (None, 2700.0):
        scene = replace(steel, losses=(), cavity=Cavity(density=density))
        signal, _ = run(scene, rig, motion, nominal(scene, rig), 4)
        found.append(signal)
    lighter = (7850.0 - 2700.0) * 1.496e-3
    np.testing.assert_allclose(
        found[0][0] - found[1][0], lighter * found[0][1], rtol=0.0, atol=1e-9 * lighter * 3.0
    )


def test_a_dashpot_takes_positive_energy_and_its_closed_form(rig: Rig, steel: Scene) -> None:
    """W = pi c w X^2 > 0; the sign of the whole chain hangs on it."""
    scene = replace(steel, bed="dashpot", losses=(), dashpot=Dashpot(c=40.0))
    motion = Waveform(20.0, 3.0)
    signal, ledger = run(scene, rig, motion, nominal(scene, rig), 4)
    exact = np.pi * 40.0 * motion.omega * motion.length_unit**2
    assert exact > 0
    assert ledger[:, COLUMNS.index("W_viscous")] == pytest.approx(np.full(4, exact), rel=1e-12)
    assert work(signal, 3, motion) == pytest.approx(exact, rel=1e-6)


def test_the_gauge_mass_changes_the_apparent_mass_and_not_the_work(rig: Rig, steel: Scene) -> None:
    motion = Waveform(20.0, 4.0)
    found = []
    for mass in (0.02, 2.0):
        heavy = replace(rig, gauge_mass=mass)
        signal, _ = run(steel, heavy, motion, nominal(steel, rig), 12)
        force, acceleration = (np.fft.rfft(row[-CYCLE:])[1] for row in signal)
        found.append(
            (
                work(signal, 4, motion),
                (force * acceleration.conjugate()).real / abs(acceleration) ** 2,
            )
        )
    (w0, m0), (w1, m1) = found
    assert m1 - m0 == pytest.approx(1.98, rel=1e-9)
    # m a is orthogonal to v; what is left is round-off of N M V^2 ~ 0.3 J over W ~ 0.09 J
    assert w1 == pytest.approx(w0, rel=1e-9)


def test_a_locked_bed_takes_nothing_and_weighs_what_it_weighs(rig: Rig, steel: Scene) -> None:
    scene = replace(steel, bed="locked", losses=())
    motion = Waveform(20.0, 5.0)
    signal, ledger = run(scene, rig, motion, nominal(scene, rig), 4)
    total = (
        box_mass(scene.cavity, rig.wall_density)
        + rig.gauge_mass
        + stack(scene, rig, nominal(scene, rig)).mass
    )
    np.testing.assert_allclose(signal[0], total * signal[1], rtol=1e-9, atol=1e-9 * total * 5.0)
    assert np.abs(ledger).max() == 0.0


@pytest.mark.parametrize("acceleration", [1.0, 2.0, 3.0, 5.0])
def test_the_records_hold_the_ledgers_work(rig: Rig, steel: Scene, acceleration: float) -> None:
    """Force and acceleration as interval means give the ledger's losses + dKE_bed over the same
    cycles.

    An impact counts whole in its interval of 1/4096 cycle, its phase inside is lost: of each of the
    >1000 impacts per cycle a fraction of at most w dt = 1.5e-3, at random: below 1.5e-3/sqrt(12 x
    1000) = 1.4e-5 of W; 4 sigma.
    """
    motion = waveform(Drive(acceleration=acceleration), 0.003, 0.003, np.random.default_rng(5))
    filling = refill(steel, rig, np.random.default_rng(6))
    signal, ledger = run(steel, rig, motion, filling, 24)
    true = ledger[-12:, LOSS].sum(axis=1).mean()
    assert work(signal, 12, motion) == pytest.approx(true, rel=6e-5)


@given(
    fill=st.floats(0.02, 1.0),
    diameter=st.floats(2e-3, 2e-2),
    acceleration=st.floats(0.2, 12.0),
    clearance=st.floats(0.05, 3.0),
    side_walls=st.booleans(),
    seed=st.integers(0, 2**32),
)
@settings(max_examples=40, deadline=None)
def test_the_ledger_closes(
    rig: Rig,
    fill: float,
    diameter: float,
    acceleration: float,
    clearance: float,
    side_walls: bool,
    seed: int,
) -> None:
    scene = Scene(
        grains=Grains(density=7900.0, diameter=diameter, fill=fill),
        layers=Layers(clearance=clearance, rows=3, side_walls=side_walls),
    )
    rng = np.random.default_rng(seed)
    stand = Stand(
        scene,
        rig,
        waveform(Drive(acceleration=acceleration), 0.003, 0.01, rng),
        refill(scene, rig, rng),
        RATE,
    )
    signal = stand.read(12 * CYCLE)
    ledger = stand.drain_ledger()
    assert np.isfinite(signal).all()
    assert np.isfinite(ledger).all()
    assert np.abs(ledger[:, COLUMNS.index("closure")]).max() < CLOSES
    assert (ledger[:, LOSS[:5]] >= 0.0).all()


def test_momentum_goes_nowhere_else(rig: Rig, steel: Scene) -> None:
    """What the bed takes is momentum that its grains have: never more than M V, however long it
    runs.
    """
    bare = replace(steel, losses=())
    motion = Waveform(20.0, 5.0)
    with_bed, _ = run(bare, rig, motion, nominal(bare, rig), 40)
    without, _ = run(replace(bare, bed="empty"), rig, motion, nominal(bare, rig), 40)
    mass = stack(bare, rig, nominal(bare, rig)).mass
    momentum = mass * motion.velocity_unit + np.cumsum(with_bed[0] - without[0]) / RATE
    assert np.abs(momentum).max() <= mass * motion.velocity_unit * (1 + 1e-9)


def test_the_force_is_proportional_to_density(rig: Rig, steel: Scene) -> None:
    motion = Waveform(20.0, 4.0)
    light = replace(steel, losses=(), grains=replace(steel.grains, density=3400.0))
    heavy = replace(steel, losses=(), grains=replace(steel.grains, density=6800.0))
    empty = replace(steel, losses=(), bed="empty")
    force = [
        run(scene, rig, motion, nominal(scene, rig), 4)[0][0] for scene in (empty, light, heavy)
    ]
    np.testing.assert_allclose(
        force[2] - force[0], 2.0 * (force[1] - force[0]), rtol=1e-9, atol=1e-9
    )


@given(st.floats(0.25, 4.0), st.floats(0.25, 4.0))
@settings(max_examples=15, deadline=None)
def test_dimensionless_groups_decide(rig: Rig, scale: float, time: float) -> None:
    """Length x s, time x t, acceleration (with gravity) x s/t^2: energies go as m L^2/T^2 =
    s^5/t^2, density alike.
    """
    base = Scene(
        grains=Grains(density=7900.0, diameter=0.008, fill=0.8), losses=(), layers=Layers(rows=4)
    )
    cavity = replace(base.cavity, length=0.15 * scale, width=0.15 * scale, height=0.4 * scale)
    big = replace(base, cavity=cavity, grains=replace(base.grains, diameter=0.008 * scale))
    gravity = replace(rig, gravity=rig.gravity * scale / time**2)
    _, one = run(base, rig, Waveform(20.0, 5.0), nominal(base, rig), 16)
    stand = Stand(
        big, gravity, Waveform(20.0 / time, 5.0 * scale / time**2), nominal(big, rig), RATE / time
    )
    stand.read(16 * CYCLE)
    other = stand.drain_ledger()[:16]
    factor = scale**5 / time**2
    # rows far from a period amplify round-off by about e per cycle: the first cycles agree to the
    # last bits
    np.testing.assert_allclose(other[:3, :2], factor * one[:3, :2], rtol=1e-8, atol=1e-10 * factor)


def test_reads_of_any_size_give_the_same_stream(rig: Rig, steel: Scene) -> None:
    motion = Waveform(20.0, 5.0)
    whole = Stand(steel, rig, motion, nominal(steel, rig), RATE).read(40000)
    stand = Stand(steel, rig, motion, nominal(steel, rig), RATE)
    pieces = [stand.read(n) for n in (1, 9999, 20000, 10000)]
    assert (np.concatenate(pieces, axis=1) == whole).all()


def test_a_cycle_need_not_hold_a_whole_number_of_samples(rig: Rig, steel: Scene) -> None:
    """At 4096.7 intervals a cycle the ledger is the same motion's, and the force integrates to the
    same momentum.
    """
    motion = Waveform(20.0, 5.0)
    exact = Stand(steel, rig, motion, nominal(steel, rig), RATE)
    odd = Stand(steel, rig, motion, nominal(steel, rig), 4096.7 * 20.0)
    exact.read(8 * CYCLE)
    signal = odd.read(int(8 * 4096.7))
    np.testing.assert_allclose(
        odd.drain_ledger()[:8], exact.drain_ledger()[:8], rtol=1e-12, atol=1e-18
    )
    assert np.isfinite(signal).all()


def test_a_steady_row_is_replayed_and_not_simulated_again(rig: Rig, steel: Scene) -> None:
    """Rows of one small clearance settle to period 1; from then on every cycle is the stored one,
    to the last bit.
    """
    scene = replace(
        steel,
        grains=replace(steel.grains, fill=0.05),
        layers=Layers(rows=1, spread=0.0, clearance=0.3),
    )
    stand = Stand(scene, rig, Waveform(20.0, 6.0), nominal(scene, rig), RATE)
    stand.read(121 * CYCLE)
    rows = stand.drain_ledger()[:, :2]
    assert (rows[40:120] == rows[40]).all()
