"""report.html: one self-contained page, for screen, phone and paper."""

from collections.abc import Iterable, Sequence

from analysis.report import report_sentences
from analysis.report.deliberate_errors import deliberate_error_sentences, deliberate_error_tables
from analysis.report.figures.drawing import Plot, svg_text
from analysis.report.loss_names import losses_sentence
from analysis.report.sections import Section, sections
from analysis.report.style import CSS, SORT
from analysis.report.tables.cells import Cell, Table
from analysis.report.tables.fidelity import fidelity_sentences
from analysis.results.report import Report
from analysis.text import escape
from daq.strange_text import LINES, visible

__all__ = ["html_text", "page"]

LONG = 40  # characters: longer cells may wrap
MANY = 200  # rows: a longer table is folded, so that a browser lays it out only when it is opened
WIDE = 14  # characters: longer words get their own line in a phone's card


def html_text(report: Report, parts: Sequence[Section] | None = None) -> str:
    """Return the report as a page without external references: the purpose of the test and the
    verdict first, then the sections.
    """
    name = report.protocol or "session"
    passes = report.passes
    found = f"<p class='result'>{escape(report_sentences.headline(report))}</p>"
    checks = (
        "<ul>"
        + "".join(f"<li>{escape(reason)}</li>" for reason in report_sentences.reasons(report))
        + "</ul>"
    )
    more = "".join(f"<p>{escape(text)}</p>" for text in report_sentences.found(report))
    why = "".join(
        f"<p class='result'>{escape(text)}</p>" for text in report_sentences.failures(report)
    )
    head = [
        f"<h1>{escape(name)}</h1>",
        f"<p class='lead'>{escape(report_sentences.tested(report))}</p>",
        f"<p><strong>Question:</strong> {escape(report.question)}</p>" if report.question else "",
        *(
            f"<p>{escape(text)}</p>"
            for text in (
                report_sentences.waveform(report),
                report_sentences.support(report),
                losses_sentence(report),
            )
            if text
        ),
        f"<section class='verdict {'good' if passes else 'bad'}' aria-labelledby='verdict'>",
        f"<h2 id='verdict'>Verdict: {escape(report_sentences.verdict_line(report).lower())}</h2>",
        (found if passes else why + found.replace(" class='result'", ""))
        + more
        + checks
        + "</section>",
        *(
            f"<p class='lead'><strong>{escape(text)}</strong></p>"
            for text in deliberate_error_sentences(report)
        ),
        *(
            f"<section>{_table(table, f'm{n}')}</section>"
            for n, table in enumerate(deliberate_error_tables(report))
        ),
        *(f"<p>{escape(text)}</p>" for text in fidelity_sentences(report)),
    ]
    shown = sections(report) if parts is None else parts
    tail = [
        _file(name, text) for name, text in (report.resolved.files() if report.resolved else ())
    ]
    return page(f"{name}: agreement report", head, shown, tail)


def page(
    title: str, head: Iterable[str], parts: Sequence[Section], tail: Iterable[str] = ()
) -> str:
    """Return a page from its title, its first elements (HTML), sections, and last elements (HTML)."""
    body = [*head, *(_section(section, number) for number, section in enumerate(parts)), *tail]
    return (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width, initial-scale=1'><link rel='icon' href='data:,'>"
        f"<title>{escape(title)}</title><style>{CSS}</style></head>\n<body><main>\n"
        + "\n".join(filter(None, body))
        + f"\n</main><script>{SORT}</script></body></html>\n"
    )


def _file(name: str, text: str) -> str:
    shown = f"<summary>The {escape(name)} of this session</summary><pre>{escape(text, LINES)}</pre>"
    return f"<section><details>{shown}</details></section>"


def _section(section: Section, number: int) -> str:
    parts = [f"<p>{escape(text)}</p>" for text in section.sentences]
    alone = len(section.plots) + len(section.tables) == 1
    parts += [_figure(plot, not alone) for plot in section.plots]
    parts += [
        _table(table, f"t{number}-{place}", not alone) for place, table in enumerate(section.tables)
    ]
    return f"<section><h2>{escape(section.title)}</h2>{''.join(parts)}</section>"


def _figure(plot: Plot, titled: bool = True) -> str:
    panels = "".join(
        svg_text(panel, f"{plot.title}: {panel.title}" if panel.title else plot.title)
        for panel in plot.panels
    )
    drawn = f"<figure><div class='panels'>{panels}</div><figcaption class='note'>{escape(plot.alt)}</figcaption></figure>"
    if plot.name.endswith("_log"):
        return f"<details class='switch'><summary>{escape(plot.title)}</summary>{drawn}</details>"
    return f"<h3>{escape(plot.title)}</h3>{drawn}" if titled else drawn


def _table(table: Table, name: str, titled: bool = True) -> str:
    """Return a table with its note; on a phone each row is a card, every value after the name of
    its column.
    """
    head = "".join(
        f"<th scope='col'><button type='button'>{escape(text)}</button></th>" for text in table.head
    )
    rows = "\n".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in table.rows)
    labels = "".join(
        f"#{name} td:nth-child({place})::before{{content:{_quoted(text)}}}"
        for place, text in enumerate(table.head, 1)
    )
    title = f"<h3>{escape(table.title)}</h3>" if titled else ""
    drawn = (
        f"<style>@media screen and (max-width:40rem){{{labels}}}</style>"
        f"<div class='wide' tabindex='0' role='region' aria-label='{escape(table.title)}'><table id='{name}'>"
        f"<thead><tr>{head}</tr></thead>\n<tbody>{rows}</tbody></table></div>"
    )
    if len(table.rows) > MANY:
        drawn = f"<details><summary>{len(table.rows)} rows</summary>{drawn}</details>"
    return f"{title}<p class='note'>{escape(table.note)}</p>{drawn}"


def _quoted(text: str) -> str:
    """Return text as a CSS string."""
    return '"' + "".join(f"\\{ord(c):x} " if c in '"\\<>&' else c for c in visible(text)) + '"'


def _cell(cell: Cell) -> str:
    if cell.value is None and cell.numeric:
        return f"<td class='n'>{escape(cell.text)}</td>"
    if cell.value is None:
        if len(cell.text) > LONG:
            wrap = " class='t'"
        else:
            wrap = " class='w'" if len(cell.text) > WIDE else ""
        return f"<td{wrap}>{escape(cell.text)}</td>"
    return f"<td class='n' data-v='{cell.value:.17g}'>{escape(cell.text)}</td>"
