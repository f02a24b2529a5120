"""Run `rig import` on a folder of cases of others' records and print what came of each.

python tests/foreign/trial.py FOLDER [NAME ...]

A case is a folder with small input files, `map.yaml` and `expected.json` (W in J per cycle,
`tolerance`, `refusal_is_right_too`, `must_refuse`, `no_overload`). With `again.yaml` the first session is
exported and that file is the mapping of the export. Exit code 1 where a case is wrong.
"""

import contextlib
import io
import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from rig.cli.commands.exchange import export_session, import_session
from rig.cli.errors import _known

SUFFIXES = {"sep005-npz": "npz", "uff58": "uff", "mat": "mat", "csv": "csv"}


def outcome(files: list[Path], mapping: Path, out: Path) -> dict[str, Any]:
    """Return {"report": ...} of an import, or {"refused": sentence}; what else it raises is a defect."""
    printed = io.StringIO()
    try:
        with contextlib.redirect_stdout(printed):
            import_session(files, mapping, out, True, True)
    except Exception as error:
        if _known(error) is None and type(error).__name__ != "InputError":
            raise
        return {"refused": str(error)}
    return {"report": json.loads(printed.getvalue())}


def judged(expected: dict[str, Any], found: dict[str, Any]) -> tuple[str, str]:
    """Return a word for what came (right, refused, flagged, or one that starts with WRONG), and the reason."""
    must, may = expected.get("must_refuse", False), expected["refusal_is_right_too"]
    if "refused" in found:
        return ("refused" if may else "WRONG: refused"), found["refused"]
    report = found["report"]
    row = (report["conditions"] or [{}])[0]
    if row.get("W_exp") is None:
        return ("refused" if may else "WRONG: no W"), "; ".join(report["reasons"])
    W, U = row["W_exp"], row["U_W_exp"]
    flags = [flag for run in row["runs"] for flag in run["flags"]]
    off = abs(W / expected["W"] - 1)
    near = off < expected["tolerance"] and abs(row["frequency"] / expected["frequency"] - 1) < 1e-3
    what = f"W {1e3 * W:.5g} mJ (off {100 * off:.2g} %, U {100 * U / W:.2g} %), {row['frequency']:.6g} Hz, {' '.join(flags)}"
    fails = report["verdict"] != "passes"
    if expected.get("no_overload") and any("overload" in flag for flag in flags):
        return "WRONG: overload", what
    if must:
        return ("flagged" if fails and flags else "WRONG: silent"), what
    if near:
        return ("right" if not fails else "right, flagged"), what
    if fails and flags:
        return "flagged", what
    return "WRONG: silent", what


def tried(case: Path) -> list[tuple[str, str]]:
    """Return the outcomes of a case: one, or one for each export."""
    expected = json.loads((case / "expected.json").read_text())
    record = next(file for file in case.iterdir() if file.name.startswith("r."))
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder)
        found = outcome([record], case / "map.yaml", out / "s")
        results = [judged(expected, found)]
        if (case / "again.yaml").exists() and "report" in found:
            for to, suffix in SUFFIXES.items():
                with contextlib.redirect_stdout(io.StringIO()):
                    export_session(out / "s", to, "1", out / f"e.{suffix}", False, True)
                mapping = out / "again.yaml"
                text = (case / "again.yaml").read_text()
                if to == "csv":
                    text = text.replace("channel: force", "channel: 1")
                    text = text.replace("channel: acceleration", "channel: 2")
                mapping.write_text(text)
                results.append(judged(expected, outcome([out / f"e.{suffix}"], mapping, out / "t")))
    return results


def main(folder: Path, names: list[str]) -> int:
    wrong = energies = 0
    cases = sorted(path.parent for path in folder.glob("*/expected.json"))
    for case in cases:
        if names and not any(case.name.startswith(name) for name in names):
            continue
        results = tried(case)
        for word, why in results:
            print(f"{case.name:34} {word:16} {why[:230]}", flush=True)
        wrong += any(word.startswith("WRONG") for word, _ in results)
        energies += all(word.startswith("right") for word, _ in results)
    print(f"{energies} energies, {wrong} wrong")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), sys.argv[2:]))
