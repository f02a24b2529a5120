"""`rig model --study`: the paper's parametric figures and errata, as tables, figures and CSV."""

from pathlib import Path

from analysis.report.figures.studies import write_study
from rig.cli.terminal.output import print_json
from rig.cli.terminal.tables import number, table, terminal
from rig.errors import InputError, Mistake, nearest
from rig.theory.paper.studies import study

STUDIES = ("friction", "collision", "errata")


def study_files(name: str, out: Path | None, as_json: bool) -> None:
    """Compute a study, print the paper's statements beside the correct values, and write its
    figures and tables.
    """
    if name not in STUDIES:
        raise InputError(
            Mistake("--study", "", repr(name), ", ".join(STUDIES), nearest(name, STUDIES))
        )
    found = study(name)
    written = write_study(dict(found), out if out is not None else Path("studies") / name)
    if as_json:
        print_json(found)
        return
    rows = [
        (
            row["equation"],
            row["subject"],
            number(row["printed_value"]),
            number(row["corrected_value"]),
            row["unit"],
            {True: "holds", False: "does not hold", None: "-"}[row["holds"]],
            row["note"],
        )
        for row in found["rows"]
    ]
    columns = ("eq", "subject", "printed", "corrected", "unit", "paper", "note")
    console = terminal()
    console.print(table("", columns, rows, ("eq", "subject", "unit", "paper", "note")))
    for path in written:
        console.print(str(path), highlight=False, soft_wrap=True)
