"""Runs in a file, a JSON line each, so that a stopped computation goes on."""

import json
from pathlib import Path
from typing import Any

from daq.whole_files import write_whole


def append(out: Path, row: dict[str, Any]) -> None:
    """Add a run to a file, which is whole at any time."""
    before = out.read_text(encoding="utf-8") if out.exists() else ""
    write_whole(out, f"{before}{json.dumps(row)}\n")


def read(out: Path) -> list[dict[str, Any]]:
    """Return the runs of a file; none if there is no file."""
    if not out.exists():
        return []
    return [json.loads(line) for line in out.read_text(encoding="utf-8").splitlines()]
