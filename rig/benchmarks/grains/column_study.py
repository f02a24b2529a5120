"""Coefficients of prediction `column` from grains, and what it is worth on boxes held out of the fit.

    nice python -m rig.benchmarks.grains.column_study --out column.jsonl

runs the boxes of `column_cases`, goes on where it was stopped, and prints the lines of
`rig/theory/column_table.csv` and the table of docs/validity.md.
"""

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize

from rig.benchmarks.grains.column_cases import (
    GRAIN_FRICTION,
    WALL_FRICTION,
    compute,
    fit_cases,
    held_out_cases,
)
from rig.benchmarks.grains.plain_curves import plain_curves
from rig.benchmarks.grains.run_file import read
from rig.benchmarks.grains.shaking import G, ShakenBox
from rig.theory.column import (
    ColumnBed,
    ColumnCoefficients,
    YieldProfile,
    column_total,
    outside,
    relative_uncertainty,
)
from rig.theory.column_table import FrictionTable

Array = NDArray[np.float64]

WITHIN = 0.3
"""A prediction counts as right within this fraction."""
COVERED = 1.645
"""Standard deviations of the stated interval, 90 %."""


@dataclass(frozen=True)
class GrainRun:
    """A box and what the grains took. kappa : energy per cycle over M V^2"""

    box: ShakenBox
    mass: float
    kappa: float
    in_phase: float

    @property
    def level(self) -> float:
        """Peak acceleration over gravity."""
        return self.box.acceleration / G

    @property
    def bed(self) -> ColumnBed:
        """The bed as the column takes it."""
        box = self.box
        sides = (box.length, box.width, box.height)
        return ColumnBed(*sides, box.diameter, box.fill, self.mass)


def points(rows: Sequence[dict[str, Any]], name: str, cases: list[ShakenBox]) -> list[GrainRun]:
    """Return the runs of a set of cases."""
    return [
        GrainRun(
            cases[row["case"]],
            row["mass"],
            row["work"] / cases[row["case"]].scale(row["mass"]),
            row["in_phase"],
        )
        for row in rows
        if row["set"] == name
    ]


def kappa(point: GrainRun, mu0: float, dK: float, mu_w_K: float, q: float) -> tuple[float, float]:
    """Return W/(M V^2) of the formula, and its depth of flow in grains."""
    box = point.box
    found = column_total(
        point.bed,
        ColumnCoefficients(YieldProfile(mu0, dK, mu_w_K), q),
        box.acceleration,
        box.frequency,
        G,
    )
    return float(found.W_T) / box.scale(point.mass), float(found.flow)


def fitted(fit: Sequence[GrainRun]) -> FrictionTable:
    """Return the coefficients: mu0 and dK at each pair of frictions, one K = mu_w_K/mu_w and one q
    for all, by least squares of ln W.
    """
    pairs = [(mu_p, mu_w) for mu_p in GRAIN_FRICTION for mu_w in WALL_FRICTION]
    of = [pairs.index((one.box.grain_friction, one.box.wall_friction)) for one in fit]
    target = np.log([one.kappa for one in fit])

    def values(p: Array) -> list[tuple[float, ...]]:
        n, (K, q) = len(pairs), p[-2:]
        return [(p[k], p[n + k], K * mu_w, q) for k, (_, mu_w) in enumerate(pairs)]

    def residuals(p: Array) -> Array:
        table = values(p)
        return np.log([kappa(one, *table[k])[0] for one, k in zip(fit, of, strict=True)]) - target

    n = len(pairs)
    start = np.array([0.37] * n + [3.5] * n + [0.33, 4.6])
    low, high = [0.05] * n + [0.0] * n + [0.0, 1.5], [1.5] * n + [20.0] * n + [2.0, 20.0]
    found = optimize.least_squares(  # type: ignore[operator]  # taken for a module
        residuals, start, bounds=(low, high), loss="soft_l1", f_scale=0.2
    ).x
    return FrictionTable.of([(*pair, *row) for pair, row in zip(pairs, values(found), strict=True)])


def right(ratios: Sequence[float]) -> float:
    """Return the fraction of ratios prediction/grains within 30 %."""
    return float(np.mean(np.abs(np.array(ratios) - 1.0) <= WITHIN))


def report(fit: Sequence[GrainRun], held: Sequence[GrainRun]) -> list[str]:
    """Return the table of coefficients, the verdicts and a line per held-out case."""
    table = fitted(fit)
    lines = [
        f"formula,{mu_p:g},{mu_w:g},{','.join(f'{v:.4g}' for v in table.at(mu_p, mu_w))}"
        for mu_p in GRAIN_FRICTION
        for mu_w in WALL_FRICTION
    ]
    ratios, stated, covered, cases = [], [], [], []
    for one in held:
        box = one.box
        values = table.at(box.grain_friction, box.wall_friction)
        predicted, flow = kappa(one, *(float(v) for v in values))
        reasons = outside(one.bed, flow, one.level, box.wall_friction)
        ratio = predicted / one.kappa
        ratios.append(ratio)
        u = relative_uncertainty(one.level)
        covered.append(abs(math.log(ratio)) <= COVERED * u)
        stated.append(not reasons)
        cases.append(
            f"| {'x'.join(f'{1e3 * s:g}' for s in (box.length, box.width, box.height))} "
            f"| {box.fill:g} | {box.frequency:g} | {one.level:.2f} | {box.grain_friction:g} "
            f"| {box.wall_friction:g} | {one.kappa:.3f} | {predicted:.3f} | {ratio:.2f} "
            f"| {'; '.join(reasons)} |"
        )
    inside = [ratio for ratio, yes in zip(ratios, stated, strict=True) if yes]
    held_in = [yes for yes, kept in zip(covered, stated, strict=True) if kept]
    own = [kappa(one, *table.at(one.box.grain_friction, one.box.wall_friction))[0] for one in fit]
    lines += [
        f"fit: {len(fit)} runs, within 30 %: {right([p / o.kappa for p, o in zip(own, fit, strict=True)]):.3f}",
        f"held out: {len(held)} runs, within 30 %: {right(ratios):.3f}; "
        f"stated {len(inside)}, within 30 %: {right(inside):.3f}, "
        f"interval holds {float(np.mean(held_in)):.3f}",
    ]
    levels, kappas = [one.level for one in fit], [one.kappa for one in fit]
    for name, curve in plain_curves(levels, kappas).items():
        lines.append(f"{name}: {right([curve(one.level) / one.kappa for one in held]):.3f}")
    return [*lines, *cases]


def main() -> None:
    """Run what is missing and print the report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="file of the runs, JSON lines")
    parser.add_argument("--only-report", action="store_true", help="compute no more runs")
    given = parser.parse_args()
    fit, held = fit_cases(), held_out_cases()
    if not given.only_report:
        compute(fit, "fit", given.out)
        compute(held, "held out", given.out)
    rows = read(given.out)
    print("\n".join(report(points(rows, "fit", fit), points(rows, "held out", held))))


if __name__ == "__main__":
    main()
