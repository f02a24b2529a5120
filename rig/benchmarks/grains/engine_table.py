"""The kernel against a table of 35 boxes that another kernel computed.

    nice python -m rig.benchmarks.grains.engine_table --out table.jsonl

computes 6 packings of each (about an hour on one core), one line each, goes on where it was
stopped, and prints the table of docs/validity.md. At 5 m/s^2 and above the mean over the packings
must lie within the larger of 10 % and two standard deviations between packings of the given energy;
below, where the energy wanders by a factor 2 over tens of cycles, 4 packings of 30 cycles within a
factor 2.
"""

import argparse
import csv
import math
import statistics
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rig.benchmarks.grains.run_file import append, read
from rig.benchmarks.grains.shaking import ShakenBox, shake
from rig.kernels.grains.engine import Packing

TABLE = Path(__file__).with_name("engine_table.csv")
PACKINGS = 6
LOW = 5.0
"""Level below which the energy wanders, m/s^2."""
LOW_PACKINGS, LOW_CYCLES = 4, 30
WITHIN, FACTOR = 0.10, 2.0


@dataclass(frozen=True)
class TableCase:
    """A box of the table. work : J per cycle; in_phase : mass over the grains' mass."""

    number: int
    box: ShakenBox
    settle: int
    cycles: int
    grains: int
    work: float
    in_phase: float

    @property
    def low(self) -> bool:
        """Whether the level lies where the energy wanders."""
        return self.box.acceleration < LOW


def table_cases() -> tuple[TableCase, ...]:
    """Return the boxes of the table."""
    with TABLE.open(encoding="utf-8", newline="") as file:
        return tuple(_case(k, row) for k, row in enumerate(csv.DictReader(file)))


def _case(number: int, row: dict[str, str]) -> TableCase:
    names = ("Lx", "Ly", "H", "d", "fill", "f", "a", "k", "e", "mup", "muw", "rho")
    box = ShakenBox(int(row["axis"]), *(float(row[name]) for name in names))
    settle, cycles, grains = (int(row[name]) for name in ("ns", "nm", "N"))
    work, in_phase = float(row["W"]), float(row["meff"])
    return TableCase(number, box, settle, cycles, grains, work, in_phase)


def runs(cases: Sequence[TableCase], packings: int) -> Iterator[tuple[TableCase, int]]:
    """Yield every case with every seed, a whole set of packings after the other, bed by bed."""
    beds = sorted(cases, key=lambda case: (case.box.bed, case.number))
    for seed in range(1, packings + 1):
        for case in beds:
            if not case.low or seed <= LOW_PACKINGS:
                yield case, seed


def compute(out: Path, packings: int) -> None:
    """Append the runs that `out` does not have, a JSON line each."""
    done = {(row["case"], row["seed"]) for row in read(out)}
    kept: tuple[Any, Packing] | None = None
    for case, seed in runs(table_cases(), packings):
        if (case.number, seed) in done:
            continue
        start = time.perf_counter()
        if kept is None or kept[0] != (case.box.bed, seed):
            kept = ((case.box.bed, seed), case.box.poured(seed))
        poured = time.perf_counter()
        found = shake(case.box, kept[1], case.settle, LOW_CYCLES if case.low else case.cycles)
        row = {
            "case": case.number,
            "seed": seed,
            "grains": kept[1].radius.size,
            "mass": found.mass,
            "work": float(found.work.mean()),
            "cycles": [float(f"{work:.6g}") for work in found.work],
            "in_phase": float(found.in_phase.mean()),
            "gap": found.gap,
            "pouring_s": round(poured - start, 2),
            "shaking_s": round(time.perf_counter() - poured, 2),
        }
        append(out, row)


@dataclass(frozen=True)
class TableVerdict:
    """A case against its packings. spread : standard deviation between packings over the mean."""

    case: TableCase
    packings: int
    grains: float
    work: float
    spread: float
    in_phase: float
    holds: bool


def judged(rows: Sequence[dict[str, Any]]) -> list[TableVerdict]:
    """Return the verdict on each case that has two packings or more."""
    found = []
    for case in table_cases():
        mine = [row for row in rows if row["case"] == case.number]
        if len(mine) < 2:
            continue
        mean = statistics.mean(row["work"] for row in mine)
        deviation = statistics.stdev(row["work"] for row in mine)
        if case.low:
            holds = abs(math.log(mean / case.work)) <= math.log(FACTOR)
        else:
            holds = abs(mean - case.work) <= max(WITHIN * case.work, 2.0 * deviation)
        grains, in_phase = (
            statistics.mean(row[key] for row in mine) for key in ("grains", "in_phase")
        )
        spread = deviation / mean
        found.append(TableVerdict(case, len(mine), grains, mean, spread, in_phase, holds))
    return found


def lines(verdicts: Sequence[TableVerdict]) -> list[str]:
    """Return the table as Markdown."""
    names = (
        "axis", "box, mm", "d", "fill", "k, N/m", "mu_w", "f, Hz", "a, m/s2", "packings",
        "W given, mJ", "W ours, mJ", "ratio", "spread", "in phase given", "ours", "verdict",
    )  # fmt: skip
    head = "| " + " | ".join(names) + " |"
    found = [head, "|" + "---|" * len(names)]
    for one in verdicts:
        box = one.case.box
        sides = " x ".join(f"{1e3 * side:g}" for side in (box.length, box.width, box.height))
        cells = (
            "xyz"[box.axis],
            sides,
            f"{1e3 * box.diameter:g}",
            f"{box.fill:g}",
            f"{box.stiffness:.0e}".replace("e+0", "e"),
            f"{box.wall_friction:g}",
            f"{box.frequency:g}",
            f"{box.acceleration:g}",
            str(one.packings),
            f"{1e3 * one.case.work:.3g}",
            f"{1e3 * one.work:.3g}",
            f"{one.work / one.case.work:.2f}",
            f"{100.0 * one.spread:.0f} %",
            f"{one.case.in_phase:.2f}",
            f"{one.in_phase:.2f}",
            "holds" if one.holds else "**does not**",
        )
        found.append("| " + " | ".join(cells) + " |")
    held = sum(one.holds for one in verdicts)
    return [*found, "", f"{held} of {len(verdicts)} hold."]


def main() -> None:
    """Compute what is missing and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="file of the runs, JSON lines")
    parser.add_argument("--packings", type=int, default=PACKINGS)
    given = parser.parse_args()
    compute(given.out, given.packings)
    print("\n".join(lines(judged(read(given.out)))))


if __name__ == "__main__":
    main()
