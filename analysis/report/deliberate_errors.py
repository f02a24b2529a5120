"""The sentences and the table of a deliberately bad experiment, at the top of the report."""

from analysis.report.tables.cells import Cell, Table
from analysis.results.report import Report

__all__ = ["deliberate_error_sentences", "deliberate_error_tables"]


def deliberate_error_sentences(report: Report) -> tuple[str, ...]:
    """Return a paragraph about the deliberate error; empty without one."""
    found = report.deliberate_error
    if found is None:
        return ()
    text = f"This is a deliberately bad experiment: {found.what}."
    known = [(row.error, row) for row in found.conditions if row.error is not None]
    if known:
        error, worst = max(known, key=lambda entry: abs(entry[0]))
        text += (
            f" W comes out wrong by {100 * error:+.3g} % in condition {worst.id}; the rule says "
            f"{100 * (worst.predicted or 0.0):+.3g} %."
        )
    return (f"{text} Rule: {found.rule}. It shows in: {found.notice}.",)


def deliberate_error_tables(report: Report) -> tuple[Table, ...]:
    """Return the table of wrong and true W, with the error found and the rule's; empty without a
    deliberate error.
    """
    found = report.deliberate_error
    if found is None:
        return ()
    note = (
        "W_exp as the bad experiment gives it and W_true from the rig's own ledger, mJ per cycle; eta from W_true and "
        f"the apparent mass. Rule: {found.rule}."
    )
    head = (
        "id",
        "W_exp, mJ",
        "W_true, mJ",
        "eta",
        "error, %",
        "predicted, %",
        "error over predicted",
    )
    rows = tuple(
        (
            Cell(row.id),
            _number(row.W_exp, ".4g", 1e3),
            _number(row.W_true, ".4g", 1e3),
            _number(row.eta, ".3g"),
            _number(row.error, "+.3g", 100),
            _number(row.predicted, "+.3g", 100),
            _number(row.ratio, ".3f"),
        )
        for row in found.conditions
    )
    return (Table("The deliberate error", note, head, rows),)


def _number(value: float | None, form: str, scale: float = 1.0) -> Cell:
    """Return a cell in a number format; a dash for None."""
    return (
        Cell("–", numeric=True)
        if value is None
        else Cell(format(scale * value, form), scale * value)
    )
