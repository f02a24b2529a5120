"""Sweeps in a table: where force and acceleration are largest and least."""

from typing import Any

from analysis.energy.sweep import summary
from analysis.report.tables.cells import Cell, Table, number

__all__ = ["sweeps"]


def sweeps(report: dict[str, Any]) -> Table:
    """Largest and least acceleration of each sweep, and least force, with their frequencies."""
    rows = tuple(
        (
            Cell(row["condition"]), Cell(row["run"]), Cell(row["bed"]), number(row["rate"]),
            number(row["acceleration"]), number(row["at_acceleration"]), number(row["acceleration_least"]),
            number(row["at_acceleration_least"]), number(row["force_least"]), number(row["at_force_least"]),
            number(row["shift_acceleration"], 2, 100), number(row["shift_force"], 2, 100),
        )
        for row in summary(report.get("sweeps") or [])
    )  # fmt: skip
    return Table(
        "Largest and least of each sweep",
        "Fundamentals (peak) over each cycle of the drive. The sweep rate moves the curve off the steady one by "
        "(b/2)|H''|, b the rate of the angular frequency: its largest value over the largest response, told from the "
        "curve itself. "
        "No energy is stated: a swept cycle does not close.",
        (
            "condition", "run", "bed", "rate, Hz/s", "largest a, m/s²", "at, Hz", "least a, m/s²", "at, Hz",
            "least F, N", "at, Hz", "rate's shift of a, %", "of F, %",
        ),
        rows,
    )  # fmt: skip
