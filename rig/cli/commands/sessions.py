"""`rig report` and `rig info`: analyse or describe recorded sessions."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from analysis.text import counted
from daq.chain.block import flag_names
from daq.session.plan import RunInfo
from daq.session.record import Record
from daq.whole_files import UNFINISHED, unfinished
from rig.cli.terminal.output import cores, print_json, print_result, say
from rig.cli.terminal.tables import MOST_ROWS, number, scaled, table, terminal
from rig.cli.terminal.watch import open_watched
from rig.errors import InputError, Mistake

if TYPE_CHECKING:
    from analysis.results.report import Report
    from analysis.shared_work import ForEach

MIXED = f"stopped while it was written, its files do not belong together ({UNFINISHED}); rig report writes it anew"


def report_sessions(
    sessions: Sequence[Path],
    out: Path | None,
    as_json: bool,
    tolerate_gaps: bool = False,
    png: bool = False,
) -> int:
    """Analyse sessions from their records alone and write the reports; return the exit code 0 where
    all verdicts pass.
    """
    from analysis.report.files import write_report

    if out is not None and len(sessions) > 1:
        raise InputError(
            Mistake("--out", "", f"{len(sessions)} sessions", "one session with --out")
        )
    reports = []
    for session in sessions:
        path = session_file(session)
        with open_watched(path) as record:
            report, each = _read(record, tolerate_gaps)
        reports.append(report)
        folder = out or path.parent
        if unfinished(folder):
            print(f"rig: an unfinished report in {folder} is replaced", file=sys.stderr)
        write_report(report, folder, png=png, each=each)
        if not as_json:
            print_result(report, folder)
    if as_json:
        documents = [report.document() for report in reports]
        print_json(documents[0] if len(documents) == 1 else documents)
    return 0 if all(report.passes for report in reports) else 1


def _read(record: Record, tolerate_gaps: bool) -> tuple["Report", "ForEach"]:
    """Return the report of a session, and the way to share out further work on it."""
    from analysis.pipeline import read_session
    from analysis.processes import energies_by_processes, useful
    from analysis.shared_work import shared_by

    count = useful(record, cores())
    each = shared_by(count)
    energies = energies_by_processes(record, count, tolerate_gaps)
    return read_session(record, energies, tolerate_gaps, each), each


def compare_sessions(
    sessions: Sequence[Path],
    out: Path | None,
    as_json: bool,
    same_instruments: bool,
    tolerate_gaps: bool = False,
) -> int:
    """Compare two sessions (`rig report A B`); return 0 where they could be compared, 1 where
    nothing matches.
    """
    from analysis.comparison.two_sessions import compare
    from analysis.report.two_sessions import comparison_sentences, write_comparison

    reports, tools = [], []
    for session in sessions:
        with open_watched(session_file(session)) as record:
            reports.append(_read(record, tolerate_gaps)[0])
            tools.append(_instruments(record))
    same = same_instruments or (tools[0] is not None and tools[0] == tools[1])
    first, second = (session_file(session).parent for session in sessions)
    names = first.resolve().name, second.resolve().name
    if names[0] == names[1]:
        names = first.as_posix(), second.as_posix()
    found = compare(reports[0], reports[1], same, names)
    folder = out or second / f"against_{first.resolve().name}"
    write_comparison(found, folder)
    if as_json:
        print_json(found.document())
    else:
        for sentence in comparison_sentences(found):
            say(sentence)
        say(f"comparison: {folder / 'comparison.html'}")
    return 0 if found.pairs else 1


def _instruments(record: Record) -> object:
    """Return the true state of all instruments from the session's truth; None where it is not
    stated.
    """
    from analysis.comparison.offset_terms import actual_of

    truth = record.truth
    if truth is None or actual_of(truth) is None:
        return None
    return truth.document("instruments"), truth.document("clock")


def validate_session(session: Path, as_json: bool) -> int:
    """List every deviation from the session format; return the exit code 1 where there is one."""
    from analysis.session.documents import session_document_deviations
    from daq.session.validate import session_deviations

    path = session_file(session)
    with open_watched(path) as record:
        found = [*session_deviations(record), *session_document_deviations(record)]
        schema = record.schema
    if as_json:
        print_json({"session": str(path), "schema": schema, "deviations": found})
    else:
        for sentence in found:
            say(sentence)
        say(f"{path}: {len(found) or 'no'} deviation{'' if len(found) == 1 else 's'} from {schema}")
    return 1 if found else 0


def session_info(session: Path, as_json: bool) -> None:
    """Print the content of a session."""
    path = session_file(session)
    with open_watched(path) as record:
        facts = {**_facts(record), "report_unfinished": unfinished(path.parent)}
    if as_json:
        print_json(facts)
        return
    console = terminal()
    for name in ("protocol", "schema", "synthetic", "complete", "truth", "rate"):
        console.print(f"{name}: {facts[name]}")
    if facts["report_unfinished"]:
        console.print(f"report: {MIXED}", soft_wrap=True)
    console.print(
        table(
            "Channels (certified)",
            ("name", "model", "unit", "V/unit", "range V", "pole Hz", "U(k=2)"),
            [
                (
                    c["name"],
                    c["model"],
                    c["unit"],
                    number(c["sensitivity"], 5),
                    number(c["range_V"]),
                    number(c["pole_Hz"]),
                    number(c["calibration_U"]),
                )
                for c in facts["channels"]
            ],
            ("name", "model", "unit"),
        )
    )
    console.print(
        table(
            "Conditions",
            ("id", "grains", "bed", "fill/%", "d/mm", "a", "runs", "complete", "flags"),
            [
                (
                    c["id"],
                    c["material"],
                    c["bed"],
                    scaled(c["fill"], 100),
                    scaled(c["diameter"], 1e3),
                    number(c["acceleration_set"]),
                    str(c["runs"]),
                    str(c["complete_runs"]),
                    " ".join(c["flags"]),
                )
                for c in facts["conditions"][:MOST_ROWS]
            ],
            ("id", "grains", "bed", "flags"),
        )
    )
    more = len(facts["conditions"]) - MOST_ROWS
    if more > 0:
        console.print(
            f"... and {counted(more, 'condition')} more: rig info --json lists all of them"
        )
    for name, value in facts["provenance"].items():
        console.print(f"{name}: {value}", highlight=False)


def _facts(record: Record) -> dict[str, Any]:
    from analysis.session.documents import checked, document_as
    from analysis.session.protocol import SessionProtocol

    protocol = document_as(SessionProtocol, "protocol", record.document("protocol"))
    runs: dict[str, list[Any]] = {}
    for run in record.runs:
        runs.setdefault(run.condition, []).append(run)
    return {
        "protocol": protocol.name if protocol is not None else "",
        "schema": record.schema,
        "synthetic": record.synthetic,
        "complete": record.complete,
        "truth": record.truth is not None,
        "rate": record.rate,
        "channels": [
            {**asdict(info), "pole_Hz": info.pole_Hz} for info in record.channels.values()
        ],
        "conditions": _condition_facts(record, runs),
        "provenance": checked("provenance", record.document("provenance")) or {},
    }


def _condition_facts(record: Record, runs: Mapping[str, Sequence[RunInfo]]) -> list[dict[str, Any]]:
    """Return each condition with the state of its runs."""
    from analysis.session.former_names import condition_today
    from analysis.session.setting import Setting

    found = []
    for key, condition in record.conditions.items():
        Setting.of(condition)  # raises AnalysisError where a condition lacks a field of the table
        own = runs.get(key, [])
        flags = sorted({name for run in own for name in flag_names(run.flags)})
        complete = sum(run.complete for run in own)
        found.append(
            {
                **condition_today(condition),
                "runs": len(own),
                "complete_runs": complete,
                "flags": flags,
            }
        )
    return found


def session_file(session: Path) -> Path:
    """Return the session file itself, or the one in a folder."""
    return session / "session.h5" if session.is_dir() else session
