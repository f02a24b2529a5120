"""`rig model`: both variants of W_T, without a stand and hence without instruments, records and
analysis.
"""

from rig.catalog.rig_file import load_rig
from rig.cli.terminal.output import print_json
from rig.cli.terminal.tables import millijoules, number, table, terminal
from rig.fidelity.choose import resolved
from rig.prediction.document import model_row
from rig.prediction.model import predict
from rig.protocol.grid import conditions
from rig.protocol.load import LoadedProtocol

TITLE = "Energies in mJ per cycle: layers variant, variant as printed (`paper`), bound; longest period of a row in cycles, 0 for none"


def model_table(loaded: LoadedProtocol, as_json: bool) -> None:
    """Print the predicted energies of each condition, and warn where a prediction exceeds the
    bound.
    """
    rig = load_rig(loaded.protocol.rig)
    found = resolved(loaded.protocol, conditions(loaded.protocol), rig)
    rows = [model_row(condition, predict(condition, rig, cycles)) for condition, cycles in found]
    if as_json:
        print_json({"conditions": rows})
        return
    lines = [
        (
            row["id"],
            row["material"],
            f"{1e3 * row['diameter']:g}",
            row["bed"],
            f"{100 * row['fill']:g}",
            number(row["acceleration"]),
            *map(
                millijoules,
                (row["W_f"], row["W_c"], row["W_T"], row["W_T_as_printed"], row["bound"]),
            ),
            str(row["period"]),
        )
        for row in rows
    ]
    columns = (
        "id",
        "grains",
        "d",
        "bed",
        "fill",
        "a",
        "W_f",
        "W_c",
        "W_T",
        "paper",
        "bound",
        "per.",
    )
    console = terminal()
    console.print(table(TITLE, columns, lines, ("id", "grains", "bed")))
    for row in rows:
        for name, label in (("W_T", "layers variant"), ("W_T_as_printed", "variant as printed")):
            if row["bed"] == "layers" and row[name] > row["bound"]:
                console.print(
                    f"{row['id']}: the {label} lies above the bound: impossible at this level"
                )
