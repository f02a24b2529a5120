"""Sweeps as curves: force, acceleration, phase and apparent mass against frequency."""

from analysis.report.figures.axes import GREY, SERIES, Panel, legend, linear, logarithmic
from analysis.report.figures.drawing import Plot
from analysis.results.report import Report

__all__ = ["sweep_plot"]

CURVES = (
    ("force", "force, N (peak)", "Force", True),
    ("acceleration", "acceleration, m/s² (peak)", "Acceleration", True),
    ("force_phase", "force leads acceleration, rad", "Phase", False),
    ("M_eff", "apparent mass, kg", "Apparent mass", False),
)


def sweep_plot(report: Report) -> Plot | None:
    """Return the fundamentals against frequency, a line for each sweep; None without sweeps."""
    found = report.sweeps
    if not found:
        return None
    names = [
        ("o", SERIES[n % len(SERIES)], f"{one.condition}, {one.run}: {one.bed}")
        for n, one in enumerate(found)
    ]
    panels = [legend(names)]
    across = linear([f for one in found for f in one.frequency])
    for key, label, title, by_decades in CURVES:
        values = [value for one in found for value in getattr(one, key)]
        panel = Panel(
            across,
            logarithmic(values) if by_decades else linear(values),
            "frequency, Hz",
            label,
            title,
        )
        if not by_decades:
            panel.level(0.0, GREY, 0.8)
        for n, one in enumerate(found):
            panel.line(one.frequency, getattr(one, key), SERIES[n % len(SERIES)])
        panels.append(panel.drawing())
    alt = (
        f"{len(found)} sweep(s), fundamentals of force and acceleration against frequency, the phase between them and "
        "the apparent mass. The numbers are in report.json."
    )
    return Plot("sweeps", "Sweeps", alt, tuple(panels))
