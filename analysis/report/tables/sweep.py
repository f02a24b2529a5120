"""The table of sweeps: frequencies of the largest and least force and acceleration."""

from analysis.energy.sweep import summary
from analysis.report.tables.cells import Cell, Table, number
from analysis.results.report import Report

__all__ = ["sweeps"]


def sweeps(report: Report) -> Table:
    """Return the largest and least acceleration of each sweep and its least force, with their
    frequencies.
    """
    rows = tuple(
        (
            Cell(one.condition), Cell(one.run), Cell(one.bed), number(one.rate),
            *map(number, (*found.acceleration, *found.acceleration_least, *found.force_least)),
            number(one.shift_acceleration, 2, 100), number(one.shift_force, 2, 100),
        )
        for one, found in ((one, summary(one)) for one in report.sweeps)
    )  # fmt: skip
    return Table(
        "Largest and least of each sweep",
        "Fundamentals (peak) over each cycle of the drive. The sweep rate moves the curve off the steady one by "
        "(b/2)|H''|, b the rate of the angular frequency: its largest value over the largest response, estimated from "
        "the curve itself. "
        "No energy is stated: a swept cycle does not close.",
        (
            "condition",
            "run",
            "bed",
            "rate, Hz/s",
            "largest a, m/s²",
            "at, Hz",
            "least a, m/s²",
            "at, Hz",
            "least F, N",
            "at, Hz",
            "rate's shift of a, %",
            "of F, %",
        ),
        rows,
    )
