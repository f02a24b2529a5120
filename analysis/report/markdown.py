"""report.md: the report as Markdown text."""

import re
from collections.abc import Iterable, Sequence

from analysis.report import report_sentences
from analysis.report.deliberate_errors import deliberate_error_sentences, deliberate_error_tables
from analysis.report.loss_names import losses_sentence
from analysis.report.sections import Section, sections
from analysis.report.tables.cells import Table
from analysis.report.tables.fidelity import fidelity_sentences
from analysis.results.report import Report
from daq.strange_text import LINES, visible

__all__ = ["markdown_text", "plain", "section_texts"]

_INLINE = re.compile(
    r"[\\`*\[\]<>|#!&~$@]"  # code, emphasis, links, HTML, cells, entities, strikethrough, formulas, addresses
    r"|(?<![^\W_])_|_(?![^\W_])"  # emphasis, unless inside a word
    r"|:(?=[^\s\d])|(?<=www)\.",  # http://..., :smile:, www....
    re.IGNORECASE,
)
_BLOCK = re.compile(r"^[-+=]|^\d{1,9}[.)](?=\s|$)")
"""The first characters of a list, of a rule, or of the line under a heading."""


def markdown_text(report: Report, parts: Sequence[Section] | None = None) -> str:
    """Return the report as Markdown (GitHub tables); figures as links to figures/<name>.svg."""
    name = report.protocol or "session"
    lines = [
        f"# {plain(name)}: agreement of measured and predicted dissipation",
        plain(report_sentences.tested(report)),
    ]
    if report.question:
        lines.append(f"Question: {plain(report.question)}")
    lines += [
        *(
            plain(text)
            for text in (
                report_sentences.waveform(report),
                report_sentences.support(report),
                losses_sentence(report),
            )
            if text
        ),
        f"## Verdict: {plain(report_sentences.verdict_line(report))}",
        *(f"**{plain(text)}**" for text in report_sentences.failures(report)),
        plain(report_sentences.headline(report)),
        *map(plain, report_sentences.found(report)),
        "\n".join(f"- {plain(reason)}" for reason in report_sentences.reasons(report)),
        *(f"**{plain(text)}**" for text in deliberate_error_sentences(report)),
        *map(_table, deliberate_error_tables(report)),
        *map(plain, fidelity_sentences(report)),
        *section_texts(sections(report) if parts is None else parts),
    ]
    return "\n\n".join(lines) + "\n"


def section_texts(parts: Sequence[Section]) -> Iterable[str]:
    """Yield the sections as paragraphs of Markdown."""
    for section in parts:
        yield f"## {plain(section.title)}"
        yield from map(plain, section.sentences)
        yield from (f"![{plain(plot.alt)}](figures/{plot.name}.svg)" for plot in section.plots)
        yield from map(_table, section.tables)


def _table(table: Table) -> str:
    lines = [
        f"### {plain(table.title)}\n\n{plain(table.note)}\n",
        "| " + " | ".join(map(_inline, table.head)) + " |",
        "|" + "---|" * len(table.head),
        *("| " + " | ".join(_inline(cell.text) for cell in row) + " |" for row in table.rows),
    ]
    return "\n".join(lines)


def plain(text: str) -> str:
    """Return text from a session so that nothing in it is taken for Markdown, HTML or a table's
    bar, or hidden.
    """
    return _BLOCK.sub(lambda found: f"{found[0][:-1]}\\{found[0][-1]}", _inline(text))


def _inline(text: str) -> str:
    """Return text for use inside a line, where a number may begin with its sign."""
    return _INLINE.sub(r"\\\g<0>", " ".join(visible(str(text), LINES).split()))
