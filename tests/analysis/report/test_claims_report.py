"""Claims in the report: judged from the record's own document, never part of the verdict, safe in
every form.
"""

import json

import numpy as np
import pytest
from analytic_record import NOMINAL, Bench, condition, dashpot_energy, prediction_for, session
from claim_data import entry

from analysis import read_session, write_report

WORDS = "W <b>rises</b> | greatly"


@pytest.fixture(scope="module")
def report():
    table = [
        condition(f"1{v}", fill=v / 4, acceleration_set=5.0, settle_cycles=1, record_cycles=4)
        for v in (1, 2, 3)
    ]
    claims = [
        {**entry("rise", ["1", "3"], levels="123"), "claim": WORDS},
        {**entry("fall", ["1", "3"], levels="123"), "claim": "the opposite"},
        entry(
            "offset_within", limits=[0.055, 0.085], levels="123", imposed="losses were set to it"
        ),
    ]
    documents = {
        "prediction": prediction_for(table, lambda e, a: dashpot_energy(300 * e["fill"], a)),
        "protocol": {"name": "demo", "expect": claims},
    }
    bench = Bench(channels=dict(NOMINAL), noise=(0.02, 5e-4), samples=6 * 512)

    def loss(e, repeat):
        return 300 * e["fill"] * (1.07 + 0.01 * (repeat - 1.5))

    return read_session(session(table, loss, bench, np.random.default_rng(1), **documents))


def test_claims_are_judged_from_the_record(report):
    assert [claim.verdict for claim in report.claims] == ["holds", "does not hold", "imposed"]
    assert report.claims[0].found == "1 < 2 < 3"
    assert {"claim", "found", "verdict", "why"} <= set(report.document()["claims"][0])


def test_a_claim_that_fails_fails_nothing(report):
    assert report.verdict == "passes"


def test_every_form_shows_them_as_text(report, tmp_path):
    write_report(report, tmp_path, figures=False)
    page, text = (tmp_path / "report.html").read_text(), (tmp_path / "report.md").read_text()
    assert "<b>rises" not in page
    assert "&lt;b&gt;rises&lt;/b&gt; | greatly" in page
    (row,) = (line for line in text.splitlines() if "greatly" in line)
    assert row.replace("\\|", "").count("|") == 8
    assert "1 \\< 2 \\< 3" in row
    assert (
        json.loads((tmp_path / "report.json").read_text())["claims"] == report.document()["claims"]
    )
