"""`fidelity: auto` on beds alone: its kernel, its estimate of scatter, and what it promises of rows
and windows.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rig.beds.janssen_stack import nominal, refill, stack
from rig.beds.layers import LayersBed
from rig.catalog.entries import Rig
from rig.drive.waveform import Sampling, Waveform
from rig.fidelity.choose import stand_pilot
from rig.fidelity.lengths import LEAST_RECORD, LONGEST_RECORD, choose_lengths
from rig.fidelity.pilot import Pilot, rows_pilot
from rig.fidelity.rows import COVERAGE, LADDER, SHARE, choose_rows, scatter
from rig.fidelity.scene_rows import resolved_rows, with_rows
from rig.prediction.own import layers_variant
from rig.protocol.spec import Cavity, Drive, Grains, Scene
from rig.protocol.spec import Layers as LayersOf


def balls(rows: int = 8, **changes: float) -> Scene:
    return Scene(grains=replace(Grains(density=7900.0), **changes), layers=LayersOf(rows=rows))


def at(acceleration: float) -> Drive:
    return Drive(acceleration=acceleration)


@pytest.mark.parametrize("acceleration", [1.0, 2.0, 5.0])
def test_the_pilot_sees_what_the_bed_does(acceleration: float, rig: Rig) -> None:
    """Work per cycle against the bed in a sampled box, whose steady rows are replayed from a later
    period: states recur within 1e-10 of a clearance, of which each row has its own; steady energy
    against the layers variant."""
    scene, cycles = balls(fill=0.6), 96
    found = rows_pilot(scene, rig, at(acceleration), nominal(scene, rig), cycles)
    bed = LayersBed(
        stack(scene, rig, nominal(scene, rig)), Sampling(Waveform(20.0, acceleration), 64.0)
    )
    work = np.concatenate([bed.advance(2).work for _ in range(cycles // 2)])
    inertial = np.pi * bed.mass * Waveform(20.0, acceleration).velocity_unit ** 2
    kept = (
        1e-10 if found.repeating == 1.0 else 1e-4
    )  # a row without a period doubles a difference in each cycle
    np.testing.assert_allclose(found.work, work, atol=kept * inertial)
    same = layers_variant(
        scene, stack(scene, rig, nominal(scene, rig)), acceleration, 20.0, cycles - 64
    )
    assert same.total == pytest.approx(found.W, rel=1e-12)
    assert found.repeating >= same.periodic_share - 1e-12


def test_a_stand_is_a_pilot_of_any_bed(rig: Rig) -> None:
    """The same work, found at the events, whatever the sampling edges."""
    scene = balls(fill=0.1)
    rows = rows_pilot(scene, rig, at(3.0), nominal(scene, rig), 128)
    stand = stand_pilot(scene, rig, Waveform(20.0, 3.0), nominal(scene, rig), 128)
    np.testing.assert_allclose(rows.work, stand.work, rtol=1e-9)
    np.testing.assert_allclose(rows.W, stand.W, rtol=1e-9)


def test_resolved_rows_lie_side_by_side() -> None:
    assert resolved_rows(balls()) == 37
    assert resolved_rows(balls(diameter=5e-3)) == 30  # 0.15/0.005 is 30, 0.15//0.005 is 29
    assert resolved_rows(replace(balls(diameter=9e-2), cavity=Cavity(width=0.05))) == 1


@pytest.mark.parametrize(("acceleration", "rows"), [(2.0, 4), (3.0, 8), (5.0, 2), (5.0, 8)])
def test_scatter_of_strata_is_what_pourings_show(acceleration: float, rows: int, rig: Rig) -> None:
    """Estimate from one resolved bed against 40 pourings that differ in nothing but where their
    rows lie.

    A standard deviation of 40 has one of 11 % itself; the estimate takes the semivariance between
    resolved rows to be linear, and rises by a part in ten where it is not. Three of the one and the
    other together: 45 %.
    """
    fine = with_rows(balls(), 37)
    guess = scatter(rows_pilot(fine, rig, at(acceleration), nominal(fine, rig), 128).energy, rows)
    scene, rng = balls(rows), np.random.default_rng(1)
    poured = [replace(nominal(scene, rig), position=rng.random((85, rows))) for _ in range(40)]
    W = [
        layers_variant(scene, stack(scene, rig, filling), acceleration, 20.0).total
        for filling in poured
    ]
    assert guess == pytest.approx(float(np.std(W, ddof=1)), rel=0.45)


def test_scatter_of_a_straight_line() -> None:
    """w = clearance: a row anywhere in a stratum of width 1/R varies by 1/(12 R^2), and R of them
    add up to 1/(12 R^3).
    """
    resolved = 600
    energy = np.tile((np.arange(resolved) + 0.5) / resolved, (5, 1)) / resolved
    for rows in (1, 4, 12):
        # gamma is interpolated linearly between the lags of the ladder, above the parabola that it
        # is
        assert scatter(energy, rows) == pytest.approx(np.sqrt(5 / (12 * rows**3)), rel=0.1)


CONDITIONS = [(4e-3, 0.85, 1.0), (4e-3, 0.85, 2.0), (4e-3, 0.3, 5.0), (4e-3, 0.95, 4.0), (2e-3, 0.85, 5.0),
              (7e-3, 0.85, 6.0)]  # fmt: skip


@pytest.mark.parametrize("tolerance", [0.05, 0.01])
@pytest.mark.parametrize(("diameter", "fill", "acceleration"), CONDITIONS)
def test_rows_meet_their_share(
    diameter: float, fill: float, acceleration: float, tolerance: float, rig: Rig
) -> None:
    """W_T with the rows that were found against L2/d rows, both averaged over 4096 cycles.

    A tenth of the tolerance more than the share: what averaging rows without a period leaves, both
    times.
    """
    scene = balls(diameter=diameter, fill=fill)
    for drawn in (0, 4):
        found = choose_rows(scene, rig, at(acceleration), tolerance, drawn)
        chosen, fine = (
            layers_variant(s, stack(s, rig, nominal(s, rig)), acceleration, 20.0, 4096).total
            for s in (with_rows(scene, found.rows), with_rows(scene, resolved_rows(scene)))
        )
        assert found.rows in (*LADDER, found.resolved)
        assert abs(chosen / fine - 1.0) <= (SHARE + 0.1) * tolerance
        assert found.error <= SHARE * tolerance
        if drawn:
            added = np.sqrt(max(found.scatter**2 - found.scatter_resolved**2, 0.0))
            assert COVERAGE * added / np.sqrt(drawn) <= found.error


@pytest.mark.parametrize(("diameter", "fill", "acceleration"), CONDITIONS)
def test_no_fewer_rows_of_the_ladder_would_do(
    diameter: float, fill: float, acceleration: float, rig: Rig
) -> None:
    """Each shorter rung leaves more than its share: in W_T, or in the scatter of the strata, which
    bounds what W_T may agree by chance."""
    scene, tolerance = balls(diameter=diameter, fill=fill), 0.02
    fine = with_rows(scene, resolved_rows(scene))
    best = rows_pilot(fine, rig, at(acceleration), nominal(fine, rig), 512)
    for drawn in (0, 4):
        found = choose_rows(scene, rig, at(acceleration), tolerance, drawn)
        for rows in (rung for rung in LADDER if rung < found.rows):
            few = with_rows(scene, rows)
            bias = abs(
                rows_pilot(few, rig, at(acceleration), nominal(few, rig), 512).W / best.W - 1.0
            )
            spread = COVERAGE * scatter(best.energy, rows) / best.W / np.sqrt(max(drawn, 1))
            left = max(bias, spread if drawn else 0.5 * spread / COVERAGE) + best.averaging
            assert (
                left > 0.95 * SHARE * tolerance
            )  # the choice takes the resolved rows' own scatter off, some per cent


def test_a_wider_tolerance_never_takes_more_rows(rig: Rig) -> None:
    for _, fill, acceleration in CONDITIONS[:4]:
        rows = [
            choose_rows(balls(fill=fill), rig, at(acceleration), t, 4).rows
            for t in (0.2, 0.05, 0.01, 0.001)
        ]
        assert rows == sorted(rows)


def test_nothing_slides_nothing_is_looked_at(rig: Rig) -> None:
    found = choose_rows(balls(), rig, at(0.05), 0.01, 4)
    assert (found.rows, found.error, found.planning, found.pilot.flowing) == (1, 0.0, 0, 0)
    assert found.pilot.layers == 85


def series(seed: int, decay: float, size: float, ripple: float) -> Pilot:
    """W = 1 in the end: a transient, a ripple of period 3 and some noise."""
    rng, n = np.random.default_rng(seed), np.arange(300)
    work = (
        1.0
        + size * np.exp(-n / decay)
        + ripple * (np.cos(2 * np.pi * n / 3) + 0.1 * rng.standard_normal(300))
    )
    return Pilot(np.ones((1, 1)), work, 1, 1, 1.0, 0.0, 0)


@given(
    st.integers(0, 1000),
    st.floats(0.1, 60),
    st.floats(-1, 1),
    st.floats(0, 0.2),
    st.floats(1e-3, 0.2),
    st.just(0.0) | st.floats(1e-3, 1.0),
    st.integers(1, 5),
)
@settings(max_examples=80)
def test_no_window_after_the_settling_is_off_by_more(
    seed: int, decay: float, size: float, ripple: float, allowed: float, noise: float, least: int
) -> None:
    pilots = [series(seed, decay, size, ripple), series(seed + 1, decay, size, ripple)]
    found = choose_lengths(pilots, allowed, noise, least)
    assert found.settle >= least
    assert LEAST_RECORD <= found.record <= LONGEST_RECORD
    assert found.noise == pytest.approx(noise / np.sqrt(found.record))
    for pilot in pilots:
        total = np.concatenate(([0.0], np.cumsum(pilot.work - 1.0)))
        windows = (
            np.abs(total[found.record :] - total[: -found.record])[found.settle :] / found.record
        )
        assert (windows <= found.window + 1e-12).all()


def test_the_shortest_run_is_taken() -> None:
    """The transient e^(-k/5) puts a window of n cycles from s on off by e^(-s/5) (1 - e^(-n/5))/(n
    (1 - e^-0.2)).
    """
    found = choose_lengths([series(0, 5.0, 1.0, 0.0)], 0.01, 0.0)
    records = np.array([4, 5, 6, 7, 8, 9, 10, 12, 15, 16, 18, 20, 24, 30, 36, 40])
    off = (1 - np.exp(-records / 5)) / (records * (1 - np.exp(-0.2)))
    settle = np.ceil(5 * np.log(off / 0.01))
    assert found.settle + found.record == (settle + records).min()


def test_noise_alone_sets_the_record_of_a_rigid_bed() -> None:
    found = choose_lengths([], 0.01, 0.1, least_settle=2)
    assert (found.settle, found.window) == (2, 0.0)
    assert found.record == 100  # (0.1/0.01)^2


def test_what_the_bed_forbids_is_said() -> None:
    """W that wanders by a per cent for ever: no window of a pilot of 300 cycles is within 1e-5."""
    found = choose_lengths([series(0, 1.0, 0.0, 0.1)], 1e-5, 0.0)
    assert found.error > 1e-5


def test_what_noise_forbids_is_said_and_costs_no_more_than_as_written() -> None:
    found = choose_lengths([], 1e-6, 0.1, least_settle=1, written=50)
    assert found.error > 1e-6
    assert (found.settle, found.record) == (1, 49)


@pytest.mark.slow
def test_refills_scatter_as_with_resolved_rows(rig: Rig) -> None:
    """What auto adds to the scatter: 60 refills with the rows found and with L2/d rows, same
    packing and clearance.
    """
    scene = balls()
    rows = choose_rows(scene, rig, at(3.0), 0.01, 4).rows
    W = []
    for count in (rows, 37):
        rng, found = np.random.default_rng(5), []
        for _ in range(60):
            poured = refill(with_rows(scene, 1), rig, rng)
            filling = replace(
                poured, position=np.random.default_rng(len(found)).random((85, count))
            )
            found.append(
                layers_variant(scene, stack(with_rows(scene, count), rig, filling), 3.0, 20.0).total
            )
        W.append(np.array(found))
    difference = W[0] / W[1] - 1.0
    assert (
        np.std(difference) < 0.01
    )  # 2 s/sqrt(4) is within half a per cent, hence s within 0.5 %, twice that here
    assert abs(np.mean(difference)) < 3 * 0.01 / np.sqrt(60)
