"""The predictions side by side: what W_exp is compared with, and all others that apply."""

from collections.abc import Mapping

from analysis.report.tables.cells import Cell, Table, fixed, number, with_U
from analysis.results.condition_row import ConditionRow
from analysis.results.report import Report

__all__ = ["predictions"]

FEW = 6  # conditions that a note names


def predictions(report: Report) -> Table:
    """Return the table of predictions; no rows where nothing stands beside W_T."""
    shown = [row for row in report.conditions if _has_more(row)]
    rows = tuple(
        (
            Cell(row.id),
            fixed(row.acceleration, 3),
            with_U(row.W_exp, row.U_W_exp, 1e3),
            Cell(row.prediction or ""),
            _headline(row),
            with_U(row.W_T_as_printed, row.U_W_T_as_printed, 1e3),
            with_U(row.W_T_layers, row.U_W_T_layers, 1e3),
            with_U(row.W_T_column, row.U_W_T_column, 1e3),
        )
        for row in shown
    )
    note = (
        "W_T is the prediction that the protocol names, or the default of the bed; the others stand beside it, in mJ per "
        "cycle at the measured acceleration with U for 95 %. As printed: the paper's formula. Layers: its mechanism, event "
        "by event. Column: a surface that flows on a bed that rides, as resolved grains show it. A band states from where "
        "to where W_T may lie."
    )
    for sentence in _not_stated(shown):
        note += f" {sentence}"
    head = ("id", "a, m/s²", "W_exp ± U", "W_T by", "W_T ± U", "as printed", "layers", "column")
    return Table("Predictions", note, head, rows)


def _has_more(row: ConditionRow) -> bool:
    stated = (row.W_T_layers, row.W_T_column, row.U_W_T_as_printed)
    return row.inside is not None or any(value is not None for value in stated)


def _headline(row: ConditionRow) -> Cell:
    """Return W_T with its U, or its band and whether W_exp lies in it."""
    if row.inside is None:
        return with_U(row.W_T, row.U_W_T, 1e3)
    low, high = (number(edge, 3, 1e3).text for edge in (row.W_T_low, row.W_T_high))
    return Cell(f"{low} to {high} ({'inside' if row.inside else 'outside'})")


def _not_stated(rows: list[ConditionRow]) -> list[str]:
    """Return a sentence for every reason that keeps a prediction from being stated."""
    ids: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        reasons: Mapping[str, str] = row.reasons
        for key, why in reasons.items():
            if key != "W_T":  # it is the reason of the one that is named
                ids.setdefault((key, why), []).append(row.id)
    found = []
    for (key, why), names in ids.items():
        more = f" and {len(names) - FEW} more" if len(names) > FEW else ""
        found.append(f"No {key} in {', '.join(names[:FEW])}{more}: {why}.")
    return found
