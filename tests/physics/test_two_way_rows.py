"""Rows and a box that move each other, against closed forms and against an integrator that knows
none of this.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from rig.beds.coupled_step import TWO_WAY, TwoWay
from rig.beds.janssen_stack import nominal
from rig.catalog.entries import Rig
from rig.drive.amplifier_command import Command
from rig.drive.electrodynamic import response
from rig.drive.waveform import Waveform
from rig.kernels.rows.coupled_step import LEANING, Pull, collide
from rig.kernels.rows.tiles import from_tiles, to_tiles
from rig.protocol.spec import Axis, Drive, Scene, SingleMass
from rig.stand.box import box_mass
from rig.stand.ledger import COUPLED_COLUMNS
from rig.stand.prescribed import Stand
from rig.stand.shaker import STEPS, CoupledStand

masses = st.floats(1e-3, 1e3)


@given(
    m=masses,
    box=masses,
    e=st.floats(0.0, 1.0),
    closing=st.floats(0.01, 1.0),
    v=st.floats(-1.0, 1.0),
    low=st.booleans(),
)
@settings(max_examples=100, deadline=None)
def test_a_row_and_a_free_box_collide_by_the_book(
    m: float, box: float, e: float, closing: float, v: float, low: bool
) -> None:
    """Momentum stays, the relative velocity turns by -e, and what is lost is m_r (1 - e^2) w^2/2:
    round-off.
    """
    s = 1.0 if low else -1.0
    w, u = np.array([v - s * closing]), np.array([0.0 if low else 1e-3])
    lo, hi = np.array([-1.0]), np.array([1.0])
    tiles = to_tiles(w, u, lo, hi, hi, np.array([1e-3]))
    before = m * w[0] + box * v, 0.5 * m * w[0] ** 2 + 0.5 * box * v**2
    around = Pull(m, e, 0.0, box, 0.0, 0.0, 0.0)
    who, tally = np.array([0 if low else -1]), np.zeros((2, 1), np.int64)
    after, lost = collide(v, 1e-5, 1e-9, around, 1, who, tiles, tally)
    from_tiles(tiles, w, u, lo, hi)
    scale = m * abs(before[0] / (m + box)) + m * closing + box * abs(v)
    assert m * w[0] + box * after == pytest.approx(before[0], abs=1e-14 * scale)
    rebound = s * (w[0] - after)
    assert rebound == pytest.approx(
        e * closing if e * closing > 1e-9 else 0.0, abs=1e-14 * (1 + abs(v)) * (1 + m / box)
    )
    energy = 0.5 * m * w[0] ** 2 + 0.5 * box * after**2
    assert before[1] - energy == pytest.approx(lost, abs=1e-13 * (before[1] + energy))
    assert (hi[0] - lo[0] == np.inf) == (e * closing <= 1e-9) == bool(tally[LEANING, 0])


def reference(
    stand: CoupledStand, mass: float, band: float, amplitude: float, end: float
) -> tuple[float, float, float]:
    """Velocities of box and row at the end and the heat till then, by an integrator with events:
    ride, slip, ride.

    The row stands in the middle of unlimited space, the amplifier gives a current A sin(wt). Riding,
    its mass is the box's; slipping, friction is constant; it begins to slip where the box would
    pull it by more than `band`.
    """
    p, omega = stand.plant, 2.0 * np.pi * 20.0

    def rates(t: float, y: np.ndarray, mode: int) -> list[float]:
        xa, va, xb, vb, x, v, w, _ = y
        coil = p.force_constant * amplitude * np.sin(omega * t)
        flexure = p.flexure * (xa - xb) + p.flexure_damping * (va - vb)
        pull = p.stinger * (xa - x) + p.stinger_damping * (va - v)
        mount = p.isolation * xb + p.isolation_damping * vb
        a = pull / (p.box + mass) if mode == 0 else (pull - mode * mass * band) / p.box
        row = a if mode == 0 else mode * band
        armature, body = (coil - flexure - pull) / p.armature, (flexure - coil - mount) / p.body
        return [va, armature, vb, body, v, a, row, mode * mass * band * (v - w)]

    t, y, mode = 0.0, np.zeros(8), 0
    while t < end:

        def leaves(now: float, state: np.ndarray, mode: int) -> float:
            if mode == 0:
                return abs(rates(now, state, 0)[5]) - band
            return float(mode * (state[5] - state[6]))

        leaves.terminal = True  # type: ignore[attr-defined]
        leaves.direction = 1.0 if mode == 0 else -1.0  # type: ignore[attr-defined]
        leg = solve_ivp(
            rates,
            (t, end),
            y,
            "DOP853",
            args=(mode,),
            events=leaves,
            rtol=1e-10,
            atol=1e-13,
            max_step=1e-3,
        )
        t, y = float(leg.t[-1]), leg.y[:, -1]
        if t < end:
            pulled = rates(t, y, 0)[5]
            mode = int(np.sign(pulled)) if abs(pulled) >= band * (1.0 - 1e-9) else 0
            y[6] = y[5]
    return float(y[5]), float(y[6]), float(y[7])


def test_one_row_slides_as_an_integrator_with_events_has_it(
    rig: Rig, steel: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A row of 8 kg that rides, slips and turns for three cycles. When slip begins is known to a
    step: velocities agree to what friction changes in one, heat to 1e-3 at the default step and
    less in proportion to it."""
    mass, band, amplitude = 8.0, 0.6, 4.0
    monkeypatch.setitem(
        TWO_WAY, "layers", lambda *_: TwoWay(0.0, 0.0, mass, 0.0, np.array([band]), np.array([1e3]))
    )
    scene = replace(steel, losses=())
    damped = replace(rig, exciter=replace(rig.exciter, stinger_damping=400.0))
    errors: list[float] = []
    expected: tuple[float, float, float] | None = None
    for refine in (1, 4, 16):
        drive = Drive(mode="shaker", amplifier="current")
        tested = CoupledStand(scene, damped, drive, nominal(scene, rig), 4096 * 20.0, refine=refine)
        tested._u[:] = 500.0  # in the middle, away from the walls
        tested._lo[:], tested._hi[:] = -band, band
        tested._phasors = (-1j * amplitude,)
        tested.advance(Command((-1j * amplitude,), 20.0, 3))
        heat = tested.drain_ledger()[:, 0].sum()
        expected = expected or reference(tested, mass, band, amplitude, 3 / 20.0)
        v, w, exact = expected
        step = 1.0 / (20.0 * STEPS * refine)
        assert tested.state[5] == pytest.approx(v, abs=band * step)
        assert tested._w[0] == pytest.approx(w, abs=band * step)
        errors.append(refine * abs(heat / exact - 1.0))
    assert max(errors) < 1e-3


@pytest.mark.parametrize("restitution", [0.0, 0.5])
@pytest.mark.parametrize("axis", ["vertical", "zero_gravity", "horizontal"])
def test_a_single_mass_in_a_heavy_box_takes_what_it_takes_in_a_programmed_one(
    rig: Rig, steel: Scene, axis: Axis, restitution: float
) -> None:
    """Flights under gravity, a lid, a rough floor: W of each of the first cycles is the waveform
    controller's to 2e-3; a box of 1e5 times the single mass gives way by less; both accounts close,
    height included."""
    single_mass = SingleMass(
        restitution=restitution, gap=0.004, friction=0.1 if axis == "horizontal" else 0.0
    )
    scene = replace(steel, bed="single_mass", axis=axis, losses=(), single_mass=single_mass)
    filling, a, cycles = nominal(scene, rig), 20.0, 4
    prescribed = Stand(scene, rig, Waveform(20.0, a), filling, 4096 * 20.0)
    prescribed.read(4096 * cycles)
    exact = prescribed.drain_ledger()[:cycles, :2].sum(axis=1)
    strong = replace(
        rig.exciter,
        current_peak=1e12,
        voltage_peak=1e12,
        stinger_stiffness=1e9,
        stinger_damping=1e3,
        body_mass=1e8,
        isolation_stiffness=1e11,
    )
    heavy = replace(
        rig,
        exciter=strong,
        wall_density=rig.wall_density * 4e6 / box_mass(scene.cavity, rig.wall_density),
    )
    tested = CoupledStand(
        scene, heavy, Drive(mode="shaker", amplifier="current"), filling, 4096 * 20.0, refine=2
    )
    command = Command(
        (complex(1j * a / response(tested.plant, "current", 20.0).acceleration[0]),), 20.0, cycles
    )
    tested.begin(command)
    tested.advance(command)
    ledger = tested.drain_ledger()
    assert exact.max() > 0.0
    assert ledger[:, :2].sum(axis=1) == pytest.approx(exact, abs=2e-3 * exact.max())
    closures = ledger[:, [COUPLED_COLUMNS.index(name) for name in ("closure", "closure_exciter")]]
    assert np.abs(closures).max() < 1e-6
