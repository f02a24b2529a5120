"""The table and the sentences about resolution and length of the simulations, where a tolerance
chose them.
"""

from analysis.report.tables.cells import UNKNOWN, Cell, Table, number
from analysis.results.report import Report
from analysis.session.fidelity import ChosenFidelity, CycleCounts, Lengths

__all__ = ["fidelity", "fidelity_sentences"]


def fidelity_sentences(report: Report) -> tuple[str, ...]:
    """Return the tolerance, its cost, and the conditions that miss it; empty where the protocol
    wrote everything itself.
    """
    found = report.fidelity
    if found is None:
        return ()
    cycles = found.cycles
    text = (
        f"Fidelity auto, tolerance {100 * found.tolerance:g} % of W per cycle: {cycles.auto} cycles of the drive "
        f"were run; the protocol writes {cycles.written}, and fully resolved they would be {cycles.resolved}."
        f"{_work(found.row_cycles)}"
    )
    if found.not_met:
        text += f" The tolerance is NOT met in {', '.join(found.not_met)}: see the table Fidelity."
    return (text,)


def _work(rows: CycleCounts) -> str:
    """Return the cost in motion of single rows of grains, and the cost of finding the choice."""
    if not rows.auto:
        return " No rows of grains had to be followed."
    return (
        f" Each row of grains counted in each cycle, that is {_times(rows.auto / rows.written)} the work as "
        f"written and {_times(rows.auto / rows.resolved)} the fully resolved; finding the choice took, once, "
        f"{_times((rows.planning or 0.0) / rows.auto)} what was run."
    )


def fidelity(report: Report) -> Table:
    """Return the choice in each condition, its predicted error and what was skipped."""
    head = (
        "id",
        "rows",
        "settle",
        "record",
        "as written",
        "resolved",
        "error, %",
        "of rows, %",
        "of settle, record, %",
        "of noise, %",
        "met",
        "skipped",
    )
    found = report.fidelity
    if found is None:
        return Table("Fidelity", "", head, ())
    rows = tuple(
        (
            Cell(row.id),
            *map(_whole, (row.rows, row.settle, row.record)),
            Cell(_lengths(row, row.written)),
            Cell(_lengths(row, row.resolved)),
            *(
                number(error, 2, 100)
                for error in (row.error, row.error_rows, row.error_window, row.error_noise)
            ),
            Cell("yes" if row.met else f"no: {row.why}"),
            Cell("; ".join(row.skipped)),
        )
        for row in found.conditions
    )
    note = (
        f"Found for a tolerance of {100 * found.tolerance:g} %: rows per layer, cycles to settle and to record. "
        f"Rows may use up {100 * found.rows_share:g} % of it; settling, record and noise share the rest. The "
        "error is predicted for the mean over the runs, against rows side by side (L2/d), settled and recorded "
        "long. As written and resolved: rows, settle + record. The force range is used by the rows that were run; "
        "peaks of them that exceed the exciter (flags over_peak, over_buckling) are those of all rows side by side."
    )
    return Table("Fidelity", note, head, rows)


def _lengths(row: ChosenFidelity, lengths: Lengths) -> str:
    """Return rows, settling and record in words."""
    rows, settle, record = lengths
    return f"{rows if row.rows else '–'}, {settle} + {record}"


def _whole(value: float | None) -> Cell:
    return UNKNOWN if value is None else Cell(str(value), value)


def _times(ratio: float) -> str:
    """Return a ratio in words: 0.31 is "31 % of", 2.04 is "2 times"."""
    return f"{100 * ratio:.2g} % of" if ratio < 0.995 else f"{ratio:.2g} times"
