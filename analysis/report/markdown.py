"""report.md: the report as Markdown text."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from analysis.report import wording
from analysis.report.fidelity import fidelity_sentences
from analysis.report.mistake import mistake_sentences, mistake_tables
from analysis.report.tables import Table, all_tables

if TYPE_CHECKING:
    from analysis.figures import Plot

__all__ = ["markdown_text"]


def markdown_text(report: dict[str, Any], drawn: "Sequence[Plot]" = ()) -> str:
    """The report as Markdown (GitHub tables); figures as links to figures/<name>.svg."""
    name = report["protocol"] or "session"
    parts = [f"# {_plain(name)}: agreement of measured and predicted dissipation", _plain(wording.tested(report))]
    if report["question"]:
        parts.append(f"Question: {_plain(report['question'])}")
    parts += [
        _plain(wording.waveform(report)),
        f"## Verdict: {wording.verdict_line(report)}",
        "\n".join(f"- {_plain(reason)}" for reason in wording.reasons(report)),
        _plain(wording.headline(report)),
        *(f"**{_plain(text)}**" for text in mistake_sentences(report)),
        *map(_table, mistake_tables(report)),
        *map(_plain, fidelity_sentences(report)),
        *(f"![{plot.alt}](figures/{plot.name}.svg)" for plot in drawn),
    ]
    parts += [_table(table) for table in all_tables(report)]
    parts += ["## Again", *(f"`{command}` {why}" for command, why in wording.again(report))]
    return "\n\n".join(parts) + "\n"


def _table(table: Table) -> str:
    lines = [
        f"## {table.title}\n\n{_plain(table.note)}\n",
        "| " + " | ".join(table.head) + " |",
        "|" + "---|" * len(table.head),
        *("| " + " | ".join(_plain(cell.text) for cell in row) + " |" for row in table.rows),
    ]
    return "\n".join(lines)


def _plain(text: str) -> str:
    """Text from a session as text: nothing in it is taken for Markdown, HTML or a table's bar."""
    text = " ".join(str(text).split())
    return "".join(f"\\{c}" if c in "\\`*[]<>|#!" else c for c in text)
