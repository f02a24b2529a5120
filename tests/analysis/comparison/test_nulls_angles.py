"""Null tests find an injected angle, and nothing where there is none."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from analytic_record import IDEAL, NOMINAL, OMEGA, Bench, condition, session

from analysis import read_session
from analysis.comparison.null_tests import null_tests
from analysis.session.setting import Setting

LEVELS = (2.0, 3.0, 4.0, 5.0)
DELTA = 38.1


def table(levels=LEVELS, **bed):
    empty = [
        condition(f"e{i}", bed="empty", bed_mass=0.0, acceleration_set=a)
        for i, a in enumerate(levels)
    ]
    full = [condition(f"l{i}", acceleration_set=a, **bed) for i, a in enumerate(levels)]
    return empty + full


def box_loss(_entry, _repeat):
    return 15.0


def nulls(conditions, bench, loss=box_loss, seed=5):
    return read_session(session(conditions, loss, bench, np.random.default_rng(seed))).nulls


@pytest.mark.parametrize("angle", [0.0, 1e-3, -4e-3])
def test_an_injected_angle_is_found(angle):
    """The acceleration leads by `angle`: apparent loss (pi/w^2) M a^2 sin(angle)."""
    (found,) = nulls(table(bed="locked"), Bench(turn=angle, level_error=0.003))
    assert found.null == "locked"
    assert found.dphi == pytest.approx(math.sin(angle), abs=1e-6)
    assert found.verdict == ("holds" if angle == 0 else "does not hold")
    assert found.U_dphi < 2e-5


def test_an_angle_inside_the_certificate_holds():
    """A pole one tenth off its certified value turns 5e-4 rad: within the U of a 10 % spread, 1.96
    times that.
    """
    off = math.atan(1 / (OMEGA * 1.6 * 1.1)) - math.atan(1 / (OMEGA * 1.6))
    (found,) = nulls(
        table(bed="locked"), Bench(channels=dict(NOMINAL), turn=off, noise=(0.02, 5e-4))
    )
    assert found.dphi == pytest.approx(off, abs=3e-5)  # noise: see noise_of
    assert found.verdict == "holds"
    assert found.U_dphi == pytest.approx(1.96 * 0.1 / (OMEGA * 1.6), rel=0.02)


def test_rubbing_under_the_bed_is_not_an_angle():
    """Coulomb friction of the bed's weight gives an energy that grows as a: it goes to beta, not to
    the angle.
    """

    def loss(entry, repeat):
        # A dashpot whose energy is 15 N s/m worth plus 4 f X with f = 0.02 M g, at this level.
        x = entry["acceleration_set"] / OMEGA**2
        rubbing = 4 * 0.02 * entry["bed_mass"] * 9.81 * x
        return box_loss(entry, repeat) + rubbing / (math.pi * OMEGA * x**2)

    (found,) = nulls(table(bed="locked"), Bench(), loss)
    assert abs(found.dphi) < 1e-6
    assert found.verdict == "holds"


def test_a_bed_packed_too_full_to_flow_is_a_null_too():
    (found,) = nulls(table(bed="layers", carried=True, fill=1.0), Bench())
    assert (found.null, found.verdict, found.levels) == ("carried", "holds", 4)


def test_an_empty_cavity_of_any_bed_serves_as_the_empty_box():
    conditions = table(bed="locked")
    conditions[:4] = [{**entry, "bed": "layers", "fill": 0.0} for entry in conditions[:4]]
    (found,) = nulls(conditions, Bench())
    assert found.verdict == "holds"


@pytest.mark.parametrize("levels", [(5.0,), (3.0, 5.0)])
def test_two_levels_decide_nothing(levels):
    (found,) = nulls(table(levels, bed="locked"), Bench(turn=0.01))
    assert (found.verdict, found.dphi) == ("undecided", None)
    assert "at least 3" in found.why


def test_no_null_without_a_bed_that_cannot_slide():
    assert nulls(table(bed="layers"), Bench()) == ()


def test_single_runs_decide_with_few_degrees_of_freedom():
    """Three levels once each: six numbers, five unknowns of the law."""
    (found,) = nulls(table(LEVELS[:3], bed="locked"), Bench(repeats=1, noise=(0.5, 0.01)))
    assert found.nu < 2
    assert found.k > 4


def energy(mass: float, a: float, W: float) -> SimpleNamespace:
    """What the null reads of a run with a sine."""
    reactive = math.pi / OMEGA**2 * mass * a**2
    return SimpleNamespace(
        W=W,
        level=a,
        M_eff=mass,
        reactive=reactive,
        frequency=OMEGA / (2 * math.pi),
        acceleration=np.array([a + 0j]),
    )


@pytest.mark.parametrize("repeats", [2, pytest.param(8, marks=pytest.mark.slow)])
def test_scatter_that_grows_with_W_is_no_angle(repeats):
    """A light bed in a box whose loss scatters by 5 %, W about 2e-5 a^2. U holds zero in 95 % of
    150 draws, within 4 standard deviations (18); with a scatter that grows as the level alone, 30
    and 27 lie outside."""
    rng, draws, outside = np.random.default_rng(7), 150, 0
    entries = {entry["id"]: entry for entry in table((0.5, 2.0, 5.0, 10.0), bed="locked")}
    entries = {
        name: {**entry, "bed_mass": 0.14 * (entry["bed_mass"] > 0)}
        for name, entry in entries.items()
    }
    settings = {name: Setting.of(entry) for name, entry in entries.items()}
    for _ in range(draws):
        runs = {}
        for name, setting in settings.items():
            a = setting.acceleration_set
            W = 2e-5 * a**2 * (
                1 + 0.05 * rng.standard_normal(repeats)
            ) + 1e-8 * a * rng.standard_normal(repeats)
            mass = 0.24 + setting.bed_mass
            runs[name] = [
                SimpleNamespace(condition=name, u_noise=1e-8 * a, energy=energy(mass, a, w))
                for w in W
            ]
        (null,) = null_tests(settings, runs, IDEAL)
        outside += abs(null.dphi.value) > null.dphi.U
    assert outside <= draws * 0.05 + 4 * math.sqrt(draws * 0.05 * 0.95), outside
