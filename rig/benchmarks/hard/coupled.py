"""Hard cases of the shaker-coupled drive: exciter, stinger, box and bed move each other
(`rig.stand.shaker`).
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from rig.beds.janssen_stack import bed_mass, nominal
from rig.benchmarks.hard import naive
from rig.benchmarks.hard.case import Case, CaseOutcome, at_least, at_most, exactly, no_more
from rig.catalog.entries import Exciter, Rig
from rig.catalog.rig_file import load_rig
from rig.drive.amplifier_command import Command
from rig.drive.electrodynamic import VA, VB, XA, XB, Plant, V, X, propagator
from rig.protocol.spec import Amplifier, Cavity, Drive, Grains, Layers, Scene, SingleMass
from rig.stand.box import box_mass
from rig.stand.ledger import COUPLED_COLUMNS
from rig.stand.shaker import CoupledStand

Array = NDArray[np.float64]

RATE = 4096 * 20.0
BED = Scene(grains=Grains(density=7900.0), losses=(), layers=Layers(rows=2))


def stand(rig: Rig, scene: Scene, amplifier: Amplifier = "current", **more: object) -> CoupledStand:
    """Return a stand with the default drive at 20 Hz, everything at rest."""
    return CoupledStand(
        scene,
        rig,
        Drive(mode="shaker", amplifier=amplifier),
        nominal(scene, rig),
        RATE,
        **more,  # type: ignore[arg-type]
    )


def column(ledger: Array, name: str) -> Array:
    """Return one column of a coupled ledger."""
    return np.asarray(ledger[:, COUPLED_COLUMNS.index(name)])


def stingers() -> CaseOutcome:
    """Stingers of 1e4 to 1e11 N/m: a locked bed against mechanical impedances, and layers that hit
    the box.
    """
    rig = load_rig("paper")
    response, closure, heat, gone = 0.0, 0.0, 0.0, 0
    locked = replace(BED, bed="locked")
    load = (
        box_mass(BED.cavity, rig.wall_density) + rig.gauge_mass + bed_mass(BED, rig.packing_shaken)
    )
    for stiffness in (1e4, 1e5, 1e8, 1e11):
        # The ringing of the stinger must have decayed when the response is read: 0.3 of critical
        # damping.
        damping = 0.6 * math.sqrt(
            stiffness * (rig.exciter.moving_mass if stiffness > 1e6 else load)
        )
        exciter = replace(
            rig.exciter,
            stinger_stiffness=stiffness,
            stinger_damping=damping,
            isolation_damping_ratio=0.7,
        )
        tested = stand(replace(rig, exciter=exciter), locked)
        tested.advance(Command((1.0 + 0j,), 20.0, 60))
        acceleration = tested.advance(Command((1.0 + 0j,), 20.0))[1]
        found = (
            np.fft.rfft(acceleration)[1]
            * 2.0
            / acceleration.size
            * np.exp(-1j * math.pi / acceleration.size)
        )
        response = max(response, abs(found / _by_impedances(exciter, load, 20.0) - 1.0))
        gone += not np.isfinite(acceleration).all()
        hit = stand(replace(rig, exciter=exciter), BED)
        gone += not np.isfinite(hit.advance(Command((15.0 + 0j,), 20.0, 6))).all()
        ledger = hit.drain_ledger()
        closure = max(
            closure,
            *(float(np.abs(column(ledger, c)[1:]).max()) for c in ("closure", "closure_exciter")),
        )
        electric = np.abs(column(ledger, "W_electric")).max()
        heat = max(
            heat, float(-min(column(ledger, "W_f").min(), column(ledger, "W_c").min()) / electric)
        )
    return CaseOutcome(
        measured=(
            at_most("box acceleration per ampere against impedances, relative", response, 1e-3),
            exactly("signals that are not finite, of 8", gone, 0.0),
            at_most("closure of both accounts with layers", closure, 1e-6),
            at_most("most negative loss over the electric work", heat, 1e-6),
        ),
        naive=(
            at_least(
                "semi-implicit steps, 4096 per cycle, 1e11 N/m: growth per step", _growth(1e11), 2.0
            ),
        ),
    )


def stability() -> CaseOutcome:
    """The linear system without damping, in steps of 0.1 to 1e3 rad of its fastest mode."""
    rig = load_rig("paper")
    near, far = 0.0, 0.0
    for turn in (0.1, 1.99, 2.0, 2.01, 20.0, 1e3):
        interval = turn / math.sqrt(rig.exciter.stinger_stiffness / rig.exciter.moving_mass)
        plant = replace(
            Plant.of(rig.exciter, 50.0),
            force_constant=0.0,
            flexure_damping=0.0,
            stinger_damping=0.0,
            isolation_damping=0.0,
        )
        step = propagator(plant, interval, 1).phi[0]
        y = np.zeros(7)
        y[[XA, VA, X, V, XB, VB]] = 1e-4, 0.1, -1e-4, 0.05, 2e-4, -0.02
        start = _energy(plant, y)
        for _ in range(5):
            y = np.linalg.matrix_power(step, 20_000) @ y
            drift = abs(_energy(plant, y) / start - 1.0)
            near, far = max(near, drift if turn < 3.0 else 0.0), max(far, drift)
    return CaseOutcome(
        measured=(
            at_most("drift of the energy over 1e5 steps of 0.1 to 2.01 rad", near, 1e-9),
            # The round-off of the matrix exponential grows with the norm: 1e-11 a step at 1000 rad.
            at_most("of up to 1000 rad", far, 1e-5),
        ),
        naive=(
            at_least(
                "semi-implicit steps of 2.01 rad: energy after 100 steps over that before",
                naive.oscillator(2.01, 100),
                1e3,
            ),
            at_least("of 1.99 rad: largest over the energy", naive.oscillator(1.99, 100), 10.0),
        ),
    )


def limited() -> CaseOutcome:
    """Commands far beyond the exciter, by voltage and by current: the amplifier stays at its limits
    and flags it.
    """
    rig = load_rig("paper")
    over, closure, clipped, told, gone = 0.0, 0.0, 1.0, 0, 0
    for amplifier, command, peak in (
        ("voltage", 500.0, 60.0),
        ("current", 50.0, 8.0),
        ("current", 100.0, 8.0),
    ):
        weak = replace(rig, exciter=replace(rig.exciter, voltage_peak=peak))
        tested = stand(weak, BED, amplifier, names=("voltage", "current"))  # type: ignore[arg-type]
        tested.advance(Command((command + 0j,), 20.0, 2))
        out = tested.advance(Command((command + 0j,), 20.0, 6))
        gone += not np.isfinite(out).all()
        limits = tested.limits[2:]
        over = max(
            over, *(float(x) for x in np.abs(out).max(axis=1) / (peak, weak.exciter.current_peak))
        )
        clipped = min(clipped, *(one.clipped for one in limits))
        told += all(one.clipped > 0.0 for one in limits)
        ledger = tested.drain_ledger()
        closure = max(
            closure,
            *(float(np.abs(column(ledger, c)[1:]).max()) for c in ("closure", "closure_exciter")),
        )
    absurd = stand(replace(rig, exciter=replace(rig.exciter, voltage_peak=8.0)), BED)
    absurd.advance(Command((1e6 + 0j,), 20.0, 3))
    return CaseOutcome(
        measured=(
            # The current jumps between its limits within an interval: the voltage that this needs
            # is not available, and is flagged.
            exactly(
                "1e6 A: cycles told to be beyond the voltage limit, of 3",
                sum(x.voltage > 1 for x in absurd.limits),
                3.0,
            ),
            # The limit applies at the end of an interval, in which 60 V over 0.3 mH add 2.4 A to 25
            # A.
            exactly("drives flagged in every cycle after the ramp, of 3", told, 3.0),
            at_least("fraction of a cycle at the limit, least", clipped, 0.05),
            no_more("largest voltage or current over its limit", over, 1.1),
            exactly("signals that are not finite, of 3", gone, 0.0),
            at_most("closure of both accounts", closure, 1e-6),
        )
    )


def long_run() -> CaseOutcome:
    """1000 cycles of two layers with one row each: the energy balance at the gauge, summed."""
    rig = load_rig("paper")
    scene = replace(
        BED, grains=replace(BED.grains, fill=0.05, diameter=0.01), layers=Layers(rows=1)
    )
    tested = stand(rig, scene)
    ledgers = []
    for _ in range(100):
        tested.advance(Command((15.0 + 0j,), 20.0, 10))
        ledgers.append(tested.drain_ledger())
    ledger = np.concatenate(ledgers)
    electric = column(ledger, "W_electric")
    return CaseOutcome(
        measured=(
            at_most(
                "drift of the sum at the gauge over the electric work",
                abs(_left(ledger)) / electric.sum(),
                1e-9,
            ),
            exactly(
                "cycles with a value that is not finite",
                int((~np.isfinite(ledger).all(axis=1)).sum()),
                0.0,
            ),
            at_most(
                "closure of any cycle after the first",
                np.abs(column(ledger, "closure")[1:]).max(),
                1e-6,
            ),
        )
    )


def floor() -> CaseOutcome:
    """A plastic single mass of 46 g thrown by a 12 kg box at 2.4 g once a cycle, without a lid and
    with one out of reach.
    """
    rig, cycles = load_rig("paper"), 200
    made = {}
    for gap in (0.2, "none"):
        scene = Scene(
            bed="single_mass",
            axis="vertical",
            grains=Grains(density=3400.0, fill=0.1, diameter=2e-3),
            losses=(),
            cavity=Cavity(length=0.06, width=0.06, height=0.06, wall=0.03),
            single_mass=SingleMass(gap=gap),
        )
        tested = stand(rig, scene)
        tested.advance(Command((25.0 + 0j,), 20.0, cycles))
        made[gap] = tested.drain_ledger()
    lidded, free = made[0.2], made["none"]
    taken = column(lidded, "W_c")[-1]
    return CaseOutcome(
        measured=(
            at_least("landings of the last cycle, J", taken, 1e-3),
            at_most(
                "without a lid: relative difference",
                abs(column(free, "W_c")[-1] / taken - 1.0),
                1e-6,
            ),
            exactly(
                "friction of a single mass that has none, J", np.abs(column(free, "W_f")).max(), 0.0
            ),
            at_most(
                "drift of the sum over the work at the gauge",
                abs(_left(free)) / np.abs(column(free, "W_gauge")).sum(),
                1e-9,
            ),
        )
    )


def _left(ledger: Array) -> float:
    """Return the energy-balance residual at the gauge, summed over all cycles, J."""
    spent = sum(column(ledger, c) for c in COUPLED_COLUMNS[: COUPLED_COLUMNS.index("W_gauge")])
    return float((column(ledger, "W_gauge") - spent).sum())


def _by_impedances(e: Exciter, load: float, f: float) -> complex:
    """Return the acceleration of a rigid load per ampere, e^(+jwt), by two-ports in series from the
    box backwards, without a matrix.
    """
    s = 2j * math.pi * f

    def spring(k: float, ratio: float, mass: float) -> complex:
        return complex(k / s + 2.0 * ratio * math.sqrt(k * mass))

    pull = s * load
    armature = 1.0 + pull / (e.stinger_stiffness / s + e.stinger_damping)
    on_body = pull + s * e.moving_mass * armature
    body = -on_body / (
        s * e.body_mass + spring(e.isolation_stiffness, e.isolation_damping_ratio, e.body_mass)
    )
    flexure = spring(e.flexure_stiffness, e.flexure_damping_ratio, e.moving_mass)
    return complex(s * e.force_constant / (on_body + flexure * (armature - body)))


def _energy(p: Plant, y: Array) -> float:
    """Return the mechanical energy of the linear system, J."""
    return 0.5 * float(
        p.armature * y[VA] ** 2
        + p.body * y[VB] ** 2
        + p.box * y[V] ** 2
        + p.flexure * (y[XA] - y[XB]) ** 2
        + p.stinger * (y[XA] - y[X]) ** 2
        + p.isolation * y[XB] ** 2
    )


def _growth(stiffness: float) -> float:
    """Return the largest factor per step by which semi-implicit steps multiply an oscillation of
    the armature on the stinger.
    """
    turn = math.sqrt(stiffness / 0.5) / RATE
    step = np.array([[1.0 - turn**2, turn], [-turn, 1.0]])
    return float(np.abs(np.linalg.eigvals(step)).max())


CASES = (
    Case(
        "stiff and soft stinger, 1e4 to 1e11 N/m",
        "steps that blow up, a response that the stiffness drowns",
        "the response; both accounts close",
        stingers,
    ),
    Case(
        "step near the stability limit",
        "energy that grows from 2 rad per step on",
        "no limit: exact for any step",
        stability,
    ),
    Case(
        "force-limited drive",
        "a sine that no amplifier can give, taken for granted",
        "held at the limit, flagged, accounts close",
        limited,
    ),
    Case(
        "1000 coupled cycles",
        "energy that leaks step by step",
        "the account closes in the sum",
        long_run,
    ),
    Case(
        "single mass on the floor of a coupled box",
        "a floor that holds what has left it; weight that the account forgets",
        "it lands as under a lid out of reach; the account closes in the sum",
        floor,
    ),
)
