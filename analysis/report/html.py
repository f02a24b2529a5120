"""report.html: one self-contained page, for screen, phone and paper."""

import re
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, Any

from analysis.report import wording
from analysis.report.fidelity import fidelity_sentences
from analysis.report.mistake import mistake_sentences, mistake_tables
from analysis.report.style import CSS, SORT
from analysis.report.tables import Cell, Table, all_tables

if TYPE_CHECKING:
    from analysis.figures import Plot

__all__ = ["html_text"]

LONG = 40  # characters: longer cells may wrap


def html_text(report: dict[str, Any], drawn: "Sequence[Plot]" = ()) -> str:
    """The report as a page without any outside reference: verdict first, then figures and tables."""
    name = escape(report["protocol"] or "session")
    passes = report["verdict"] == "passes"
    body = [
        f"<h1>{name}</h1>",
        f"<p class='lead'>{escape(wording.tested(report))}</p>",
        f"<p><strong>Question:</strong> {escape(report['question'])}</p>" if report["question"] else "",
        f"<p>{escape(wording.waveform(report))}</p>",
        f"<section class='verdict {'good' if passes else 'bad'}' aria-labelledby='verdict'>",
        f"<h2 id='verdict'>Verdict: {escape(wording.verdict_line(report).lower())}</h2>",
        f"<p class='result'>{escape(wording.headline(report))}</p>",
        "<ul>" + "".join(f"<li>{escape(reason)}</li>" for reason in wording.reasons(report)) + "</ul></section>",
        *(f"<p class='lead'><strong>{escape(text)}</strong></p>" for text in mistake_sentences(report)),
        *map(_table, mistake_tables(report)),
        *(f"<p>{escape(text)}</p>" for text in fidelity_sentences(report)),
        *map(_figure, drawn),
        *map(_table, all_tables(report)),
        "<section><h2>Again</h2>",
        *(f"<p><code>{escape(command)}</code><br>{escape(why)}</p>" for command, why in wording.again(report)),
        "</section>",
    ]
    return (
        "<!doctype html>\n<html lang='en'><head><meta charset='utf-8'>"
        "<meta name='viewport' content='width=device-width, initial-scale=1'>"
        f"<title>{name}: agreement report</title><style>{CSS}</style></head>\n<body><main>\n"
        + "\n".join(filter(None, body))
        + f"\n</main><script>{SORT}</script></body></html>\n"
    )


def _figure(plot: "Plot") -> str:
    drawing = plot.svg[plot.svg.index("<svg") :]
    tag, rest = drawing.split(">", 1)
    tag = re.sub(r' (?:width|height)="[^"]*"', "", tag)  # the page sets the size, from the viewBox
    rest = re.sub(r'<g id="[^"]*">', "<g>", rest)  # nothing refers to groups, and two figures number them alike
    drawing = f'{tag} role="img" aria-label="{escape(plot.alt)}">{rest}'
    return (
        f"<section><h2>{escape(plot.title)}</h2><div class='wide' tabindex='0'><figure>{drawing}</figure></div>"
        f"<p class='note'>{escape(plot.alt)}</p></section>"
    )


def _table(table: Table) -> str:
    head = "".join(f"<th scope='col'><button type='button'>{escape(text)}</button></th>" for text in table.head)
    rows = "\n".join("<tr>" + "".join(map(_cell, row)) + "</tr>" for row in table.rows)
    return (
        f"<section><h2>{escape(table.title)}</h2><p class='note'>{escape(table.note)}</p>"
        f"<div class='wide' tabindex='0'><table><thead><tr>{head}</tr></thead>\n<tbody>{rows}</tbody></table></div>"
        "</section>"
    )


def _cell(cell: Cell) -> str:
    if cell.value is None and cell.numeric:
        return f"<td class='n'>{escape(cell.text)}</td>"
    if cell.value is None:
        wrap = " class='t'" if len(cell.text) > LONG else ""
        return f"<td{wrap}>{escape(cell.text)}</td>"
    return f"<td class='n' data-v='{cell.value:.17g}'>{escape(cell.text)}</td>"
