"""Sweeps: force and acceleration against frequency, and where they are largest and least."""

from typing import Any

from analysis.report.axes import GREY, SERIES, Panel, legend, linear, logarithmic
from analysis.report.cells import Cell, Table, number
from analysis.report.drawing import Plot
from analysis.sweep import summary

__all__ = ["sweep_plot", "sweeps"]

CURVES = (
    ("force", "force, N (peak)", "Force", True),
    ("acceleration", "acceleration, m/s² (peak)", "Acceleration", True),
    ("force_phase", "force leads acceleration, rad", "Phase", False),
    ("M_eff", "apparent mass, kg", "Apparent mass", False),
)


def sweep_plot(report: dict[str, Any]) -> Plot | None:
    """Fundamentals against frequency, a line for each sweep; None without sweeps."""
    found = report.get("sweeps") or []
    if not found:
        return None
    names = [
        ("o", SERIES[n % len(SERIES)], f"{one['condition']}, {one['run']}: {one['bed']}") for n, one in enumerate(found)
    ]
    panels = [legend(names)]
    across = linear([f for one in found for f in one["frequency"]])
    for key, label, title, by_decades in CURVES:
        values = [value for one in found for value in one[key]]
        panel = Panel(across, logarithmic(values) if by_decades else linear(values), "frequency, Hz", label, title)
        if not by_decades:
            panel.level(0.0, GREY, 0.8)
        for n, one in enumerate(found):
            panel.line(one["frequency"], one[key], SERIES[n % len(SERIES)])
        panels.append(panel.drawing())
    alt = (
        f"{len(found)} sweep(s), fundamentals of force and acceleration against frequency, the phase between them and "
        "the apparent mass. The numbers are in report.json."
    )
    return Plot("sweeps", "Sweeps", alt, tuple(panels))


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
