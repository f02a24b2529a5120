"""Speed against error of steppers for the shaker-coupled drive: `python -m
rig.benchmarks.problems.coupled_steppers [--out DIR]`.

Ours (the linear system exact, impacts at predicted edges) beside Moreau-Jean with theta = 1/2
(trapezoid, implicit friction, unilateral rows, impacts at the end of a step), at several steps, on
the same beds and commands. The error is the root mean square over some refills of the error of W_f
+ W_c over the first two cycles, against ours at 1/16 of the step; later, small differences between
rows grow until no two runs agree. Times are the least CPU time of a cycle, all steppers in turn, so
that ratios hold on a busy machine too.
"""

import argparse
import io
import json
import time
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import numpy as np
from numba import njit
from numpy.typing import NDArray

from daq.whole_files import write_folder
from rig.beds.janssen_stack import Filling, refill
from rig.catalog.entries import Rig
from rig.catalog.rig_file import load_rig
from rig.drive.amplifier_command import Command
from rig.drive.electrodynamic import STATES, I, V, X
from rig.kernels.rows.coupled_step import Pull, end_velocity
from rig.kernels.rows.tiles import (
    BAND,
    CHUNK,
    CLEARANCE,
    FIELDS,
    HI,
    LO,
    P,
    U,
    W,
    clear,
    from_tiles,
    to_tiles,
    total,
)
from rig.protocol.spec import Drive, Grains, Layers, Scene
from rig.stand.ledger import COLUMNS
from rig.stand.shaker import CoupledStand

Array = NDArray[np.float64]

RATE = 4096 * 20.0
CYCLES = 2
TIMED = 12
HEAT = [COLUMNS.index(name) for name in ("W_f", "W_c")]


@dataclass(frozen=True)
class StepperResult:
    """One stepper at one step: least CPU time per cycle (ms) and relative error of W."""

    stepper: str
    steps: int
    milliseconds: float
    error: float


def stand(scene: Scene, rig: Rig, filling: Filling, refine: int = 1) -> CoupledStand:
    """Return a stand at rest with a current amplifier."""
    return CoupledStand(
        scene, rig, Drive(mode="shaker", amplifier="current"), filling, RATE, refine=refine
    )


def ours(
    scene: Scene, rig: Rig, filling: Filling, amplitude: float, refine: int
) -> tuple[float, float]:
    """Return (heat of the first cycles in J, least CPU time of a later one in ms); `refine` divides
    step and grid.
    """
    tested = stand(scene, rig, filling, refine)
    tested.advance(Command((amplitude + 0j,), 20.0, CYCLES))
    heat = tested.drain_ledger()[:, HEAT].sum()
    walls = []
    for _ in range(TIMED if refine < 16 else 0):
        start = time.process_time()
        tested.advance(Command((amplitude + 0j,), 20.0))
        walls.append(time.process_time() - start)
    return float(heat), 1e3 * min(walls, default=0.0)


def moreau(
    scene: Scene, rig: Rig, filling: Filling, amplitude: float, steps: int
) -> tuple[float, float]:
    """Return the same by Moreau-Jean, theta = 1/2, with the same scalar equation for friction, but
    no signals and no ledger.
    """
    one = stand(scene, rig, filling)
    h, bed = 1.0 / (20.0 * steps), one.bed
    a = one.plant.matrix()
    a[I] = 0.0
    # Trapezoidal rule: (1 - h A/2) y' = (1 + h A/2) y + h b. The current is prescribed, so its row
    # is zero.
    left = np.linalg.inv(np.eye(STATES) - 0.5 * h * a)
    phi = left @ (np.eye(STATES) + 0.5 * h * a)
    thrust, rate = (
        np.asarray(h * column, np.float64) for column in (left[:, V] / one.plant.box, left[:, I])
    )
    edges = np.asarray(np.arange(steps + 1) * h, np.float64)
    around = Pull(bed.row_mass, 0.0, 0.0, one.plant.box, 0.0, 0.0, 0.0)
    n = bed.band.size
    state = np.zeros(STATES), np.zeros(n), np.zeros(n)
    heat, walls = 0.0, []
    for cycle in range(CYCLES + TIMED // 2):
        after = min((cycle + 1) / CYCLES, 1.0)
        before = min(cycle / CYCLES, 1.0)
        command = Command((amplitude * after + 0j,), 20.0).values((amplitude * before + 0j,), edges)
        start = time.process_time()
        spent = _moreau(
            phi, thrust, rate, np.diff(command) / h, around, bed.band, bed.clearance, h, *state
        )
        walls.append(time.process_time() - start)
        heat += spent if cycle < CYCLES else 0.0
    return heat, 1e3 * min(walls[CYCLES:])


@njit(cache=True)
def _moreau(
    phi: Array,
    thrust: Array,
    rate: Array,
    pace: Array,
    around: Pull,
    band: Array,
    clearance: Array,
    h: float,
    y: Array,
    w: Array,
    u: Array,
) -> float:
    """Take all steps of a cycle; return the heat, J. y, w, u are the states of plant and rows,
    updated in place.
    """
    rows, heat, lanes = np.uint64(band.shape[0]), 0.0, np.empty(CHUNK)
    lo, hi, tally = -band, band.copy(), np.zeros((2, band.shape[0] // 64 + 1), np.int64)
    tiles = to_tiles(w, u, lo, hi, band, clearance)
    for k in range(pace.shape[0]):
        for begin in range(np.uint64(0), rows, CHUNK):
            for j in range(np.uint64(0), min(CHUNK, rows - begin)):
                # A wall that the row would cross by the end of the step can push without limit.
                i = begin * FIELDS + j
                ahead, rub = tiles[i + U] + h * (tiles[i + W] - y[V]), tiles[i + BAND]
                tiles[i + HI] = np.inf if ahead <= 0.0 else rub
                tiles[i + LO] = -np.inf if ahead >= tiles[i + CLEARANCE] else -rub
        free = phi @ y + rate * pace[k]
        gain = thrust[V] / h
        _, given, _, _ = end_velocity(
            free[V], y[V], free[V], gain, h, around, tiles, rows, 0.0, tally, lanes
        )
        after = free - thrust * (given / h)
        way = after[X] - y[X]
        clear(lanes)
        for begin in range(np.uint64(0), rows, CHUNK):
            for j in range(np.uint64(0), min(CHUNK, rows - begin)):
                i = begin * FIELDS + j
                slip = way - (tiles[i + W] + 0.5 * tiles[i + P]) * h
                lanes[j] += tiles[i + P] * slip
                tiles[i + U] -= slip
                tiles[i + W] += tiles[i + P]
        heat += around.row_mass / h * total(lanes)
        y[:] = after
    from_tiles(tiles, w, u, lo, hi)
    return heat


def measure(amplitude: float, rows: int, refills: int) -> list[StepperResult]:
    """Return all steppers at all steps with their errors."""
    rig = load_rig("paper")
    scene = Scene(grains=Grains(density=7900.0), losses=(), layers=Layers(rows=rows))
    fillings = [refill(scene, rig, np.random.default_rng(seed)) for seed in range(refills)]
    exact = np.array([ours(scene, rig, filling, amplitude, 16)[0] for filling in fillings])
    methods = [("ours", 512 * k, partial(ours, refine=k)) for k in (1, 2, 4)]
    methods += [
        ("Moreau-Jean, theta = 1/2", 512 * 2**k, partial(moreau, steps=512 * 2**k))
        for k in range(6)
    ]
    for _, _, method in methods:
        method(scene, rig, fillings[0], amplitude)
    found = np.array(
        [[method(scene, rig, f, amplitude) for _, _, method in methods] for f in fillings]
    )
    error = np.sqrt(np.mean((found[:, :, 0] / exact[:, None] - 1.0) ** 2, axis=0))
    least = found[:, :, 1].min(axis=0)
    return [
        StepperResult(name, steps, float(wall), float(wrong))
        for (name, steps, _), wall, wrong in zip(methods, least, error, strict=True)
    ]


def figure(found: list[StepperResult]) -> str:
    """Return the work-precision diagram as SVG: error of W against CPU time per cycle."""
    import matplotlib

    matplotlib.use("svg")
    from matplotlib import pyplot as plt

    plt.rcParams["svg.hashsalt"] = "rig"
    fig, ax = plt.subplots(figsize=(5.5, 3.6), layout="constrained")
    for name, mark in (("ours", "o-"), ("Moreau-Jean, theta = 1/2", "s--")):
        points = [r for r in found if r.stepper == name]
        ax.loglog([r.milliseconds for r in points], [r.error for r in points], mark, label=name)
        for r in points:
            ax.annotate(
                f"{r.steps}",
                (r.milliseconds, r.error),
                textcoords="offset points",
                xytext=(4, 4),
                fontsize=7,
            )
    ax.axvline(2.5, color="0.6", linewidth=0.8)
    ax.set(
        xlabel="CPU per cycle of 50 ms / ms (line: 20 times real time)",
        ylabel="error of W, first two cycles",
    )
    ax.legend()
    text = io.StringIO()
    fig.savefig(text, format="svg", metadata={"Date": None})
    return text.getvalue()


def main() -> None:
    """Measure from the command line, and write results and figure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("bench"))
    parser.add_argument("--amplitude", type=float, default=12.0, help="current, A peak")
    parser.add_argument("--rows", type=int, default=8)
    parser.add_argument("--refills", type=int, default=6)
    given = parser.parse_args()
    found = measure(given.amplitude, given.rows, given.refills)
    rows = json.dumps([asdict(r) for r in found], indent=1) + "\n"
    write_folder(given.out, {"coupled_steppers.json": rows, "coupled_steppers.svg": figure(found)})
    for r in found:
        print(
            f"{r.stepper:26s} {r.steps:6d} steps  {r.milliseconds:7.2f} ms  {50 / r.milliseconds:6.1f} x  {r.error:.1e}"
        )


if __name__ == "__main__":
    main()
