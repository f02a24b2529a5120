"""A number of report.json that stands in another form of the report too is the same there, to the
digits shown.
"""

import csv
import io
import re
from decimal import Decimal
from html.parser import HTMLParser
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from page_report import demo_report

from analysis.report.csv import csv_text
from analysis.report.html import html_text
from analysis.report.markdown import markdown_text
from analysis.results.condition_row import TERMS
from analysis.results.report import Report

Document = dict[str, Any]
SHOWN = {
    "Conditions": (
        "conditions",
        {
            "a, m/s²": ("acceleration", None, 1, None),
            "W_exp ± U, mJ": ("W_exp", "U_W_exp", 1e3, 4),
            "W_T ± U, mJ": ("W_T", "U_W_T", 1e3, 4),
            "offset, %": ("offset", "U_offset", 100, 4),
            "E_n": ("E_n", None, 1, None),
            "E_n truth": ("E_n_truth", None, 1, None),
            "detect, mJ": ("W_detect", None, 1e3, 2),
            "eta ± U": ("eta", "U_eta", 1, 4),
            "M_eff ± U, kg": ("M_eff", "U_M_eff", 1, 4),
            "THD box, %": ("thd_box", None, 100, 2),
            "bound, mJ": ("bound", None, 1e3, 3),
        },
    ),
    "Null tests": (
        "nulls",
        {
            "mass, kg": ("bed_mass", None, 1, 3),
            "f, Hz": ("frequency", None, 1, 6),
            "angle ± U, mrad": ("dphi", "U_dphi", 1e3, 4),
        },
    ),
    "References": (
        "references",
        {"found ± U": ("value", "U", 1, 4), "known": ("expected", None, 1, 5)},
    ),
}
"""By a table's title: the report's list, and of each column value, U, scale, and significant digits
(None: places).
"""
DASH = "–"
NUMBER = r"-?\d+(?:\.\d+)?(?:e[+-]\d+)?"


def same(text: str, value: float, digits: int | None) -> bool:
    """Whether a text shows a number to its last place, or where it has more digits than that
    counts, to `digits`.
    """
    exact, shown = Decimal(repr(float(value))), Decimal(text)
    place = shown.as_tuple().exponent
    assert isinstance(place, int)
    if digits is not None and exact:
        place = max(place, exact.adjusted() - digits + 1)
    # Half a unit of the place; twice rounded (to a float's nearest between), an ulp more.
    return abs(exact - shown) <= Decimal("0.5000001") * Decimal(1).scaleb(place) + abs(
        exact
    ) * Decimal("1e-14")


def agrees(
    cell: str, value: float | None, U: float | None, scale: float, digits: int | None
) -> bool:
    if value is None:
        return cell == DASH
    parts = cell.split(" ± ")
    if len(parts) == 1:
        return same(cell, value * scale, digits)
    U_digits = 2 if "e" in parts[0] or "e" in parts[1] else None
    return U is not None and same(parts[0], value * scale, 3 if U_digits else None) and same(
        parts[1], U * scale, U_digits
    )  # fmt: skip


class Tables(HTMLParser):
    """The tables of a page by title: head, and rows of (text, number to sort by)."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: dict[str, tuple[list[str], list[list[tuple[str, str | None]]]]] = {}
        self._rows: list[list[tuple[str, str | None]]] = []
        self._head: list[str] = []
        self._text: list[str] | None = None
        self._value: str | None = None
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        named = dict(attrs)
        if tag == "div" and named.get("role") == "region":
            self._head, self._rows = [], []
            self.found[str(named["aria-label"])] = (self._head, self._rows)
        elif tag == "tr":
            self._rows.append([])
        elif tag in ("td", "th"):
            self._text, self._value = [], named.get("data-v")

    def handle_data(self, data: str) -> None:
        if self._text is not None:
            self._text.append(data)

    def handle_endtag(self, tag: str) -> None:
        if tag in ("td", "th") and self._text is not None:
            text = "".join(self._text)
            if tag == "th":
                self._head.append(text)
            else:
                self._rows[-1].append((text, self._value))
            self._text = None


def of_page(text: str) -> dict[str, tuple[list[str], list[list[tuple[str, str | None]]]]]:
    """Tables by title, without the row of heads."""
    return {title: (head, rows[1:]) for title, (head, rows) in Tables(text).found.items()}


def of_markdown(text: str) -> dict[str, tuple[list[str], list[list[str]]]]:
    found = {}
    for part in re.split(r"^### ", text, flags=re.MULTILINE)[1:]:
        lines = [line for line in part.splitlines() if line.startswith("| ")]
        cells = [
            [re.sub(r"\\(.)", r"\1", c.strip()) for c in re.split(r"(?<!\\)\|", line)[1:-1]]
            for line in lines
        ]
        found[part.splitlines()[0]] = (cells[0], cells[1:])
    return found


def check(report: Document) -> None:
    """What every form of a report.json shows is what it holds."""
    typed = Report.of(report)
    check_csv(report, csv_text(typed))
    page, marked = html_text(typed), markdown_text(typed)
    check_tables(report, of_page(page), of_markdown(marked))
    check_sentences(report, re.sub(r"\\(.)", r"\1", marked))


def check_csv(report: Document, text: str) -> None:
    rows = list(csv.DictReader(io.StringIO(text)))
    assert len(rows) == len(report["conditions"])
    for row, known in zip(rows, report["conditions"], strict=True):
        terms = known["offset_terms"] or dict.fromkeys(TERMS)
        told = {
            **known,
            "runs": len(known["runs"]),
            **{f"offset_{name}": value for name, value in terms.items()},
        }
        for name, shown in row.items():
            assert shown == ("" if told[name] is None else str(told[name])), (known["id"], name)


def check_tables(report: Document, page: dict[str, Any], marked: dict[str, Any]) -> None:
    for title, (head, rows) in page.items():  # both have the same tables, cell by cell
        shown = [[" ".join(text.split()) for text, _ in row] for row in rows]
        assert (head, shown) == marked[title], title
    for title, (name, columns) in SHOWN.items():
        if title not in page:
            assert not report[name]
            continue
        head, rows = page[title]
        for row, known in zip(rows, report[name], strict=True):
            for column, (value, U, scale, digits) in columns.items():
                text, sorted_by = row[head.index(column)]
                number = known[value]
                of_U = known[U] if U else None
                assert agrees(text, number, of_U, scale, digits), (
                    title,
                    column,
                    text,
                    number,
                    of_U,
                )
                assert sorted_by is None if number is None else float(sorted_by) == number * scale


def check_sentences(report: Document, text: str) -> None:
    """The sentences of the verdict are the same in the page (test_report_pages); their numbers are
    the report's.
    """
    found, conditions = report["agreement"], report["conditions"]
    ratio = re.search(
        rf"W_T by ({NUMBER}) % ± ({NUMBER}) % \(k = ({NUMBER}), nu = ({NUMBER}|∞)\)", text
    )
    assert (ratio is None) == (found["ratio"] is None)
    if ratio is not None:
        assert agrees(
            f"{ratio[1]} ± {ratio[2]}", abs(found["ratio"] - 1), found["U_ratio"], 100, None
        )
        assert same(ratio[3], found["k"], None)
        assert ratio[4] == "∞" if found["nu"] is None else same(ratio[4], found["nu"], None)
    slope = re.search(rf"Slope through the origin ({NUMBER} ± {NUMBER})\.", text)
    assert (slope is None) == (found["slope"] is None) == (found["U_slope"] is None)
    if slope is not None:
        assert agrees(slope[1], found["slope"], found["U_slope"], 1, None)
    none = re.search(rf"No straight line describes .*\(chi² ({NUMBER}), (\d+) degrees", text)
    if none is not None:
        assert found["slope"] is None
        assert same(none[1], found["line"]["chi2"], None)
        assert int(none[2]) == found["line"]["dof"]
    mean = re.search(rf"mean offset of the (\d+) conditions .*?is ({NUMBER}) %", text)
    offsets = [row["offset"] for row in conditions if row["offset"] is not None]
    if mean is not None:
        assert int(mean[1]) == len(offsets)
        assert same(mean[2], 100 * found["mean_offset"], 2)
    assert f"## Verdict: {report['verdict'].capitalize()}" in text
    chain = re.search(r"own ledger in (\d+) of (\d+) conditions", text)
    assert (chain is None) == (report["chain"]["share"] is None)
    if chain is not None:
        assert int(chain[1]) / int(chain[2]) == report["chain"]["share"]


DEMO = demo_report().document()
SIZE = st.floats(1e-12, 1e5)
EITHER = st.tuples(st.sampled_from([1.0, -1.0]), SIZE).map(
    lambda both: both[0] * both[1]
) | st.just(0.0)
ROW = st.fixed_dictionaries(
    {
        "W_exp": EITHER,
        "U_W_exp": SIZE,
        "acceleration": SIZE,
        "W_detect": SIZE,
        "eta": st.none() | EITHER,
        "U_eta": SIZE,
        "M_eff": st.none() | EITHER,
        "U_M_eff": SIZE,
        "thd_box": st.none() | SIZE,
        "bound": st.none() | SIZE,
        "E_n": st.none() | EITHER,
        "E_n_truth": st.none() | EITHER,
    },
)
LINE = st.fixed_dictionaries({"chi2": SIZE, "dof": st.integers(1, 100)})
AGREEMENT = st.fixed_dictionaries(
    {
        "ratio": st.floats(0.1, 10),
        "U_ratio": st.floats(1e-4, 1),
        "k": st.floats(1.96, 13),
        "nu": st.none() | SIZE,
    },
)
SLOPE = st.fixed_dictionaries(
    {"slope": st.floats(0.1, 10), "U_slope": st.floats(1e-4, 1)}
) | st.just({"slope": None, "U_slope": None})


def test_the_forms_of_a_report_agree() -> None:
    check(DEMO)


@given(rows=st.lists(ROW, min_size=1, max_size=3), found=AGREEMENT, slope=SLOPE, line=LINE)
def test_whatever_the_numbers(
    rows: list[Document], found: Document, slope: Document, line: Document
) -> None:
    conditions = [{**known, **row} for known, row in zip(DEMO["conditions"], rows, strict=False)]
    agreement = {
        **DEMO["agreement"],
        **found,
        **slope,
        "line": {**DEMO["agreement"]["line"], **line},
    }
    check({**DEMO, "conditions": conditions, "agreement": agreement})


@pytest.mark.parametrize(
    ("shown", "value", "good"), [("190", 187.3, True), ("190", 184.9, False), ("1.2", 1.26, False)]
)
def test_what_counts_as_the_same_number(shown: str, value: float, good: bool) -> None:
    assert same(shown, value, 2) == good
