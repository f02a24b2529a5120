"""Text from strangers in the report's files, made without the stand: the same elements, whatever
the words are.
"""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from page_report import demo_report
from strange import Page, clean, hostile, markdown_shape, shape_of, svg_shape, swapped

from analysis.report.figures.drawing import Drawing, Plot, Word
from analysis.report.files import write_report
from analysis.report.html import page
from analysis.report.markdown import section_texts
from analysis.report.sections import Section
from analysis.report.tables.cells import Cell, Table
from analysis.results.report import Report, Resolved

FREE = (
    "demo",
    "Is 5 < 6 & true?",
    "stainless",
    "208C03",
    "352C33",
    "mu",
    "assumed",
    "<b>us</b> | me",
)


@pytest.fixture(scope="module")
def report() -> Report:
    return replace(demo_report(), resolved=Resolved("protocol"))


def told(report: Report, texts: list[str]) -> Report:
    """The report whose ids and free text are the texts."""
    ids = [row.id for row in report.conditions]
    swap = {
        text: f"{texts[n % len(texts)]}{n if text in ids else ''}"
        for n, text in enumerate([*ids, *FREE])
    }
    found = Report.of(swapped(report.document(), swap, ids))
    return replace(found, resolved=Resolved(f"a:\n\tb: {texts[0]}\n"))


def test_the_report_is_made_of_the_same_elements_whatever_its_words_are(
    report: Report, tmp_path: Path
) -> None:
    write_report(told(report, ["a", "b", "c"]), tmp_path)
    plain = shape_of(tmp_path)

    @settings(max_examples=6)
    @given(st.lists(hostile, min_size=3, max_size=9))
    def every(texts: list[str]) -> None:
        write_report(told(report, texts), tmp_path)
        assert shape_of(tmp_path) == plain

    every()


def section(text: str) -> Section:
    """A section with the text at every place that takes one."""
    drawing = Drawing(10, 10, (Word((0, 0), text),), text)
    table = Table(
        text, text, (text, "x"), ((Cell(text), Cell("-1", -1.0)), (Cell("x"), Cell(text)))
    )
    return Section(
        text, (text, f"{text} x"), (Plot("p", text, text, (drawing, drawing)),), (table, table)
    )


def shapes(text: str) -> tuple[Counter[str], ...]:
    """What a page, a text of Markdown and a drawing with the text are made of."""
    markdown = "\n\n".join(section_texts([section(text)]))
    html, svg = page(text, (), [section(text)]), section(text).plots[0].svg
    for made in (markdown, html, svg):
        clean(made)
    return markdown_shape(markdown), Page(html).tags, svg_shape(svg)


@given(hostile.filter(str.strip))
def test_a_text_is_text_at_every_place_of_a_section(text: str) -> None:
    assert shapes(text) == shapes("a")
