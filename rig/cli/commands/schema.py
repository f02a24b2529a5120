"""`rig schema`: JSON Schemas for editors and for readers of reports."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rig.cli.terminal.files import write_new
from rig.cli.terminal.output import say
from rig.errors import InputError, Mistake, nearest

KINDS = ("protocol", "report", "comparison", "map")


def schema_text(kind: str, out: Path | None, force: bool) -> None:
    """Print the schema of a kind of document, or write it to a file."""
    if kind not in KINDS:
        raise InputError(
            Mistake("rig schema", "kind", repr(kind), ", ".join(KINDS), nearest(kind, KINDS))
        )
    schema = schema_of(kind)
    text = json.dumps(schema, indent=1, ensure_ascii=False) + "\n"
    if out is None:
        print(text, end="")
        return
    write_new(out, text, force)
    say(f"Wrote {out}")


def schema_of(kind: str) -> Mapping[str, Any]:
    """Return the JSON Schema of one of KINDS."""
    if kind == "protocol":
        from rig.protocol.load import protocol_schema

        return protocol_schema()
    if kind == "map":
        from rig.importing.mapping import mapping_schema

        return mapping_schema()
    from analysis.report.json_schema import comparison_schema, report_schema

    return report_schema() if kind == "report" else comparison_schema()
