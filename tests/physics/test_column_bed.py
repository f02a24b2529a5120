"""Bed `column`: Coulomb blocks without end walls, against closed forms, resolved grains and itself
on other stands.
"""

import csv
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rig.beds.column import column_stack
from rig.beds.coupled_step import ENDLESS, TWO_WAY
from rig.beds.janssen_stack import Filling, nominal
from rig.catalog.entries import Rig
from rig.drive.amplifier_command import Command
from rig.drive.electrodynamic import response
from rig.drive.waveform import Waveform
from rig.errors import InputError
from rig.kernels.rows.recorded_motion import sampled_energy
from rig.prediction.model import predict
from rig.prediction.refills import refill_ratios
from rig.protocol.spec import Acquire, Cavity, Condition, Drive, Grains, Scene
from rig.stand.box import box_mass
from rig.stand.ledger import COLUMNS, IN_BED
from rig.stand.prescribed import Stand
from rig.stand.shaker import CoupledStand

TABLE = Path(__file__).parents[1] / "data" / "engine_table.csv"
SMALL = Scene(
    cavity=Cavity(0.1, 0.025, 0.05),
    grains=Grains("stainless", 0.005, 0.85, 7900.0),
    bed="column",
    losses=(),
)
W_F, W_C = COLUMNS.index("W_f"), COLUMNS.index("W_c")


def energy(scene: Scene, rig: Rig, acceleration: float, frequency: float = 20.0) -> float:
    drive = Drive(frequency=frequency, acceleration=acceleration)
    return predict(Condition("c", scene, drive, Acquire(), ""), rig).W_T


@pytest.mark.parametrize("acceleration", [20.0, 40.0, 100.0])
def test_energy_of_blocks_that_never_stick(rig: Rig, acceleration: float) -> None:
    """4 eta sqrt(1 - (pi eta/2)^2) m V^2 of each block, eta = y g/a < 2/sqrt(4 + pi^2): the closed
    form of a mass on a rough floor. To what the recurrence of a state leaves, 1e-10.
    """
    bed = column_stack(SMALL, rig, nominal(SMALL, rig))
    eta = bed.threshold / acceleration
    assert eta.max() < 2.0 / math.sqrt(4.0 + math.pi**2)
    V = acceleration / (40.0 * math.pi)
    known = bed.row_mass * V**2 * (4.0 * eta * np.sqrt(1.0 - (math.pi * eta / 2.0) ** 2)).sum()
    assert energy(SMALL, rig, acceleration) == pytest.approx(known, rel=1e-9)


def test_thresholds_rise_with_depth_from_the_printed_one(rig: Rig) -> None:
    """g (0.165 + h (1.64/L + 2 x 0.084/B)), h from 0 in steps of w H/n."""
    found = column_stack(SMALL, rig, nominal(SMALL, rig)).threshold / rig.gravity
    step = 0.85 * 0.05 / 8 * (1.64 / 0.1 + 2 * 0.084 / 0.025)
    assert found == pytest.approx(0.165 + step * np.arange(8), rel=1e-12)


def test_resolved_grains(rig: Rig) -> None:
    """At 10 and 14 m/s^2 at least 80 % of the cases lie within 30 %, at 5 and 7 at least 43 %
    (design, over 68 cases not fitted); above that the thresholds are too low. Energies per mass:
    the engine's small boxes are packed more loosely than the rig's.
    """
    apart: dict[str, list[bool]] = {"low": [], "high": []}
    with TABLE.open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["axis"] == "0"]
    for row in rows:
        a = float(row["a"])
        cavity = Cavity(*(float(row[name]) for name in ("Lx", "Ly", "H")))
        grains = Grains("stainless", float(row["d"]), float(row["fill"]), float(row["rho"]))
        scene = replace(SMALL, cavity=cavity, grains=grains)
        drive = Drive(frequency=float(row["f"]), acceleration=a)
        found = predict(Condition("c", scene, drive, Acquire(), ""), rig)
        ratio = found.W_T / found.bed_mass / (float(row["W"]) / float(row["M"]))
        if a in (5.0, 7.0, 10.0, 14.0):
            apart["low" if a < 10.0 else "high"].append(abs(ratio - 1.0) <= 0.3)
    assert len(apart["low"]) == 8
    assert len(apart["high"]) == 8
    assert np.mean(apart["low"]) >= 0.43
    assert np.mean(apart["high"]) >= 0.8


def test_prescribed_stand_takes_the_predicted_energy(rig: Rig) -> None:
    """The ledger of the stand after settling, against W_T of the rows alone: one kernel, two ways
    through it, to round-off of sums over 8 blocks.
    """
    stand = Stand(SMALL, rig, Waveform(20.0, 7.0), nominal(SMALL, rig), 512 * 20.0)
    stand.read(512 * 40)
    lost = stand.drain_ledger()[20:, [COLUMNS.index(name) for name in IN_BED]].sum(axis=1)
    assert lost == pytest.approx(np.full(lost.size, energy(SMALL, rig, 7.0)), rel=1e-9)


def test_the_recorded_waveform_of_a_sine_gives_the_same(rig: Rig) -> None:
    """Linear between 512 samples a cycle: the mean of a chord is (2 pi/512)^2/12 = 1e-5 below that
    of a sine, and W goes with a power of the level below 5 and over a threshold; 1e-3 is ample.
    """
    bed = column_stack(SMALL, rig, nominal(SMALL, rig))
    phase = 2.0 * math.pi * np.arange(512 * 4) / 512
    found = sampled_energy(
        bed.threshold, bed.clearance.ravel(), 0.0, 7.0 * np.sin(phase), 1 / (20.0 * 512), 512 * 10
    )
    assert found[1] == 0.0
    assert bed.row_mass * found[0] / 4 == pytest.approx(energy(SMALL, rig, 7.0), rel=1e-3)


def test_a_heavy_box_on_an_exciter_moves_as_a_prescribed_one(rig: Rig) -> None:
    """As for bed `layers` (test_coupled_laws.py): to 1e-3 at 1e6 times the mass of the bed."""
    exact = Stand(SMALL, rig, Waveform(20.0, 7.0), nominal(SMALL, rig), 4096 * 20.0)
    exact.read(4096 * 3)
    known = exact.drain_ledger()[:3, [W_F, W_C]].sum()
    strong = replace(
        rig.exciter, current_peak=1e9, voltage_peak=1e9, stinger_stiffness=1e9, stinger_damping=1e3,
        body_mass=1e6, isolation_stiffness=1e9,
    )  # fmt: skip
    density = rig.wall_density * 3e5 / box_mass(SMALL.cavity, rig.wall_density)
    heavy = replace(rig, wall_density=density, exciter=strong)
    drive = Drive(mode="shaker", amplifier="current")
    tested = CoupledStand(SMALL, heavy, drive, nominal(SMALL, rig), 4096 * 20.0)
    phasor = 7j / response(tested.plant, "current", 20.0).acceleration[0]
    command = Command((complex(phasor),), 20.0, 3)
    tested.begin(command)
    tested.advance(command)
    found = tested.drain_ledger()
    assert found[:, W_C].sum() == 0.0
    assert found[:, W_F].sum() == pytest.approx(known, rel=1e-3)


def test_blocks_of_the_shaker_start_far_from_any_wall(rig: Rig) -> None:
    bed = TWO_WAY["column"](SMALL, rig, nominal(SMALL, rig))
    assert bed.start == ENDLESS
    assert (bed.clearance == 2 * ENDLESS).all()
    assert bed.mass == pytest.approx(0.63 * 7900 * 0.1 * 0.025 * 0.85 * 0.05, rel=1e-12)


def test_a_refill_changes_the_mass_alone(rig: Rig) -> None:
    """Energies in proportion to the packing, whose scatter the rig file gives: 256 stratified draws
    have its mean and standard deviation to 1 % of the latter.
    """
    loose, dense = (column_stack(SMALL, rig, Filling(p, 1.0)) for p in (0.6, 0.66))
    assert (loose.threshold == dense.threshold).all()
    assert dense.mass / loose.mass == pytest.approx(1.1, rel=1e-12)
    condition = Condition("c", SMALL, Drive(acceleration=7.0), Acquire(), "")
    ratios = refill_ratios(condition, rig, energy(SMALL, rig, 7.0))
    assert np.mean(ratios) == pytest.approx(1.0, abs=1e-2 * rig.refill_packing)
    assert np.std(ratios) == pytest.approx(rig.refill_packing, rel=2e-2)


def test_friction_outside_the_table_is_a_named_error(rig: Rig) -> None:
    other = replace(rig, grain_friction=0.4)
    with pytest.raises(InputError, match=r"mu_p.* is 0\.4, and the table has 0\.25"):
        column_stack(SMALL, other, nominal(SMALL, other))
