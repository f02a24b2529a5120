"""Figures of a single condition: its loop, a cycle, its spectra, and W of every cycle and run."""

import math

import numpy as np

from analysis.report.figures.axes import (
    BLUE,
    GREY,
    INK,
    MARKERS,
    ORANGE,
    SERIES,
    Panel,
    legend,
    linear,
    logarithmic,
)
from analysis.report.figures.drawing import Plot, thinned
from analysis.report.tables.cells import number
from analysis.results.report import Report
from analysis.text import counted

__all__ = ["repeats_plot", "waveform_plot"]

POINTS = 400  # drawn for a cycle
LINES = 30  # harmonics shown


def waveform_plot(report: Report) -> Plot | None:
    """Return force against displacement, a cycle of both channels, and their spectra; None without
    phasors.
    """
    found = report.waveforms
    if not found or not found.force:
        return None
    phasors = [
        np.array([complex(*pair) for pair in pairs]) for pairs in (found.force, found.acceleration)
    ]
    orders, t = np.arange(1, len(found.force) + 1), np.arange(POINTS + 1) / POINTS
    turns = np.exp(2j * np.pi * np.outer(orders, t))
    omega = 2 * math.pi * found.frequency * orders
    force, acceleration = ((each @ turns).real for each in phasors)
    displacement = ((-phasors[1] / omega**2) @ turns).real * 1e3
    loop = Panel(
        linear(displacement),
        linear(force),
        "displacement, mm",
        "force, N",
        "Force against displacement",
    )
    loop.line(displacement.tolist(), force.tolist(), BLUE)
    panels = [loop.drawing()]
    for name, values, unit, colour in (
        ("force", force, "N", BLUE),
        ("acceleration", acceleration, "m/s²", ORANGE),
    ):
        panel = Panel(linear((0, 1)), linear([*values.tolist(), 0.0]), "time, cycles", f"{name}, {unit}",
                      f"{name.capitalize()}, one cycle")  # fmt: skip
        panel.level(0.0, GREY, 0.8)
        panel.line(t.tolist(), values.tolist(), colour)
        panels.append(panel.drawing())
    thds = found.thd_force, found.thd_acceleration
    for name, unit, colour, lines, distortion in zip(
        ("force", "acceleration"), ("N", "m/s²"), (BLUE, ORANGE), phasors, thds, strict=True
    ):
        sizes = [abs(value) for value in lines[:LINES].tolist()]
        floor = max(sizes) * 1e-6
        sizes = [max(size, floor) for size in sizes]
        thd = number(distortion, 2, 100).text
        panel = Panel(linear((0.0, len(sizes) + 1.0)), logarithmic([*sizes, min(sizes) / 2]), "harmonic",
                      f"{name}, {unit} (peak)", f"{name.capitalize()}: THD {thd} %")  # fmt: skip
        for order, size in enumerate(sizes, 1):
            panel.line((order, order), (panel.y.low, size), colour, 3.0)
        panels.append(panel.drawing())
    alt = (
        f"Condition {found.condition}, run {found.run}, mean cycle from its first {len(orders)} harmonics: force "
        "against displacement (its area is W), one cycle of force and acceleration, and both spectra; THD force "
        f"{number(found.thd_force, 2, 100).text} %, acceleration "
        f"{number(found.thd_acceleration, 2, 100).text} %. Force is the whole gauge's: box and bed."
    )
    return Plot("waveforms", f"One cycle of {found.condition}", alt, tuple(panels))


def repeats_plot(report: Report) -> Plot | None:
    """Return W of each cycle of the runs of one condition, and of each run against the order of the
    runs.
    """
    found = report.waveforms
    if not found:
        return None
    runs = [(run.run, [1e3 * W for W in run.W_cycles]) for run in found.runs]
    everything = [W for _, values in runs for W in values]
    each = found.cycles_each
    longest = max(len(values) for _, values in runs) * each
    what = "every cycle" if each == 1 else f"means of {each} cycles"
    panel = Panel(
        linear((1, longest)), linear(everything), "cycle", "W, mJ", f"{found.condition}: {what}"
    )
    for place, (_, values) in enumerate(runs[: len(SERIES)]):
        places = [number * each + (each + 1) / 2 for number in range(len(values))]
        panel.line(places, values, SERIES[place], 0.9)
        panel.dots(places, values, SERIES[place], MARKERS[place % len(MARKERS)], 2.2, hollow=False)
    names = [
        (MARKERS[n % len(MARKERS)], SERIES[n], name)
        for n, (name, _) in enumerate(runs[: len(SERIES)])
    ]
    panels = [legend(names), panel.drawing()]
    drawn = [
        (float(run.order), 100 * (run.W_exp / row.W_exp - 1))
        for row in report.conditions
        if len(row.runs) > 1 and row.W_exp > row.detected
        for run in row.runs
    ]
    count, drawn = len(drawn), list(thinned(drawn))
    if drawn:
        drift = Panel(linear([x for x, _ in drawn]), linear([0.0, *(y for _, y in drawn)]), "order of the runs",
                      "W over its mean − 1, %", "Every run")  # fmt: skip
        drift.level(0.0, INK, 0.8)
        drift.dots([x for x, _ in drawn], [y for _, y in drawn], BLUE, radius=2.5)
        panels.append(drift.drawing())
    counted_runs = (
        f"{count} runs" if len(drawn) == count else f"{len(drawn)} of {count} runs, evenly chosen,"
    )
    alt = (
        f"W of every cycle in {counted(len(runs), 'run')} of {found.condition}"
        + (
            f", and of {counted_runs} over the mean of their condition in the order they were made"
            if drawn
            else ""
        )
        + ": a trend would show what had not settled, or drift. The numbers are in report.json."
    )
    return Plot("repeats", "W per cycle and run", alt, tuple(panels))
