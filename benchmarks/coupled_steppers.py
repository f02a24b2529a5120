"""Steppers for the coupled drive, speed against error: `python -m benchmarks.coupled_steppers [--out DIR]`.

Ours (the linear system exact, impacts at foreseen edges) beside Moreau-Jean with theta = 1/2 (trapezoid, implicit
friction, unilateral rows, impacts at the end of a step), at several steps, on the same bed and command. The error is
that of W_f + W_c over the first cycles against ours at 1/16 of the step: later the rows' small differences grow and no
two runs agree. Both are timed in turn, so that ratios hold on a busy machine as well.
"""

import argparse
import json
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from rig.beds.stack import nominal
from rig.catalog import load_rig
from rig.catalog.entries import Rig
from rig.coupled import CoupledStand
from rig.drive.command import Command
from rig.drive.electrodynamic import STATES, I, V, X
from rig.kernels.two_way import Pull, end_velocity
from rig.ledger import COLUMNS
from rig.scene import Drive, Grains, Layers, Scene

Array = NDArray[np.float64]

RATE = 4096 * 20.0
CYCLES = 3
HEAT = [COLUMNS.index(name) for name in ("W_f", "W_c")]


@dataclass(frozen=True)
class Result:
    """One stepper at one step: CPU per cycle (ms, least of several), W_f + W_c of each cycle (J), its largest error."""

    stepper: str
    steps: int
    milliseconds: float
    heat: list[float]
    error: float = 0.0


def stand(scene: Scene, rig: Rig, refine: int = 1) -> CoupledStand:
    return CoupledStand(
        scene, rig, Drive(mode="coupled", amplifier="current"), nominal(scene, rig), RATE, refine=refine
    )


def ours(scene: Scene, rig: Rig, amplitude: float, refine: int, repeats: int) -> Result:
    """The product's stepper; `refine` divides step and grid."""
    best, heat = np.inf, np.zeros(CYCLES)
    for _ in range(repeats):
        tested = stand(scene, rig, refine)
        tested.advance(Command((0j,), 20.0))
        tested.drain_ledger()
        start = time.process_time()
        tested.advance(Command((amplitude + 0j,), 20.0, CYCLES))
        best = min(best, time.process_time() - start)
        heat = tested.drain_ledger()[:, HEAT].sum(axis=1)
    return Result("ours", 512 * refine, 1e3 * best / CYCLES, heat.tolist())


def moreau(scene: Scene, rig: Rig, amplitude: float, steps: int, repeats: int) -> Result:
    """Moreau-Jean, theta = 1/2, the same scalar equation for friction."""
    one = stand(scene, rig)
    h, bed = 1.0 / (20.0 * steps), one.bed
    a = one.plant.matrix()
    a[I] = 0.0
    left = np.linalg.inv(np.eye(STATES) - 0.5 * h * a)
    phi = left @ (np.eye(STATES) + 0.5 * h * a)
    thrust, rate = h * left[:, V] / one.plant.box, h * left[:, I]
    t = np.arange(CYCLES * steps + 1) * h
    told = Command((amplitude + 0j,), 20.0, CYCLES).values((0j,), t)
    best, heat = np.inf, np.zeros(CYCLES)
    around = Pull(bed.row_mass, 0.0, 0.0, one.plant.box, 0.0, 0.0, 0.0)
    for _ in range(repeats):
        start = time.process_time()
        heat = _moreau(phi, thrust, rate, np.diff(told) / h, around, bed.band, bed.play, steps)
        best = min(best, time.process_time() - start)
    return Result("Moreau-Jean, theta = 1/2", steps, 1e3 * best / CYCLES, heat.tolist())


@njit(cache=True)
def _moreau(
    phi: Array, thrust: Array, rate: Array, pace: Array, around: Pull, band: Array, play: Array, steps: int
) -> Array:
    n, total = band.shape[0], pace.shape[0]
    h = 1.0 / (20.0 * steps)
    y, w, u, p = np.zeros(STATES), np.zeros(n), np.zeros(n), np.zeros(n)
    lo, hi = -band.copy(), band.copy()
    heat = np.zeros(total // steps)
    for k in range(total):
        for i in range(n):  # walls that a row would be behind at the end of the step push without limit
            ahead = u[i] + h * (w[i] - y[V])
            hi[i] = np.inf if ahead <= 0.0 else band[i]
            lo[i] = -np.inf if ahead >= play[i] else -band[i]
        free = phi @ y + rate * pace[k]
        gain = thrust[V] / h
        _, given, _, _ = end_velocity(free[V], y[V], free[V], gain, h, around, band, w, lo, hi, p)
        after = free - thrust * (given / h)
        way = after[X] - y[X]
        for i in range(n):
            slip = way - (w[i] + 0.5 * p[i]) * h
            heat[k // steps] += around.row_mass * p[i] / h * slip
            u[i] -= slip
            w[i] += p[i]
        y = after
    return heat


def measure(amplitude: float, rows: int, repeats: int) -> list[Result]:
    """All steppers at all steps with their errors."""
    rig = load_rig("default")
    scene = Scene(grains=Grains(density=7900.0), losses=(), layers=Layers(rows=rows))
    exact = np.array(ours(scene, rig, amplitude, 16, 1).heat)
    found = [ours(scene, rig, amplitude, refine, repeats) for refine in (1, 2, 4, 8)]
    found += [moreau(scene, rig, amplitude, 512 * 2**k, repeats) for k in range(6)]
    return [
        Result(r.stepper, r.steps, r.milliseconds, r.heat, float(np.abs(np.array(r.heat) / exact - 1.0)[1:].max()))
        for r in found
    ]


def figure(found: list[Result], path: Path) -> None:
    """Work and precision: error of W against CPU time per cycle."""
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot as plt

    plt.rcParams["svg.hashsalt"] = "rig"
    fig, ax = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
    for name, mark in (("ours", "o-"), ("Moreau-Jean, theta = 1/2", "s--")):
        points = [r for r in found if r.stepper == name]
        ax.loglog([r.milliseconds for r in points], [r.error for r in points], mark, label=name)
        for r in points:
            ax.annotate(f"{r.steps}", (r.milliseconds, r.error), textcoords="offset points", xytext=(4, 4), fontsize=7)
    ax.axvline(2.5, color="0.6", linewidth=0.8)
    ax.set(xlabel="CPU per cycle of 50 ms / ms (line: 20 times real time)", ylabel="largest error of W, cycles 2 and 3")
    ax.legend()
    fig.savefig(path, metadata={"Date": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("bench"))
    parser.add_argument("--amplitude", type=float, default=12.0, help="current, A peak")
    parser.add_argument("--rows", type=int, default=8)
    parser.add_argument("--repeats", type=int, default=5)
    told = parser.parse_args()
    found = measure(told.amplitude, told.rows, told.repeats)
    told.out.mkdir(parents=True, exist_ok=True)
    (told.out / "coupled_steppers.json").write_text(json.dumps([asdict(r) for r in found], indent=1) + "\n")
    figure(found, told.out / "coupled_steppers.svg")
    for r in found:
        print(
            f"{r.stepper:26s} {r.steps:6d} steps  {r.milliseconds:7.2f} ms  {50 / r.milliseconds:6.1f} x  {r.error:.1e}"
        )


if __name__ == "__main__":
    main()
