"""Speed of the grains' kernel: beside LAMMPS, over threads, over the number of grains; and what the
energy per cycle owes to step and stiffness.

Beds are tiles of one poured bed, 25 x 25 x 50 mm, beside and upon one another: a large bed need not
be poured as a whole. They are shaken at 10 m/s^2 and 20 Hz, at 4383 steps a cycle (k = 1e5 N/m);
times begin after a twentieth of a cycle. Two calls are timed in turns, so that other work on the
machine meets both.
"""

import os
import time
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from rig.benchmarks.grains.shaking import ShakenBox, shake
from rig.benchmarks.results.fits import fitted
from rig.benchmarks.timing import against, interleaved, spread
from rig.kernels.grains.engine import Engine, Packing
from rig.lammps_engine.engine import LammpsEngine
from rig.lammps_engine.installed import missing

Row = dict[str, Any]

TILE = ShakenBox(0, 0.025, 0.025, 0.05, 5e-3, 0.85, 20.0, 10.0)
TILES = {1_000: (4, 1, 1), 5_000: (5, 5, 1), 30_000: (7, 7, 3), 100_000: (8, 8, 8)}
"""Tiles along x, y, z by the approximate number of grains."""
PAPER_TILE = replace(TILE, diameter=4e-3)
PAPER_TILES = (6, 6, 8)
"""The paper's box, 150 x 150 x 400 mm, with balls of 4 mm: 134 000."""
FASTER = {1_000: 2.0, 5_000: 2.0, 30_000: 1.7}
"""Speed over LAMMPS's on one core that is asked for."""
THREADS = {1_000: 1.0, 5_000: 1.6, 30_000: 1.9}
"""Speed of two threads over one that is asked for, with both cores idle."""
GRAIN_STEPS = 4e6
"""Grain-steps in a call that is timed."""
WARM = 220


@cache
def _tile(tile: ShakenBox) -> Packing:
    return tile.poured(1)


def tiled(tile: ShakenBox, counts: tuple[int, int, int]) -> tuple[ShakenBox, Packing]:
    """Return the box of a number of tiles along x, y, z, and its grains at rest."""
    one = _tile(tile)
    layer = float(np.max(one.place[:, 2] + one.radius))
    pitch = (tile.length, tile.width, layer)
    corner = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), -1).reshape(-1, 3)
    place = (one.place[None] + (corner * pitch)[:, None]).reshape(-1, 3)
    radius = np.tile(one.radius, len(corner))
    sides = (counts[0] * tile.length, counts[1] * tile.width, counts[2] * tile.height)
    box = replace(tile, length=sides[0], width=sides[1], height=sides[2])
    return box, Packing.at_rest(place, radius, tile.density)


class _Shaken:
    """An engine that goes on with the motion of its box, call by call."""

    def __init__(self, engine: Engine | LammpsEngine, box: ShakenBox, steps: int) -> None:
        self._engine, self._box, self._steps = engine, box, steps
        self._cycle = box.velocity(1)[:-1]
        self._at = 0
        self.impulse = 0.0
        self.advance(WARM)

    def __call__(self) -> None:
        self.advance(self._steps)

    def advance(self, steps: int) -> None:
        """Follow the motion over a number of steps."""
        cycle = np.take(self._cycle, self._at + np.arange(steps + 1), mode="wrap")
        self.impulse = float(self._engine.advance(cycle).impulse[-1])
        self._at = (self._at + steps) % self._box.steps


def _row(method: str, grains: int, steps: int, seconds: list[float], **others: Any) -> Row:
    """Return a row: `rate` in million grain-steps per second."""
    rate = spread([grains * steps / second / 1e6 for second in seconds])
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    return {"kind": "grains", "problem": f"{grains} grains", "method": method, "grains": grains,
            "rate": rate, "load": load, "failure": None, **others}  # fmt: skip


def beside_lammps(size: int, rounds: int) -> list[Row]:
    """Return the speed on one core of our kernel and of LAMMPS, which takes the same steps."""
    if reason := missing():
        raise RuntimeError(reason)
    box, packing = tiled(TILE, TILES[size])
    grains = packing.radius.size
    steps = max(int(GRAIN_STEPS / grains), 50)
    ours = _Shaken(Engine(packing, box.law, box.room, box.dt), box, steps)
    with LammpsEngine(packing, box.law, box.room, box.dt) as engine:
        theirs = _Shaken(engine, box, steps)
        apart = abs(ours.impulse / theirs.impulse - 1.0)
        times = interleaved({"kernel": ours, "LAMMPS": theirs}, rounds)
    claim = against(times, "kernel", "LAMMPS", FASTER[size])
    return [
        _row("kernel, 1 thread", grains, steps, times["kernel"], against=claim, apart=apart),
        _row("LAMMPS, 1 rank", grains, steps, times["LAMMPS"]),
    ]


def two_threads(size: int, rounds: int) -> list[Row]:
    """Return the speed on one and two threads, and whether they gave the same bits."""
    box, packing = tiled(TILE, TILES[size])
    grains = packing.radius.size
    steps = max(int(GRAIN_STEPS / grains), 50)
    engines = [Engine(packing, box.law, box.room, box.dt, threads) for threads in (1, 2)]
    one, two = (_Shaken(engine, box, steps) for engine in engines)
    times = interleaved({"1": one, "2": two}, rounds)
    first, second = (engine.state()._asdict() for engine in engines)
    same = all(np.array_equal(first[name], second[name]) for name in first)
    claim = against(times, "2", "1", THREADS[size])
    return [
        _row("kernel, 1 thread", grains, steps, times["1"]),
        _row("kernel, 2 threads", grains, steps, times["2"], against=claim, same_bits=same),
    ]


def growth(rounds: int, quick: bool) -> list[Row]:
    """Return the time of a step over the number of grains, 1e3 to 1e5, and its exponent."""
    sizes = tuple(TILES)[:3] if quick else tuple(TILES)
    calls: dict[str, Callable[[], None]] = {}
    steps: dict[str, int] = {}
    for size in sizes:
        box, packing = tiled(TILE, TILES[size])
        name = repr(float(packing.radius.size))
        steps[name] = max(int(GRAIN_STEPS / packing.radius.size), 50)
        calls[name] = _Shaken(Engine(packing, box.law, box.room, box.dt), box, steps[name])
    times = interleaved(calls, rounds)
    per_step = {
        float(name): [second / steps[name] for second in each] for name, each in times.items()
    }
    return fitted("grains, kernel", "a step on one thread, at most 1.12 asked for", per_step)


def paper_box(rounds: int) -> list[Row]:
    """Return the speed in the paper's box of 134 000 grains: 2 threads beside LAMMPS on 2 ranks."""
    box, packing = tiled(PAPER_TILE, PAPER_TILES)
    grains = packing.radius.size
    steps = 40
    ours = _Shaken(Engine(packing, box.law, box.room, box.dt, 2), box, steps)
    calls: dict[str, Callable[[], None]] = {"kernel": ours}
    if missing():
        times = interleaved(calls, rounds)
        return [_row("kernel, 2 threads", grains, steps, times["kernel"])]
    with LammpsEngine(packing, box.law, box.room, box.dt, 2) as engine:
        calls["LAMMPS"] = _Shaken(engine, box, steps)
        times = interleaved(calls, rounds)
    claim = against(times, "kernel", "LAMMPS", 1.0)
    return [
        _row("kernel, 2 threads", grains, steps, times["kernel"], against=claim),
        _row("LAMMPS, 2 ranks", grains, steps, times["LAMMPS"]),
    ]


def paper_cycle(threads: int = 2) -> list[Row]:
    """Return the time of one whole cycle of the paper's box at k = 1e5 N/m, a test of speed."""
    box, packing = tiled(PAPER_TILE, PAPER_TILES)
    engine = Engine(packing, box.law, box.room, box.dt, threads)
    start = time.perf_counter()
    found = engine.advance(box.velocity(1))
    seconds = time.perf_counter() - start
    gap = found.work - float(found.loss.sum() + found.energy.sum())
    return [
        _row(f"kernel, {threads} threads, a whole cycle", packing.radius.size, box.steps, [seconds],
             cycle_s=seconds, cycle_steps=box.steps, gap=gap),
    ]  # fmt: skip


def step_and_stiffness(quick: bool) -> list[Row]:
    """Return W of a cycle over the step (fractions of t_c/14) and over k, the same packing."""
    box = ShakenBox(0, 0.1, 0.025, 0.05, 5e-3, 0.85, 20.0, 10.0)
    packing = box.poured(1)
    rows = []
    for fraction in (1.0, 2.0) if quick else (1.0, 1.5, 2.0, 4.0):
        finer = replace(box, resolution=14.0 * fraction)
        rows.append(_precise(finer, packing, f"step t_c/{finer.resolution:g}"))
    for stiffness in (5e4,) if quick else (5e4, 2e5, 5e5):
        rows.append(_precise(replace(box, stiffness=stiffness), packing, f"k = {stiffness:g} N/m"))
    return rows


def _precise(box: ShakenBox, packing: Packing, method: str) -> Row:
    start = time.perf_counter()
    found = shake(box, packing, 4, 6)
    seconds = (time.perf_counter() - start) / 10.0
    cycles = found.work / box.scale(found.mass)
    return {"kind": "grains_precision", "problem": "box B, .85, 10 m/s2", "method": method,
            "kappa": float(cycles.mean()), "scatter": float(cycles.std(ddof=1)),
            "in_phase": float(found.in_phase.mean()), "gap": found.gap, "s_per_cycle": seconds,
            "failure": None}  # fmt: skip
