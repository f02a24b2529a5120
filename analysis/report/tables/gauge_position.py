"""The positions of gauge and accelerometer, and their readings corrected to the box."""

from analysis.report.tables.cells import Cell, Table, fixed, number
from analysis.results.report import Report

__all__ = ["at_box"]


def at_box(report: Report) -> Table:
    """Return W and apparent mass as read and as corrected; no rows where the stinger is not known."""
    rows = tuple(
        (
            Cell(row.id),
            Cell(row.bed),
            Cell(row.gauge or ""),
            Cell(row.accelerometer or ""),
            fixed(row.acceleration, 3),
            number(row.W_exp, 4, 1e3),
            number(row.W_at_box, 4, 1e3),
            fixed(_percent(row.W_exp, row.W_at_box), 2),
            number(row.M_eff, 5),
            number(row.M_eff_at_box, 5),
            fixed(_percent(row.M_eff, row.M_eff_at_box), 2),
        )
        for row in report.conditions
        if row.W_at_box is not None
    )
    note = (
        "Compensated with what the rig file knows of the gauge's mass and of the stinger: W at the box holds no loss "
        "of the stinger, the apparent mass there none of the gauge. Every comparison here uses W_exp as read."
    )
    head = (
        "id",
        "bed",
        "gauge at",
        "accelerometer at",
        "a, m/s²",
        "W_exp, mJ",
        "W at box, mJ",
        "as read, %",
        "M_eff, kg",
        "M_eff at box, kg",
        "as read, %",
    )
    return Table("Place and mass of the gauge", note, head, rows)


def _percent(read: float | None, known: float | None) -> float | None:
    """Return the deviation of a reading in per cent."""
    return 100.0 * (read / known - 1.0) if known and read is not None else None
