"""`rig catalog`: every catalog value with its status and source."""

from rig.catalog.table import listing
from rig.cli.terminal.output import print_json
from rig.cli.terminal.tables import number, table, terminal
from rig.errors import InputError, Mistake, nearest

KINDS = ("material", "exciter", "transducer", "analyzer", "rig")


def catalog_table(kind: str, as_json: bool) -> None:
    """Print the catalog's values of one kind, of all kinds for ""."""
    if kind and kind not in KINDS:
        raise InputError(
            Mistake("rig catalog", "kind", repr(kind), ", ".join(KINDS), nearest(kind, KINDS))
        )
    rows = [row for row in listing() if kind in ("", row.kind)]
    if as_json:
        print_json([row._asdict() for row in rows])
        return
    lines = [
        (row.kind, row.name, row.field, number(row.value, 6), row.unit, row.status, row.source)
        for row in rows
    ]
    columns = ("kind", "name", "field", "value", "unit", "status", "source")
    terminal().print(
        table("", columns, lines, ("kind", "name", "field", "unit", "status", "source"))
    )
