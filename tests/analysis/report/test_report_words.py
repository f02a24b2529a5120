"""What the report says in special cases: nothing put in, no line, single things, many alike, losses
switched off.
"""

from dataclasses import replace
from types import SimpleNamespace

import pytest
from bare_rows import bare
from claim_data import entry, judged, result
from page_report import demo_report

from analysis.comparison.family_of_tests import Reference
from analysis.comparison.null_tests import NullTest
from analysis.comparison.pooled_results import Fit
from analysis.comparison.verdict import verdict
from analysis.report import report_sentences
from analysis.report.figures.energy import energy_plots
from analysis.report.loss_names import loss_name, losses_sentence
from analysis.report.tables.offset_tables import LOSSES, causes
from analysis.report.tables.report_tables import conditions
from analysis.results.judged_rows import ClaimRow
from analysis.results.session_rows import CauseRow, Growth, Span
from analysis.text import counted
from analysis.uncertainty.estimate import Estimate


@pytest.fixture
def report():
    return demo_report()


def with_agreement(report, **changes):
    """The report with other numbers of the agreement."""
    return replace(report, agreement=replace(report.agreement, **changes))


def test_nothing_put_in_is_no_percentage(report):
    report = with_agreement(report, put_in=0.0)
    assert "puts in nothing" in report_sentences.headline(report)
    assert "0 %" not in report_sentences.headline(report).split(";")[1]


def test_no_slope_where_no_line_fits(report):
    """chi^2 of 10 has p = 0.44 at 10 degrees of freedom, of 40 p = 2e-5 (tables)."""
    one = Estimate.of(1.0, [(0.05, 50.0)])
    for chi2, told in (
        (10.0, "Slope through the origin 0.957"),
        (40.0, "No straight line describes"),
    ):
        fit = Fit(one, one, chi2, 10)
        stated = (
            {"slope": 0.957, "U_slope": 0.005}
            if fit.is_likely
            else {"slope": None, "U_slope": None}
        )
        found = with_agreement(report, **stated, line=fit.row())
        assert fit.is_likely == (fit.row().slope is not None) == (chi2 == 10.0)
        assert any(told in text for text in report_sentences.found(found))


def test_without_a_prediction_the_energies_are_said(report):
    rows = tuple(replace(row, W_T=None) for row in report.conditions)
    report = replace(with_agreement(report, ratio=None), conditions=rows)
    assert "nothing is predicted" in report_sentences.tested(report)
    assert f"mJ per cycle in {len(rows)} conditions" in report_sentences.headline(report)
    told = report_sentences.headline(replace(report, conditions=rows[:1]))
    assert f"W_exp in mJ per cycle: {rows[0].id} {1e3 * rows[0].W_exp:.0f}"[:-1] in told


def test_counted():
    assert [counted(n, "run") for n in (0, 1, 2)] == ["0 runs", "1 run", "2 runs"]


def test_claims_that_are_not_there_are_not_counted(report):
    claim = ClaimRow("", "", "", "holds", "", (), ())
    both = replace(report, claims=(claim, replace(claim, verdict="undecided")))
    assert "Of 2 claims 1 holds, 1 is undecided." in report_sentences.found(both)
    assert "The only claim: holds." in report_sentences.found(replace(report, claims=(claim,)))


def test_losses_that_are_switched_off_are_no_causes(report):
    row = CauseRow(
        "scale",
        "",
        "",
        True,
        Growth(None, None, None),
        430.0,
        430.0,
        "computed",
        430.0,
        "computed",
        None,
        "",
    )
    losses = [replace(row, cause=name, in_run=False) for name in LOSSES]
    table = causes(replace(report, causes=(*losses, row)))
    assert [cells[0].text for cells in table.rows] == ["scale"]
    assert "switched off" in table.note
    table = causes(replace(report, causes=(replace(losses[0], in_run=True), *losses[1:], row)))
    assert len(table.rows) == len(LOSSES) + 1
    assert [cells[3].text[0] == "(" for cells in table.rows] == [
        False,
        *[True] * (len(LOSSES) - 1),
        False,
    ]


def test_what_else_was_varied_is_a_column_and_an_axis(report):
    rows = tuple(
        replace(row, varied={"gap": gap}, acceleration_set=5.0, fill=0.2, bed="single_mass")
        for row, gap in zip(report.conditions[:3], ("1 mm", "2 mm", "3 mm"), strict=True)
    )
    report = replace(report, conditions=rows)
    table = conditions(report)
    assert [cells[table.head.index("gap")].text for cells in table.rows] == ["1 mm", "2 mm", "3 mm"]
    (plot,) = energy_plots(report)
    assert all(f">{text}<" in plot.svg for text in ("gap", "1 mm", "2 mm", "3 mm"))


def test_many_checks_alike_are_one_sentence():
    """13 frequencies give 13 nulls and references: one sentence of each verdict, the narrowest
    named.
    """
    nulls = [NullTest("locked", 38.0, f, 1, None, "undecided", "only 1 level") for f in range(13)]
    masses = [
        Reference(
            "rigid mass", "empty box", "kg", 12.0 + 0.01 * n, 12.0, 0.2, "holds", f"number {n}"
        )
        for n in range(13)
    ]
    found = verdict(
        [SimpleNamespace(chain=None, runs=(), setting=None, beyond=False)], nulls, masses, None, []
    )
    told = [text for text in found.reasons if "null" in text or "reference" in text]
    assert told == [
        "The null test with the locked bed is undecided in 13 cases: only 1 level.",
        "The reference rigid mass (empty box) holds in 13 cases, most narrowly: number 12.",
    ]
    wrong = NullTest("locked", 38.0, 20.0, 3, Estimate(2.0, 0.1, 5.0), "does not hold", "too large")
    found = verdict(
        [SimpleNamespace(chain=None, runs=(), setting=None, beyond=False)],
        [*nulls, wrong],
        [],
        None,
        [],
    )
    assert found.failures == ("The null test with the locked bed does not hold: too large.",)


@pytest.mark.parametrize(
    ("W", "why"),
    [
        ({"1a": [1.0]}, "only one value was measured, a"),
        ({"1a": [1.0], "1b": [2.0]}, "no condition was repeated"),
        ({"1a": [1e-9, 2e-9], "1b": [1e-9, -1e-9]}, "no repeated condition exceeds"),
    ],
)
@pytest.mark.parametrize("kind", ["optimum", "rise"])
def test_why_nothing_can_be_compared(kind, W, why):
    results = {name: result(values, name=name) for name, values in W.items()}
    (claim,) = judged(
        [entry(kind, ("a", "b") if kind == "rise" else ("a",), levels=("a", "b"))], results
    )
    assert claim.verdict == "undecided"
    assert why in claim.why


def test_a_hidden_prediction_states_no_offset_and_names_the_losses(report):
    hidden = with_agreement(report, ratio=None, put_in=155.0)
    assert "so no offset is stated: the losses of the box" in report_sentences.headline(hidden)
    assert "155 times" in report_sentences.headline(hidden).replace("160", "155")
    less = with_agreement(report, ratio=None, put_in=0.3)
    assert report_sentences.headline(less).endswith("so no offset is stated.")
    recorded = with_agreement(less, ratio_recorded=13.5, U_ratio_recorded=0.4, put_in_recorded=12.3)
    assert any("the losses of the box" in text for text in report_sentences.found(recorded))


def test_the_papers_words_explain_no_loss_that_is_larger_than_they_can_be(report):
    """Named by its law, and unexplained unless its size is known and no larger than the word would
    make it.
    """

    def of(span):
        rows = [
            bare(CauseRow, cause=name, in_run=True, over_first_principles=span)
            for name in ("noise", "air", "gas")
        ]
        return replace(report, causes=tuple(rows))

    for span, word in (
        (Span(3.0, 40.0), "unexplained "),
        (Span(0.5, 1.0), ""),
        (None, "unexplained "),
    ):
        told = of(span)
        assert loss_name("noise", told) == f"{word}viscous loss (the paper's noise)"
        assert loss_name("air", told) == f"{word}quadratic loss (the paper's air)"
        assert loss_name("gas", told) == "gas"
        assert ("the paper's air" in losses_sentence(told)) == bool(word)
    assert "317 000 times the sound" in losses_sentence(of(Span(317307.3, 317307.3)))
