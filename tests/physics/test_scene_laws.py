"""Laws of every bed that is built, in any scene: what must hold whatever the bed does inside."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from strategies import drives, motions, rigs, scenes

from rig.beds.column import rows_of
from rig.beds.janssen_stack import nominal, stack
from rig.beds.layers import LayersBed
from rig.catalog.entries import Rig
from rig.drive.waveform import Waveform, viscous_energy
from rig.errors import InputError
from rig.prediction.model import predict
from rig.protocol.spec import BEDS_OF_ROWS, BUILT_BEDS, Acquire, Condition, Scene
from rig.stand.ledger import CLOSES, COLUMNS, IN_BED
from rig.stand.prescribed import Stand
from rig.theory.total import plastic_bound

Array = NDArray[np.float64]

EDGES = 64
CYCLES = 12
BED = [COLUMNS.index(name) for name in IN_BED]
CLOSURE = COLUMNS.index("closure")

every_bed = pytest.mark.parametrize("bed", BUILT_BEDS)
laws = settings(max_examples=40, phases=(Phase.explicit, Phase.reuse, Phase.generate, Phase.shrink))


def follow(stand: Stand, cycles: int = CYCLES) -> tuple[Array, Array]:
    """Means (2, n) and ledger of a stand's first cycles. An example whose bed cannot be followed is
    no example.
    """
    try:
        means = stand.read(EDGES * cycles - 1)
    except InputError:
        assume(False)
    return means, stand.drain_ledger()[:cycles]


def stand_of(scene: Scene, rig: Rig, motion: Waveform) -> Stand:
    try:
        return Stand(scene, rig, motion, nominal(scene, rig), EDGES * motion.frequency)
    except InputError:
        assume(False)
        raise


def assert_same(found: Array, wanted: Array) -> None:
    """Equal to 1e-9 of the largest force and the largest acceleration, or of the largest energy of
    an account.
    """
    scale = np.abs(wanted).max(axis=1, keepdims=True) if len(wanted) == 2 else np.abs(wanted).max()
    assert (np.abs(found - wanted) <= 1e-9 * scale).all()


@every_bed
@given(data=st.data())
@laws
def test_every_number_is_one_and_the_ledger_closes(bed: str, rig: Rig, data: st.DataObject) -> None:
    scene, drive = data.draw(scenes(bed)), data.draw(drives)
    stand = stand_of(scene, data.draw(rigs(rig, bed)), data.draw(motions(drive)))
    means, ledger = follow(stand)
    assert np.isfinite(means).all()
    assert np.isfinite(ledger).all()
    assert np.abs(ledger[:, CLOSURE]).max() <= CLOSES
    assert (
        ledger[:, BED] >= -1e-12 * np.abs(ledger).max(initial=0.0)
    ).all()  # sums of losses, each positive


@every_bed
@given(data=st.data())
@laws
def test_between_nothing_and_the_bound(bed: str, rig: Rig, data: st.DataObject) -> None:
    """Over N cycles of an exact sine from the start: the energy that the bed has in the beginning,
    and N times the most that walls can put in; one more for what it may hold in between. In its
    steady state: the bound that is told."""
    scene, drive, rig = data.draw(scenes(bed)), data.draw(drives), data.draw(rigs(rig, bed))
    stand = stand_of(scene, rig, data.draw(motions(drive, exact=True)))
    lost = float(follow(stand)[1][:, BED].sum())
    motion = stand.motion
    if bed == "dashpot":
        assert lost == pytest.approx(CYCLES * viscous_energy(scene.dashpot.c, motion), rel=1e-12)
        return
    try:
        told = predict(Condition("c", scene, drive, Acquire(), ""), rig)
    except InputError:
        assume(False)
    if bed in ("empty", "locked"):
        assert (lost, told.W_T) == (0.0, 0.0)
        return
    # the mean of an orbit without a period keeps up to the energy that the bed holds, of 64 cycles
    # or more
    assert 0.0 <= told.W_T <= told.bound * (1.0 if told.period else 1.0 + 1.0 / 64.0) * (1.0 + 1e-9)
    e = (
        scene.single_mass.restitution
        if bed == "single_mass"
        else stack(scene, rig, nominal(scene, rig)).restitution
    )
    most = plastic_bound(told.bed_mass, motion.velocity_unit, e)
    if bed == "layers":
        assert lost <= (CYCLES + 1) * most * (1.0 + 1e-9)


@pytest.mark.parametrize("bed", [bed for bed in BUILT_BEDS if bed != "dashpot"])
@given(data=st.data())
@laws
def test_below_its_threshold_a_bed_takes_nothing(bed: str, rig: Rig, data: st.DataObject) -> None:
    """Layers: f/m of the weakest layer; a column: g y of the top one; a single mass at rest: mu g on a floor along the drive, g
    against gravity. An exact sine just below that, or any at all for beds that cannot move."""
    scene, drive, share = (
        data.draw(scenes(bed)),
        data.draw(drives),
        data.draw(st.floats(0.01, 0.999)),
    )
    level = drive.acceleration
    if bed in BEDS_OF_ROWS:
        threshold = rows_of(scene, rig, nominal(scene, rig)).threshold
        level = share * float(threshold.min(initial=np.inf)) if threshold.size else level
    if bed == "single_mass":
        holds = {
            "horizontal": scene.single_mass.friction * rig.gravity,
            "vertical": rig.gravity,
            "zero_gravity": 0.0,
        }
        level = share * holds[scene.axis]
        start = 0.0 if scene.axis == "vertical" else scene.single_mass.start
        scene = replace(scene, single_mass=replace(scene.single_mass, velocity=0.0, start=start))
    assume(level > 1e-6)
    _, ledger = follow(stand_of(scene, rig, Waveform(drive.frequency, level)))
    assert (ledger[:, BED] == 0.0).all()
    drive = replace(drive, acceleration=level)
    assert predict(Condition("c", scene, drive, Acquire(), ""), rig).W_T == 0.0


powers = st.integers(-6, 6).map(lambda n: 2.0**n)


def in_other_units(
    scene: Scene, rig: Rig, motion: Waveform, m: float, kg: float, s: float
) -> tuple[Scene, Rig, Waveform]:
    """Return the same experiment with every length, mass and time scaled."""
    cavity = replace(
        scene.cavity,
        **{k: m * getattr(scene.cavity, k) for k in ("length", "width", "height", "wall")},
    )
    density = scene.grains.density
    assert density is not None
    grains = replace(scene.grains, diameter=m * scene.grains.diameter, density=density * kg / m**3)
    single_mass = scene.single_mass
    gap = m * single_mass.gap if isinstance(single_mass.gap, float) else single_mass.gap
    single_mass = replace(
        single_mass, gap=gap, start=m * single_mass.start, velocity=m / s * single_mass.velocity
    )
    dashpot = replace(scene.dashpot, c=kg / s * scene.dashpot.c)
    scene = replace(scene, cavity=cavity, grains=grains, single_mass=single_mass, dashpot=dashpot)
    rig = replace(
        rig,
        gravity=m / s**2 * rig.gravity,
        wall_density=kg / m**3 * rig.wall_density,
        gauge_mass=kg * rig.gauge_mass,
        loss_noise=kg / s * rig.loss_noise,
        loss_air=kg / m * rig.loss_air,
        cord_frequency=rig.cord_frequency / s,
    )
    return (
        scene,
        rig,
        replace(
            motion, frequency=motion.frequency / s, acceleration=m / s**2 * motion.acceleration
        ),
    )


@every_bed
@given(data=st.data())
@laws
def test_units_change_nothing(bed: str, rig: Rig, data: st.DataObject) -> None:
    """Lengths, masses and times scaled by powers of two: the same record and the same account in
    the new units.

    Rounding does not notice such a factor, but for squares by the C library's `pow`, now and then
    off in the last bit, which every bounce may double: four cycles, 1e-9 of the largest.
    """
    scene, rig = data.draw(scenes(bed)), data.draw(rigs(rig, bed))
    motion = data.draw(motions(data.draw(drives)))
    m, kg, s = (data.draw(powers) for _ in range(3))
    means, ledger = follow(stand_of(scene, rig, motion), 4)
    scaled, account = follow(stand_of(*in_other_units(scene, rig, motion, m, kg, s)), 4)
    assert_same(scaled, means * np.array([[kg * m / s**2], [m / s**2]]))
    assert_same(account.T[:CLOSURE], ledger.T[:CLOSURE] * (kg * m**2 / s**2))


@every_bed
@given(data=st.data())
@laws
def test_proportional_to_density(bed: str, rig: Rig, data: st.DataObject) -> None:
    """The energies of the bed are proportional to the density, exactly for powers of two. A dashpot
    has none.
    """
    scene, rig = replace(data.draw(scenes(bed)), losses=()), data.draw(rigs(rig, bed))
    motion, factor = data.draw(motions(data.draw(drives))), data.draw(powers)
    density = scene.grains.density
    assert density is not None
    heavier = replace(scene, grains=replace(scene.grains, density=factor * density))
    light, heavy = (follow(stand_of(one, rig, motion))[1] for one in (scene, heavier))
    np.testing.assert_array_equal(
        heavy[:, BED], (1.0 if bed == "dashpot" else factor) * light[:, BED]
    )


@every_bed
@given(data=st.data())
@laws
def test_mirrored(bed: str, rig: Rig, data: st.DataObject) -> None:
    """The waveform reversed, and the bed at the other wall: force and acceleration reversed, the
    same account.

    Places are mirrored by a subtraction, so that they differ in the last bits, which every bounce
    may double: four cycles, 1e-9 of the largest. Gravity has no mirror image: no vertical axis.
    """
    scene, rig = data.draw(scenes(bed)), data.draw(rigs(rig, bed))
    assume(scene.axis != "vertical")
    motion = data.draw(motions(data.draw(drives)))
    backwards = replace(
        motion, sine=tuple(-x for x in motion.sine), cosine=tuple(-x for x in motion.cosine)
    )
    other = scene
    if bed == "single_mass":
        gap = scene.single_mass.gap
        assume(gap is not None)
        start = (
            -scene.single_mass.start
            if gap == "none"
            else float(gap or 0.0) - scene.single_mass.start
        )
        other = replace(
            scene,
            single_mass=replace(
                scene.single_mass, start=start, velocity=-scene.single_mass.velocity
            ),
        )
    one, two = stand_of(scene, rig, motion), stand_of(other, rig, backwards)
    if isinstance(two._bed, LayersBed):
        rows = two._bed._rows.clearance
        two._bed._memory["u"] = np.where(np.isinf(rows), 0.0, rows)
    means, ledger = follow(one, 4)
    mirrored, account = follow(two, 4)
    assert_same(mirrored, -means)
    assert_same(account.T[:CLOSURE], ledger.T[:CLOSURE])
