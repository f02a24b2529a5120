"""Boxes on which the coefficients of prediction `column` are fitted, and boxes held out of the fit.

The fit has two boxes at 20 Hz on a grid of frictions; the held-out cases are drawn at random in two
other boxes. A run settles for 4 cycles and .2 s at least, and counts 6 cycles.
"""

import math
import time
from pathlib import Path

import numpy as np

from rig.benchmarks.grains.run_file import append, read
from rig.benchmarks.grains.shaking import G, ShakenBox, shake

GRAIN_FRICTION, WALL_FRICTION = (0.15, 0.3, 0.5), (0.2, 0.4, 0.6)
FILLS = (0.3, 0.6, 0.85)
FIT_BOXES = (
    ((0.1, 0.025, 0.05), (7.0, 10.0, 14.0, 20.0)),
    ((0.06, 0.025, 0.06), (7.0, 10.0, 18.0)),
)
HELD_OUT_BOXES = ((0.08, 0.04, 0.05), (0.05, 0.03, 0.075))
HELD_OUT, HELD_OUT_SEED = 60, 14
DIAMETER = 5e-3
SETTLE, SETTLE_TIME, CYCLES = 4, 0.2, 6


def fit_cases() -> list[ShakenBox]:
    """Return the boxes of the fit, the levels of one bed together."""
    return [
        ShakenBox(0, *sides, DIAMETER, fill, 20.0, level, grain_friction=mu_p, wall_friction=mu_w)
        for mu_p in GRAIN_FRICTION
        for mu_w in WALL_FRICTION
        for sides, levels in FIT_BOXES
        for fill in FILLS
        for level in levels
    ]


def held_out_cases() -> list[ShakenBox]:
    """Return the held-out boxes: .7 to 2 g, 10 to 80 Hz (both even in logarithms), fills .3 to .95,
    frictions within the grid, the two boxes in turn.
    """
    rng = np.random.default_rng(HELD_OUT_SEED)
    found = []
    for k in range(HELD_OUT):
        level, frequency, fill, mu_p, mu_w = (float(draw) for draw in rng.random(5))
        found.append(
            ShakenBox(
                0,
                *HELD_OUT_BOXES[k % 2],
                DIAMETER,
                round(0.3 + 0.65 * fill, 3),
                round(10.0 * 8.0**frequency, 2),
                round(0.7 * G * (2.0 / 0.7) ** level, 3),
                grain_friction=round(0.15 + 0.35 * mu_p, 3),
                wall_friction=round(0.2 + 0.4 * mu_w, 3),
            )
        )
    return found


def compute(cases: list[ShakenBox], name: str, out: Path) -> None:
    """Append the runs that `out` does not have yet; `name` : of this set of cases."""
    done = {row["case"] for row in read(out) if row["set"] == name}
    kept = None
    for k, box in enumerate(cases):
        if k in done:
            continue
        start = time.perf_counter()
        if kept is None or kept[0] != box.bed:
            kept = (box.bed, box.poured(1000 + k))
        settle = max(SETTLE, math.ceil(SETTLE_TIME * box.frequency))
        found = shake(box, kept[1], settle, CYCLES)
        append(
            out,
            {
                "set": name,
                "case": k,
                "grains": kept[1].radius.size,
                "mass": found.mass,
                "work": float(found.work.mean()),
                "cycles": [float(f"{work:.6g}") for work in found.work],
                "in_phase": float(found.in_phase.mean()),
                "gap": found.gap,
                "seconds": round(time.perf_counter() - start, 2),
            },
        )
