"""`rig model`: W_T in every variant that applies, without a stand and hence without instruments,
records and analysis.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from rig.catalog.rig_file import load_rig
from rig.cli.terminal.output import print_json
from rig.cli.terminal.tables import millijoules, number, table, terminal
from rig.fidelity.choose import resolved
from rig.prediction.document import model_row
from rig.prediction.model import predict
from rig.protocol.grid import conditions
from rig.protocol.load import LoadedProtocol
from rig.protocol.spec import BEDS_OF_GRAINS

TITLE = (
    "Energies in mJ per cycle: W_T by the prediction that is named, its parts, all that apply with "
    "their U (k = 2), and the bound; period in cycles, 0 for none"
)
VARIANTS = (("as_printed", "as printed"), ("layers", "layers"), ("column", "column"))
"""Variants side by side, with their column titles."""
FEW = 6
"""Conditions that a sentence names."""


def model_table(loaded: LoadedProtocol, as_json: bool) -> None:
    """Print the predicted energies of each condition, say which are not stated and why, and warn
    where a prediction exceeds the bound.
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
            row["prediction"],
            millijoules(row["W_f"]),
            millijoules(row["W_c"]),
            _headline(row),
            *(_with_U(row, name) for name, _ in VARIANTS),
            millijoules(row["bound"]),
            "-" if row["period"] is None else str(row["period"]),
        )
        for row in rows
    ]
    titles = (title for _, title in VARIANTS)
    left = ("id", "grains", "bed", "by")
    columns = (
        *left[:2],
        "d",
        "bed",
        "fill",
        "a",
        "by",
        "W_f",
        "W_c",
        "W_T",
        *titles,
        "bound",
        "per.",
    )
    console = terminal()
    console.print(table(TITLE, columns, lines, left))
    for sentence in (*_not_stated(rows), *_beyond_the_bound(rows)):
        console.print(sentence)


def _headline(row: Mapping[str, Any]) -> str:
    """Return W_T in mJ, or its band."""
    if row["W_T_high"] is None:
        return millijoules(row["W_T"])
    return f"{millijoules(row['W_T_low'])} to {millijoules(row['W_T_high'])}"


def _with_U(row: Mapping[str, Any], name: str) -> str:
    """Return a variant's energy in mJ with its uncertainty, where it has any."""
    W, U = row[f"W_T_{name}"], row[f"U_W_T_{name}"]
    return f"{millijoules(W)} ±{millijoules(U, 2)}" if W and U else millijoules(W)


def _not_stated(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return a sentence for every reason that keeps an energy of grains from being stated."""
    ids: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        reasons = row["reasons"] if row["bed"] in BEDS_OF_GRAINS else {}
        for key, why in reasons.items():
            if key == "W_T":  # it is the reason of the one that is named
                continue
            ids.setdefault((key, why), []).append(row["id"])
    sentences = []
    for (key, why), names in ids.items():
        more = f" and {len(names) - FEW} more" if len(names) > FEW else ""
        sentences.append(f"{', '.join(names[:FEW])}{more}: no {key}: {why}")
    return sentences


def _beyond_the_bound(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    return [
        f"{row['id']}: the variant {title} lies above the bound: impossible at this level"
        for row in rows
        for name, title in VARIANTS
        if row["bed"] == "layers" and (row[f"W_T_{name}"] or 0.0) > row["bound"]
    ]
