"""Whole beds: the layers at five levels by several integrators, and the model variants to choose
from.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np

from rig.beds.janssen_stack import Stack, nominal, stack
from rig.benchmarks.methods import METHODS
from rig.benchmarks.methods.method import Method
from rig.benchmarks.methods.ours import OURS
from rig.benchmarks.methods.rk4 import RK4, solve_steady
from rig.benchmarks.problems.sliders import Slider
from rig.benchmarks.timing import interleaved, peak_memory, ratios, spread
from rig.catalog.entries import Rig
from rig.catalog.rig_file import load_rig
from rig.prediction.own import layers_variant
from rig.prediction.variants import as_printed_variant
from rig.protocol.grid import conditions
from rig.protocol.load import load_protocol
from rig.protocol.spec import Condition

Row = dict[str, Any]

SETTLE = AVERAGE = 64
"""Cycles that a stepping method settles and averages: the layers variant averages as many for rows
without a period.
"""

PROTOCOL = "schema: rig/protocol/1\nname: bench\n"


@dataclass(frozen=True)
class StandardBed:
    """The standard bed (steel, 4 mm, 85 %, 20 Hz) at one level, m/s^2, with a number of rows per
    layer.
    """

    condition: Condition
    rig: Rig
    stack: Stack

    def energy(self, cycles: int = AVERAGE) -> float:
        """Return W of the layers variant, J per cycle; rows without a period are averaged over
        `cycles`.
        """
        drive = self.condition.drive
        return layers_variant(
            self.condition.scene, self.stack, drive.acceleration, drive.frequency, cycles
        ).total


@lru_cache
def bed(level: float, rows: int = 8, extra: tuple[str, ...] = ()) -> StandardBed:
    """Return a bed with the protocol's defaults; `extra`: further settings, as for `--set`."""
    rig = load_rig("paper")
    sets = [f"drive.acceleration={level}", f"scene.layers.rows={rows}", *extra]
    condition = conditions(load_protocol(PROTOCOL, sets=sets))[0]
    return StandardBed(condition, rig, stack(condition.scene, rig, nominal(condition.scene, rig)))


def stepped(found: StandardBed, method: Method, setting: float) -> float:
    """Return W of a bed, J per cycle, with every row followed through all `SETTLE` + `AVERAGE`
    cycles.
    """
    return _by_rows(found, lambda row: method.solve(row, setting, SETTLE, AVERAGE).energy)


def stepped_steady(found: StandardBed, setting: float) -> float:
    """Return W by RK4, J per cycle, with every row followed only until its state recurs, as in the
    layers variant.
    """
    return _by_rows(found, lambda row: solve_steady(row, setting, SETTLE, AVERAGE)[0].energy)


def _by_rows(found: StandardBed, solve: Callable[[Slider], float]) -> float:
    """Return W as the sum of `solve` over the rows that slide, J per cycle."""
    drive, rows = found.condition.drive, found.stack
    unit = rows.row_mass * (drive.acceleration / (2.0 * np.pi * drive.frequency)) ** 2
    length = drive.acceleration / (2.0 * np.pi * drive.frequency) ** 2
    total = 0.0
    for threshold, clearances in zip(rows.threshold, rows.clearance, strict=True):
        if threshold >= drive.acceleration:
            continue
        for clearance in clearances:
            row = Slider(
                "", threshold / drive.acceleration, clearance / length, rows.restitution, 0.0, 0.0
            )
            total += solve(row)
    return unit * total


SAME_CYCLES = f"from event to event, {SETTLE + AVERAGE} cycles throughout, 8 rows"
"""Name of our method under the steppers' rule: row by row, none stopped where its state recurs."""

CLOSED = "layers variant, 8 rows"

STEPPING = (("RK4, events located", 32.0), ("semi-implicit Euler", 400.0), ("semi-implicit Euler", 1600.0),
            ("Moreau time stepping", 400.0))  # fmt: skip


def layers(level: float, rounds: int, quick: bool) -> list[Row]:
    """Compare models and integrators on one bed: time per condition, and error of W against the
    model's own exact result.

    `error`: against the same rows averaged over 4096 cycles (none for the variant as printed).
    `model_error`: against 148 rows per layer and 1024 cycles; quick: 37 rows and 512 cycles. L2/d
    is 37. `times`: time relative to ours under the same rule for the cycles (all of them, or until
    a state recurs), None where there is no counterpart.
    """
    many, long = (37, 512) if quick else (148, 1024)
    reference = bed(level, many).energy(long)
    omega = 2.0 * np.pi * bed(level).condition.drive.frequency
    calls: dict[str, tuple[Callable[[], float], int]] = {
        "variant as printed": (
            partial(as_printed_variant, bed(level).condition.scene, bed(level).rig, level / omega),
            0,
        )
    }
    for rows in (2, 8, 37):
        calls[f"layers variant, {rows} rows"] = (bed(level, rows).energy, rows)
    methods = {method.name: method for method in METHODS}
    calls[SAME_CYCLES] = (partial(stepped, bed(level), OURS, 0.0), 8)
    beside = {}
    for name, setting in STEPPING[:2] if quick else STEPPING:
        title = f"{name}, {setting:g} steps, 8 rows"
        calls[title], beside[title] = (
            (partial(stepped, bed(level), methods[name], setting), 8),
            SAME_CYCLES,
        )
    for setting in (setting for name, setting in STEPPING if name == RK4.name):
        title = f"{RK4.name}, {setting:g} steps, 8 rows, until a state recurs"
        calls[title], beside[title] = (partial(stepped_steady, bed(level), setting), 8), CLOSED
    exact = {rows: bed(level, rows).energy(4096) for rows in (2, 8, 37)}
    found: dict[str, Row] = {}
    for name, (call, rows) in calls.items():
        energy, memory = peak_memory(call)
        found[name] = {
            "kind": "layers",
            "problem": f"layers, {level:g} m/s2",
            "level": level,
            "method": name,
            "W_T": energy,
            "error": abs(energy / exact[rows] - 1.0) if rows else None,
            "model_error": energy / reference - 1.0,
            "reference": f"{many} rows per layer, {long} cycles",
            "memory_kB": memory,
            "failure": None,
        }
    times = interleaved({name: call for name, (call, _) in calls.items()}, rounds)
    for name, seconds in times.items():
        found[name]["ms"] = spread([1e3 * value for value in seconds])
        found[name]["times"] = ratios(seconds, times[beside[name]]) if name in beside else None
    return list(found.values())


def drift(cycles: int, settle: int = 0) -> Iterator[Row]:
    """Yield the energy balance of bed `layers` over many cycles: work = friction + collision +
    change of kinetic energy.
    """
    from rig.beds.layers import LayersBed
    from rig.drive.waveform import Sampling, Waveform

    for level in (2.0, 5.0):
        found = bed(level)
        moving = LayersBed(
            found.stack, Sampling(Waveform(found.condition.drive.frequency, level), 8.0)
        )
        kinetic, largest = moving.kinetic_at_start, 0.0
        left, taken = 0.0, 0.0
        for _ in range(settle, cycles, 100):
            part = moving.advance(100)
            change = np.diff(part.kinetic, prepend=kinetic)
            off = part.work - part.friction - part.collision - change
            kinetic = float(part.kinetic[-1])
            left += float(off.sum())
            taken += float(part.work.sum())
            largest = max(largest, float(np.abs(off).max()))
        yield {
            "kind": "drift", "problem": f"layers, {level:g} m/s2", "cycles": cycles, "left_J": left,
            "drift": abs(left / taken), "largest_J": largest, "W": taken / cycles, "failure": None,
        }  # fmt: skip
