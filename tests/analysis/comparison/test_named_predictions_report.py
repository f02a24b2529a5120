"""The report of a session whose prediction has a name: a band, predictions beside W_T, reasons."""

import numpy as np
import pytest
from analytic_record import Bench, condition, dashpot_energy, prediction_for, session

from analysis import read_session
from analysis.report import report_sentences
from analysis.report.markdown import markdown_text
from analysis.results.report import Report
from analysis.session.prediction_entry import entries_of
from analysis.session.record import AnalysisError

LEVELS = (2.0, 3.0, 4.0)


def made(change, excess=1.07):
    """Three levels of a bed that takes 7 % more than W_T; change(number, entry) edits an entry."""
    table = [condition(f"c{i}", acceleration_set=a, record_cycles=4) for i, a in enumerate(LEVELS)]
    prediction = prediction_for(table, lambda _entry, a: dashpot_energy(200.0, a))
    for number, entry in enumerate(prediction["conditions"].values()):
        change(number, entry)
    bench, rng = Bench(repeats=2, samples=16 * 512), np.random.default_rng(2)
    return read_session(
        session(table, lambda *_: 200.0 * excess, bench, rng, prediction=prediction)
    )


def banded(edges):
    """Every W_T replaced by a band from 0 to so many times it."""

    def change(number, entry):
        W = entry.pop("W_T")
        del entry["W_f"], entry["W_c"]
        entry |= {
            "W_T": None, "prediction": "band", "shares_mechanism": False,
            "W_T_low": [0.0] * len(W), "W_T_high": [edges[number] * w for w in W],
        }  # fmt: skip

    return change


def test_a_band_is_inside_or_outside_and_gives_no_ratio():
    """Bands up to 2, 1.06 and 1.08 of W_T, W_exp at 1.07: the second does not hold it."""
    report = made(banded((2.0, 1.06, 1.08)))
    rows = report.conditions
    assert [row.inside for row in rows] == [True, False, True]
    assert all((row.W_T, row.offset, row.E_n, row.U_W_T) == (None,) * 4 for row in rows)
    assert rows[0].W_T_low == 0.0
    assert rows[0].W_T_high / rows[1].W_T_high == pytest.approx(2.0 / 1.06 * (2 / 3) ** 2, rel=1e-3)
    found = report.agreement
    assert (found.ratio, found.slope, found.bands, found.inside) == (None, None, 3, 2)
    assert (report.prediction, report.tests) == ("band", "model")
    assert "inside the band of W_T in 2 of 3 conditions" in report_sentences.headline(report)
    compared = {row.comparison: (row.n, row.within) for row in report.comparisons}
    assert compared["prediction"] == (3, 2)
    assert report.passes  # a band outside of which W_exp lies is a finding
    assert Report.of(report.document()) == report
    assert "(outside)" in markdown_text(report)


def test_predictions_beside_W_T_have_their_own_uncertainty_and_reasons():
    """A variant of half of W_T known to 10 %, and one that is not stated."""

    def change(_number, entry):
        half = [0.5 * w for w in entry["W_T"]]
        entry |= {
            "prediction": "layers",
            "variants": {
                "layers": {"W_T": entry["W_T"], "u_rel": 1e-3},
                "column": {"W_T": None, "why": "the level lies outside 0.5 to 2 g"},
                "as_printed": {"W_T": half, "u_stated": 0.1},
            },
        }

    report = made(change)
    for row in report.conditions:
        assert row.W_T_as_printed == pytest.approx(0.5 * row.W_T, rel=1e-12)
        # Nothing but the stated 10 % and the level (1e-3 or less): k is that of a normal, 1.96.
        assert row.U_W_T_as_printed == pytest.approx(1.96 * 0.1 * row.W_T_as_printed, rel=1e-2)
        assert (row.W_T_layers, row.U_W_T_layers) == (row.W_T, row.U_W_T)  # one number, one U
        assert (row.W_T_column, row.U_W_T_column) == (None, None)
        assert row.reasons == {"W_T_column": "the level lies outside 0.5 to 2 g"}
    assert report.prediction == "layers"
    assert "the level lies outside" in markdown_text(report)
    assert "W\\_T (layers)" in markdown_text(report) or "W_T (layers)" in report_sentences.tested(
        report
    )
    assert Report.of(report.document()) == report


def test_a_stated_uncertainty_is_part_of_U_and_common_to_all_conditions():
    """10 % of W_T in each: the offset of every condition and of their sum is known to 10 %."""
    report = made(lambda _number, entry: entry.update(u_stated=0.1, shares_mechanism=False))
    row = report.conditions[0]
    assert pytest.approx(1.96 * 0.1 * row.W_T, rel=1e-2) == row.U_W_T
    sources = {line.source: line.share for line in row.uncertainty_W_T}
    assert sources["prediction as stated"] > 0.99
    assert report.agreement.U_ratio == pytest.approx(1.96 * 0.1 * report.agreement.ratio, rel=1e-2)


def test_an_older_prediction_has_no_name_and_keeps_its_one_number():
    report = made(lambda _number, _entry: None)
    assert report.prediction is None
    row = report.conditions[0]
    assert row.W_T_as_printed == pytest.approx(2 * row.W_T, rel=1e-3)
    assert (row.U_W_T_as_printed, row.W_T_layers, row.inside) == (None, None, None)


@pytest.mark.parametrize(
    "change",
    [
        lambda entry: entry.update(prediction="guess"),
        lambda entry: entry.update(W_T_low=[0.0], W_T_high=[1.0]),
        lambda entry: entry.update(variants={"column": {"W_T": [1.0]}}),
        lambda entry: entry.update(variants={"column": {}}),
        lambda entry: entry.pop("W_T"),
    ],
)
def test_a_document_that_is_none_is_refused(change):
    document = prediction_for([condition("c0")], lambda _entry, a: a)
    assert entries_of(document)
    change(document["conditions"]["c0"])
    with pytest.raises(AnalysisError):
        entries_of(document)
