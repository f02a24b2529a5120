"""report.csv: one line for each condition."""

import csv
import io

from analysis.results.condition_row import TERMS
from analysis.results.report import Report
from daq.strange_text import cell_text

__all__ = ["csv_text"]

COLUMNS = (
    "id",
    "material",
    "density",
    "diameter",
    "fill",
    "bed",
    "drive",
    "bed_mass",
    "frequency",
    "acceleration_set",
    "acceleration",
    "W_exp",
    "s_W_exp",
    "U_W_exp",
    "k",
    "nu",
    "W_net",
    "W_detect",
    "W_T",
    "U_W_T",
    "W_f",
    "W_c",
    "prediction",
    "W_T_low",
    "W_T_high",
    "W_T_as_printed",
    "U_W_T_as_printed",
    "W_T_layers",
    "U_W_T_layers",
    "W_T_column",
    "U_W_T_column",
    "bound",
    "exponent",
    "offset",
    "U_offset",
    "E_n",
    "E_n_truth",
    "eta",
    "U_eta",
    "M_eff",
    "U_M_eff",
    "thd_force",
    "thd_box",
    "period",
    "periodic_share",
    "dKE_bed",
    "W_coil",
    "U_W_coil",
    "E_n_coil",
    "W_T_recorded",
    "U_W_T_recorded",
    "offset_recorded",
    "U_offset_recorded",
    "E_n_recorded",
    "thd_acceleration",
    "force",
    "force_phase",
)


def csv_text(report: Report) -> str:
    """Return the conditions as comma-separated values in SI units, with names as in report.json;
    empty where not known.

    An apostrophe precedes text that a spreadsheet would evaluate as a formula.
    """
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([*COLUMNS, "runs", *(f"offset_{name}" for name in TERMS)])
    for row in report.conditions:
        found = (getattr(row, name) for name in COLUMNS)
        values = ("" if value is None else cell_text(value) for value in found)
        split = row.offset_terms
        terms = [""] * len(TERMS) if split is None else [value for _, value in split.named()]
        table.writerow([*values, len(row.runs), *terms])
    return text.getvalue()
