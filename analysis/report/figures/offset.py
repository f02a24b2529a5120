"""Figures of the agreement: offset against W_T, its terms, the null tests as angles, Bland and
Altman.
"""

import math

from analysis.report.figures.axes import (
    BLUE,
    GREEN,
    INK,
    ORANGE,
    Panel,
    legend,
    linear,
    logarithmic,
    signed_logarithmic,
)
from analysis.report.figures.drawing import Plot, thinned, thinned_words
from analysis.report.loss_names import loss_name, short_name
from analysis.results.condition_row import TERMS, ConditionRow, OffsetTerms
from analysis.results.report import Report
from analysis.text import counted

__all__ = ["bland_altman", "nulls_plot", "offset_plot", "terms_plot", "weighted_terms"]


def offset_plot(report: Report) -> Plot | None:
    """Return W_exp / W_T - 1 with U against W_T; None where there is none."""
    stated = _with_offset(report)
    if not stated:
        return None
    rows = thinned(stated)
    W = [1e3 * W_T for _, W_T, _ in rows]
    offset, U = (
        [100 * value for _, _, value in rows],
        [100 * (row.U_offset or 0.0) for row, _, _ in rows],
    )
    ends = [value + sign * half for value, half in zip(offset, U, strict=True) for sign in (-1, 1)]
    panel = Panel(
        logarithmic(W), signed_logarithmic(ends), "W_T, mJ per cycle", "offset, %", height=300
    )
    ratio, U_ratio = report.agreement.ratio, report.agreement.U_ratio
    if ratio is not None and U_ratio is not None:
        panel.spread(100 * (ratio - 1 - U_ratio), 100 * (ratio - 1 + U_ratio), ORANGE, 0.2)
        panel.level(100 * (ratio - 1), ORANGE)
    panel.level(0.0, INK)
    panel.bars(W, offset, U, BLUE)
    alt = (
        f"Offset of the measured from the predicted energy in {counted(len(stated), 'condition')}, per cent with 95 % "
        "uncertainty bars, against W_T on a logarithmic axis; the vertical axis is linear within ±20 % and logarithmic "
        "beyond. The energy-weighted offset is a line with its band. The numbers are in the table of conditions."
        + thinned_words(len(rows), len(stated))
    )
    words = [
        ("o", BLUE, "W_exp/W_T − 1, with U (95 %)"),
        ("line", ORANGE, "energy-weighted, with U (95 %)"),
    ]
    return Plot("offset", "Offset against W_T", alt, (legend(words), panel.drawing()), across=1)


def _with_offset(report: Report) -> list[tuple[ConditionRow, float, float]]:
    """Return the conditions that state an offset, with W_T (J) and the offset."""
    return [
        (row, row.W_T, row.offset)
        for row in report.conditions
        if row.offset is not None and row.W_T is not None
    ]


def weighted_terms(report: Report) -> OffsetTerms | None:
    """Return the terms of the offset as fractions of W_T, weighted with W_T, over the conditions
    that have them.
    """
    split = [
        (row.offset_terms, row.W_T or 0.0)
        for row in report.conditions
        if row.offset_terms is not None
    ]
    total = math.fsum(W_T for _, W_T in split)
    if not split or not total > 0:
        return None
    return OffsetTerms(
        **{
            name: math.fsum(getattr(terms, name) * W_T for terms, W_T in split) / total
            for name in TERMS
        }
    )


def terms_plot(report: Report) -> Plot | None:
    """Return a chart from W_T to W_exp with a column for each term; None without truth."""
    found = weighted_terms(report)
    if found is None:
        return None
    steps, so_far = [], 0.0
    for name, value in found.named():
        steps.append((name, so_far, so_far + 100 * value))
        so_far += 100 * value
    named = [
        *(short_name(name) if name != "remainder" else "rest" for name, _, _ in steps),
        "offset",
    ]
    panel = Panel(
        linear((-0.6, len(steps) + 0.6)),
        linear([0.0, *(end for _, _, end in steps)], zero=True),
        "",
        "% of W_T",
        height=250,
        names=[""] * len(named),
    )
    for place, (name, start, end) in enumerate([*steps, ("offset", 0.0, so_far)]):
        low, high = min(start, end), max(start, end)
        sign = BLUE if end >= start else ORANGE
        colour = GREEN if name == "offset" else sign
        panel.column(place, low, high, colour)
        if abs(end - start) >= 0.05 or name == "offset":
            places = 1 if abs(end - start) < 10 else 0
            panel.word(place, high, f"{end - start:+.{places}f}".replace("-", "−"), up=4)
        panel.word(place, panel.y.low, named[place], up=-14 if place % 2 == 0 else -27)
    panel.level(0.0, INK)
    listed = ", ".join(
        f"{loss_name(name, report)} {100 * value:+.2g} %" for name, value in found.named()
    )
    alt = f"The offset, term by term, as per cent of W_T weighted with energy: {listed}; together {so_far:+.3g} %."
    return Plot("terms", "From W_T to W_exp", alt, (panel.drawing(),), across=1)


def nulls_plot(report: Report) -> Plot | None:
    """Return the null tests as angles with U; None without any."""
    angles = [
        (row, row.dphi, row.U_dphi)
        for row in report.nulls
        if row.dphi is not None and row.U_dphi is not None
    ]
    if not angles:
        return None
    rows = [row for row, _, _ in angles]
    values = [1e3 * (dphi + sign * U) for _, dphi, U in angles for sign in (-1, 1)]
    names = [f"{row.null}, {row.bed_mass:.3g} kg" if row.bed_mass else row.null for row in rows]
    panel = Panel(
        linear((-0.6, len(rows) - 0.4)),
        linear([*values, 0.0]),
        "bed that cannot slide",
        "angle, mrad",
        height=220,
        names=names if len(rows) <= 3 else [row.null for row in rows],
    )
    panel.level(0.0, INK)
    for place, (row, dphi, U) in enumerate(angles):
        colour = ORANGE if row.verdict == "does not hold" else BLUE
        panel.bars([place], [1e3 * dphi], [1e3 * U], colour, "D" if colour == ORANGE else "o")
    words = ", ".join(
        f"{row.null} {1e3 * dphi:.2g} ± {1e3 * U:.2g} mrad" for row, dphi, U in angles
    )
    alt = f"Angle left between the channels with a bed that cannot slide, with U (95 %): {words}. Zero is right."
    return Plot("nulls", "Nulls as angles", alt, (panel.drawing(),), across=1)


def bland_altman(report: Report) -> Plot | None:
    """Return the relative difference against the mean of W_exp and W_T, with bias and limits of
    agreement.

    None with fewer than 3 conditions. Bland and Altman, Lancet 327, 307 (1986); relative because
    the differences grow with W.
    """
    rows = _with_offset(report)
    if len(rows) < 3:
        return None
    mean = [(row.W_exp + W_T) / 2 for row, W_T, _ in rows]
    difference = [100 * (row.W_exp - W_T) / m for (row, W_T, _), m in zip(rows, mean, strict=True)]
    bias = math.fsum(difference) / len(rows)
    s = math.sqrt(math.fsum((d - bias) ** 2 for d in difference) / (len(rows) - 1))
    low, high = bias - 1.96 * s, bias + 1.96 * s
    x = [1e3 * m for m in mean]
    panel = Panel(logarithmic(x), linear([*difference, low, high, 0.0]), "mean of W_exp and W_T, mJ per cycle",
                  "difference, % of the mean", height=270)  # fmt: skip
    panel.level(0.0, INK, 0.8)
    panel.level(bias, ORANGE)
    for edge in (low, high):
        panel.level(edge, ORANGE, 1.2, "5 3")
    points = thinned(list(zip(x, difference, strict=True)))
    panel.dots([m for m, _ in points], [d for _, d in points], BLUE, radius=3.5, hollow=False)
    alt = (
        f"Difference W_exp − W_T in per cent of their mean against that mean, {len(rows)} conditions: "
        f"bias {bias:.3g} %, limits of agreement {low:.3g} % and {high:.3g} %. The limits hold 95 % of differences "
        "like these; the conditions were chosen, so they are no uncertainty of the rig."
        + thinned_words(len(points), len(rows))
    )
    words = [
        ("o", BLUE, "a condition"),
        ("line", ORANGE, "bias"),
        ("dash", ORANGE, "limits of agreement, bias ± 1.96 s"),
    ]
    return Plot("bland_altman", "Bland and Altman", alt, (legend(words), panel.drawing()), across=1)
