"""The written report: equal bytes, one set of numbers, safe text, and what its sentences say."""

import csv
import io
import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from page_report import demo_report

from analysis import Report, write_report
from analysis.report import report_sentences
from analysis.report.figures.energy import swept
from analysis.report.html import html_text
from analysis.report.markdown import markdown_text
from analysis.report.sections import plots, sections
from analysis.report.tables.cells import significant, with_U


@pytest.fixture(scope="module")
def report():
    return demo_report()


class Page(HTMLParser):
    """Collects tags, rows and anything that would be fetched."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.fetched, self.open = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        links = [value for name, value in attrs if name in ("src", "href", "xlink:href", "data")]
        self.fetched += [link for link in links if not link.startswith(("#", "data:,"))]
        if tag not in ("meta", "br", "use", "path"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag in self.open:
            while self.open.pop() != tag:
                pass


def test_equal_reports_give_equal_bytes(report, tmp_path):
    first, second = (
        write_report(report, tmp_path / "a"),
        write_report(Report.of(json.loads(json.dumps(report.document()))), tmp_path / "b"),
    )
    names = [path.relative_to(tmp_path / "a").as_posix() for path in first]
    assert names == [
        "report.csv",
        "report.md",
        "report.html",
        *(
            f"figures/{name}.svg"
            for name in (
                "energy",
                "energy_log",
                "energy_fill",
                "offset",
                "nulls",
                "waveforms",
                "repeats",
                "bland_altman",
            )
        ),
        "report.json",
    ]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_nothing_but_the_report_is_in_the_files(report, tmp_path):
    for path in write_report(report, tmp_path):
        text = path.read_text(encoding="utf-8")
        assert str(tmp_path) not in text
        assert not re.search(r"20\d\d-\d\d-\d\d", text)


def test_json_is_read_back_exactly(report, tmp_path):
    path = write_report(report, tmp_path, figures=False)[-1]
    assert json.loads(path.read_text(encoding="utf-8")) == report.document()


def test_csv_has_a_line_per_condition_with_the_same_numbers(report, tmp_path):
    path = write_report(report, tmp_path, figures=False)[0]
    rows = list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8"))))
    assert len(rows) == len(report.conditions)
    for row, found in zip(rows, report.conditions, strict=True):
        assert float(row["W_exp"]) == found.W_exp
        assert (row["offset"] == "") == (found.offset is None)
        assert int(row["runs"]) == 4


def test_page_is_self_contained_and_well_formed(report):
    page = Page(html_text(report))
    assert page.fetched == []
    assert page.open == []
    assert page.tags.count("svg") == sum(len(plot.panels) for plot in plots(report))
    ids = re.findall(r'\sid="([^"]+)"', html_text(report))
    assert len(ids) == len(set(ids))


def test_text_of_a_session_cannot_become_markup(report):
    evil = replace(
        report,
        protocol="<script>alert(1)</script>",
        question="</p><img src=x onerror=alert(1)>",
        conditions=(replace(report.conditions[0], id="<i>c</i>", bed="'\"><b>"),),
    )
    text = html_text(evil)
    assert text.count("<script>") == 1
    assert "<img" not in text
    assert "<i>" not in text
    assert "<b>" not in text
    marked = markdown_text(evil)
    assert not re.search(r"(?<!\\)<", marked)


def test_markdown_tables_keep_their_columns(report):
    lines = [line for line in markdown_text(report).splitlines() if line.startswith("|")]
    for table in (table for section in sections(report) for table in section.tables):
        head = "| " + " | ".join(table.head) + " |"
        start = lines.index(head)
        for line in lines[start : start + 2 + len(table.rows)]:
            assert len(re.findall(r"(?<!\\)\|", line)) == len(table.head) + 1


def test_first_sentence_and_headline(report):
    assert report_sentences.tested(report) == (
        "This run checks the measurement chain, not the damper model: the bed layers and the prediction W_T share one "
        "mechanism."
    )
    assert "ideal waveform is assumed" in report_sentences.waveform(report)
    assert "synthetic" in report_sentences.waveform(report)
    found = report.agreement
    assert report_sentences.headline(report).startswith("W_exp exceeds W_T by")
    percent = float(
        re.search(r"by ([\d.]+) % ± ([\d.]+) %", report_sentences.headline(report)).group(1)
    )
    assert percent == pytest.approx(100 * (found.ratio - 1), abs=100 * found.U_ratio / 10)
    less = replace(report, agreement=replace(found, ratio=0.9))
    assert "falls short of" in report_sentences.headline(less)
    model = replace(report, tests="model", synthetic=False, waveform="measured")
    assert "tests the damper model" in report_sentences.tested(model)
    assert report_sentences.waveform(model) == "The signals were measured."


@pytest.mark.parametrize(
    ("value", "U", "shown"),
    [
        (0.123456, 0.0123, "0.123 ± 0.012"),
        (12.345, 3.21, "12.3 ± 3.2"),
        (1234.5, 120.0, "1234 ± 120"),
        (-0.5, 0.25, "-0.50 ± 0.25"),
        (0.0, 1e-17, "0 ± 1e-17"),
        (1.23456, 0.0, "1.235"),
        (None, 1.0, "–"),
    ],
)
def test_value_and_uncertainty_share_their_last_place(value, U, shown):
    assert with_U(value, U).text == shown


@pytest.mark.parametrize(
    ("value", "digits", "shown"),
    [
        (187.3, 2, "190"),
        (0.99996, 2, "1.0"),
        (0.00512, 2, "0.0051"),
        (-3.0, 3, "-3.00"),
        (1e-9, 2, "1e-09"),
        (0, 3, "0"),
    ],
)
def test_significant_digits_without_needless_exponents(value, digits, shown):
    assert significant(value, digits) == shown


def test_figures_are_drawings_with_words(report):
    for plot in plots(report):
        root = ET.fromstring(plot.svg)
        assert root.tag.endswith("svg")
        assert len(plot.alt) > 60
    texts = " ".join(ET.fromstring(plots(report)[0].svg).itertext())
    for word in ("acceleration, m/s²", "W, mJ per cycle", "W_T predicted", "50 %"):
        assert word in texts


@pytest.mark.parametrize("name", ["fill", "density", "diameter", "acceleration_set"])
def test_the_axis_is_what_varies(report, name):
    base = report.conditions[0]
    rows = tuple(replace(base, **{name: value}) for value in (1.0, 2.0))
    assert swept(rows) == name
    assert plots(replace(report, conditions=rows))


def test_beds_compared_at_several_levels_are_told_apart(report):
    rows = tuple(
        replace(report.conditions[0], fill=0.85, bed=bed, acceleration_set=a)
        for bed in ("empty", "locked", "dashpot")
        for a in (2.0, 3.0)
    )
    texts = " ".join(ET.fromstring(plots(replace(report, conditions=rows))[0].svg).itertext())
    for bed in ("empty", "locked", "dashpot"):
        assert bed in texts


def test_a_report_without_conditions_is_still_a_report(report, tmp_path):
    none = replace(report.agreement, ratio=None, slope=None, mean_offset=None)
    bare = replace(report, conditions=(), nulls=(), waveforms=None, agreement=none)
    paths = write_report(bare, tmp_path)
    assert len(paths) == 4
    assert "no predicted energy" in paths[2].read_text(encoding="utf-8")
