"""The coupled stand with a rigid load against its frequency response, written here by mechanical
impedances.
"""

from dataclasses import replace

import numpy as np
import pytest

from rig.beds.janssen_stack import bed_mass, nominal
from rig.catalog.entries import Exciter, Rig
from rig.catalog.rig_file import load_rig
from rig.drive.amplifier_command import Command
from rig.drive.electrodynamic import Plant, response
from rig.protocol.spec import Amplifier, Drive, GaugeSide, Scene
from rig.stand.box import box_mass
from rig.stand.shaker import CoupledStand

NAMES = ("force", "acceleration", "current", "voltage")


def by_impedances(
    e: Exciter, amplifier: str, load: float, gauge_mass: float, side: str, f: float
) -> dict[str, complex]:
    """Force at the gauge, acceleration, current and voltage per unit command: two-ports in series,
    no matrix.

    From the box backwards: for a box velocity 1 the stinger carries Z_load, the armature moves by
    that force's deflection more, the body by the reaction, and current and voltage follow.
    """
    s = 2j * np.pi * f

    def spring(k: float, ratio: float, mass: float) -> complex:
        return complex(k / s + 2.0 * ratio * np.sqrt(k * mass))

    box = load + (gauge_mass if side == "box" else 0.0)
    moving = e.moving_mass + (0.0 if side == "box" else gauge_mass)
    pull = s * box * 1.0
    armature = 1.0 + pull / (e.stinger_stiffness / s + e.stinger_damping)
    on_body = pull + s * moving * armature  # what the coil's force less the flexure's has to move
    body = -on_body / (
        s * e.body_mass + spring(e.isolation_stiffness, e.isolation_damping_ratio, e.body_mass)
    )
    flexure = spring(e.flexure_stiffness, e.flexure_damping_ratio, e.moving_mass)
    current = (on_body + flexure * (armature - body)) / e.force_constant
    voltage = (e.resistance + s * e.inductance) * current + e.force_constant * (armature - body)
    unit = voltage if amplifier == "voltage" else current
    force = pull + (s * gauge_mass * armature if side == "exciter" else 0.0)
    return {
        "force": force / unit,
        "acceleration": s / unit,
        "current": current / unit,
        "voltage": voltage / unit,
    }


@pytest.mark.parametrize("name", ["JZ-30", "2100E11"])
@pytest.mark.parametrize("amplifier", ["voltage", "current"])
@pytest.mark.parametrize("side", ["box", "exciter"])
def test_the_response_is_that_of_the_impedances(
    name: str, amplifier: Amplifier, side: GaugeSide
) -> None:
    """Round-off only: 1e-9 leaves room for the condition of the matrix with a stinger of 1e7 N/m."""
    from rig.catalog.entries_by_name import exciter

    preset = exciter(name)
    frequencies = np.geomspace(1.0, 2000.0, 40)
    found = response(Plant.of(preset, 40.0, 0.3, side), amplifier, frequencies)
    for name in NAMES:
        expected = [by_impedances(preset, amplifier, 40.0, 0.3, side, f)[name] for f in frequencies]
        assert getattr(found, name) == pytest.approx(np.array(expected), rel=1e-9)


@pytest.mark.parametrize("amplifier", ["voltage", "current"])
@pytest.mark.parametrize(
    ("frequency", "side"),
    [(5.0, "box"), (22.0, "exciter"), (63.0, "box"), (200.0, "exciter"), (500.0, "box")],
)
def test_a_locked_bed_moves_as_its_response_says(
    steel: Scene, amplifier: Amplifier, frequency: float, side: GaugeSide
) -> None:
    """0.1 % and 0.05 degrees over 5 to 500 Hz. The command is straight between edges, (w h)^2/12 = 4e-6 at 820 edges a
    cycle; the means over intervals are corrected here. The flexure's modes have settled: damping raised, waits long.
    """
    rig = load_rig("paper")
    damped = replace(rig.exciter, isolation_damping_ratio=0.7, stinger_damping=400.0)
    rig = replace(rig, exciter=damped, gauge_mass=0.2)
    scene = replace(steel, bed="locked", losses=())
    rate = 8 * (10240.0 if frequency < 21.0 else 51200.0)
    drive = Drive(mode="shaker", frequency=frequency, amplifier=amplifier, gauge=side)
    tested = CoupledStand(scene, rig, drive, nominal(scene, rig), rate, names=NAMES)
    tested.advance(Command((1.0 + 0j,), frequency, max(int(2 * frequency), 20)))
    out = tested.advance(Command((1.0 + 0j,), frequency, max(int(frequency / 5), 4)))
    # cycles that hold no whole number of edges: a fit, not a transform; its clock goes on from the
    # start
    cycles = max(int(2 * frequency), 20)
    turns = (
        (np.floor(cycles * rate / frequency + 1e-6) + np.arange(out.shape[1]) + 0.5)
        * frequency
        / rate
    )
    wave = np.exp(2j * np.pi * turns)
    basis = np.column_stack([wave.real, wave.imag, np.ones(turns.size)])
    mean = np.sinc(frequency / rate)
    load = box_mass(scene.cavity, rig.wall_density) + bed_mass(scene, rig.packing_shaken)
    expected = by_impedances(damped, amplifier, load, 0.2, side, frequency)
    for name, signal in zip(NAMES, out, strict=True):
        p, q, _ = np.linalg.lstsq(basis, signal, rcond=None)[0]
        ratio = (p - 1j * q) / mean / expected[name]
        assert abs(ratio) == pytest.approx(1.0, abs=1e-3), name
        assert np.degrees(np.angle(ratio)) == pytest.approx(0.0, abs=0.05), name


def test_the_gauge_side_mass_is_in_the_force_at_either_end(rig: Rig) -> None:
    """Apparent mass at 20 Hz, far below the resonance on the stinger: box and gauge side together."""
    plants = [Plant.of(rig.exciter, 12.0, 0.5, side) for side in ("box", "exciter")]  # type: ignore[arg-type]
    at_box, at_exciter = (response(plant, "current", 20.0) for plant in plants)
    for found in (at_box, at_exciter):
        apparent = (found.force / found.acceleration)[0]
        assert apparent.real == pytest.approx(12.5, rel=1e-3)
