"""Tables of the origin of an offset: its terms in each condition, and the marks of every candidate
cause.
"""

import math

from analysis.report.loss_names import first_principles, loss_name, short_name
from analysis.report.tables.cells import UNKNOWN, Cell, Table, fixed, number, significant
from analysis.results.condition_row import TERMS
from analysis.results.report import Report
from analysis.results.session_rows import CauseRow, Growth

__all__ = ["causes", "offset_terms"]

LOSSES = ("noise", "air", "gas", "guide friction", "cords")
"""Causes that the protocol switches on."""


def offset_terms(report: Report) -> Table:
    """Return the offset of each condition, term by term."""
    title, head = (
        "Offset, term by term",
        ("id", "offset, %", *(f"{short_name(name)}, %" for name in TERMS)),
    )
    split = [(row, row.offset_terms) for row in report.conditions if row.offset_terms is not None]
    if not split:
        return Table(title, "", head, ())
    rows = tuple(
        (Cell(row.id), _percent(row.offset), *(_percent(value) for _, value in terms.named()))
        for row, terms in split
    )
    left = [(abs(terms.remainder), row.allowed_remainder or math.inf, row) for row, terms in split]
    remainder, allowed, worst = max(left, key=lambda each: each[0] / each[1])
    within = "within" if remainder <= allowed else "beyond"
    note = (
        "Percent of W_T, from the rig's own ledger and the true state of its instruments; the terms add up to the "
        f"offset. Losses outside the grains: viscous, {loss_name('noise', report)}; quadratic, "
        f"{loss_name('air', report)}; gas and mount. phase and scale are the instruments; refill is what the refilled "
        "bed dissipated beyond W_T at the level reached, the waveform's part included where no ablation "
        f"separates them. The remainder nearest to its limit, {significant(100 * remainder, 2)} % in {worst.id}, is "
        f"{within} the {significant(100 * allowed, 2)} % that are allowed there."
    )
    return Table(title, note, head, rows)


def causes(report: Report) -> Table:
    """Return the candidate causes with their marks."""
    head = (
        "cause", "law", "in this run", "% of W_T", "power of a", "power of mass", "power of fill",
        "left empty, % of full", "left locked, % of full", "in words",
    )  # fmt: skip
    losses = [row for row in report.causes if row.cause in LOSSES]
    off = report.synthetic and bool(losses) and not any(row.in_run for row in losses)
    shown = [row for row in report.causes if row.in_run or not off]
    rows = tuple(
        (
            Cell(loss_name(row.cause, report)),
            Cell(row.law),
            Cell("yes" if row.in_run else "no, computed"),
            _left(row.share, "run" if row.in_run else "computed"),
            *_powers(row.grows_with),
            _left(row.empty, row.empty_from),
            _left(row.locked, row.locked_from),
            Cell(" ".join(filter(None, (row.words, *_here(row, report))))),
        )
        for row in shown
    )
    if off:
        note = (
            "What could put W_exp above W_T. All losses of the box are switched off in this run (losses: []), so that "
            "only the instruments are left: the powers of acceleration, moving mass and fill with which they grow, and "
            "what they leave in the empty and in the locked box, over the largest W_T at the same level (in brackets: "
            "computed)."
        )
        return Table("Causes of an offset", note, head, rows)
    note = (
        "What could put W_exp above W_T, and how to distinguish it: the powers of acceleration, moving mass and fill with which "
        "it grows, fitted over conditions that differ in nothing else, and what it leaves in the empty and in the "
        "locked box, over the largest W_T at the same level. In brackets: computed for this rig, not taken from this "
        "run. A loss that knows no mass stays in the empty box: never 7 % of a full one and nearly nothing there."
    )
    return Table("Causes of an offset", note, head, rows)


def _here(row: CauseRow, report: Report) -> tuple[str, ...]:
    """Return the facts about a cause in this session, in sentences."""
    size = first_principles(row.cause, report)
    return tuple(f"Here: {text}." for text in (size, row.note) if text)


def _percent(value: float | None) -> Cell:
    return UNKNOWN if value is None else fixed(100 * value, 2)


def _powers(grows: Growth) -> tuple[Cell, ...]:
    return tuple(map(_power, (grows.acceleration, grows.mass, grows.fill)))


def _power(exponent: float | None) -> Cell:
    return UNKNOWN if exponent is None else Cell(f"{round(exponent, 2) + 0.0:.2f}", exponent)


def _left(fraction: float | None, source: str | None) -> Cell:
    """Return a fraction in per cent, in brackets where it was computed."""
    cell = number(fraction, 2, 100)
    if fraction is None:
        return cell
    return Cell(f"({cell.text})", cell.value) if source == "computed" else cell
