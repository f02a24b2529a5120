"""`rig model`: both tiers of W_T without a stand, hence without instruments, records and analysis."""

from rich.console import Console

from rig.catalog import load_rig
from rig.cli.output import print_json
from rig.cli.tables import number, table
from rig.model import predict
from rig.plan import model_row
from rig.protocol import LoadedProtocol


def model_table(loaded: LoadedProtocol, as_json: bool) -> None:
    """`rig model`."""
    rig = load_rig(loaded.protocol.rig)
    rows = [model_row(condition, predict(condition, rig)) for condition in loaded.protocol.conditions()]
    if as_json:
        print_json({"conditions": rows})
        return
    lines = [
        (
            row["id"], row["material"], row["bed"], f"{row['fill']:.0%}", number(row["diameter"] * 1e3),
            number(row["acceleration"]), number(row["W_f"]), number(row["W_c"]), number(row["W_T"]),
            number(row["W_T_paper"]), number(row["bound"]), str(row["period"]),
        )
        for row in rows
    ]  # fmt: skip
    columns = ("id", "grains", "bed", "fill", "d/mm", "a", "W_f", "W_c", "W_T", "paper", "bound", "period")
    console = Console()
    console.print(table("Energy per cycle, J (closed tier; `paper` is the paper tier)", columns, lines,
                        ("id", "grains", "bed")))  # fmt: skip
    for row in rows:
        for name, label in (("W_T", "closed tier"), ("W_T_paper", "paper tier")):
            if row["bed"] == "layers" and row[name] > row["bound"]:
                console.print(f"{row['id']}: the {label} lies above the bound: impossible at this level")
