"""`rig schema`: JSON Schemas for editors and for readers of reports."""

import json
from pathlib import Path

from rig.cli.files import write_new
from rig.errors import InputError, Mistake, nearest

KINDS = ("protocol", "report")


def schema_text(kind: str, out: Path | None, force: bool) -> None:
    """Print the schema, or write it to a file."""
    if kind not in KINDS:
        raise InputError(Mistake("rig schema", "kind", repr(kind), ", ".join(KINDS), nearest(kind, KINDS)))
    if kind == "protocol":
        from rig.schema import protocol_schema

        schema = protocol_schema()
    else:
        from analysis.report.shape import report_schema

        schema = dict(report_schema())
    text = json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
    if out is None:
        print(text, end="")
        return
    write_new(out, text, force)
    print(f"Wrote {out}")
