"""Two sessions compared: what is matched, what is significant, what common errors do; scipy's tau
as a witness.
"""

import copy
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from bare_rows import bare
from scipy.stats import kendalltau

from analysis.comparison.two_sessions import compare, kendall
from analysis.report.two_sessions import comparison_sentences, write_comparison
from analysis.results.comparison_rows import Comparison
from analysis.results.condition_row import ConditionRow, RunRow, SourceRow
from analysis.results.report import Report
from analysis.results.session_rows import AgreementRow


def row(name, W, *, bed="layers", fill=0.5, a=3.0, scatter=0.01, common=0.02, runs=4):
    lines = (
        SourceRow("scatter between runs", "J", scatter * abs(W), 1.0, None, 0.5),
        SourceRow("force sensitivity", "1", common, W, None, 0.5),
    )
    return bare(
        ConditionRow,
        id=name,
        material="stainless",
        density=7900.0,
        diameter=4e-3,
        fill=fill,
        bed=bed,
        drive="prescribed",
        frequency=20.0,
        acceleration_set=a,
        acceleration=a,
        exponent=2.5,
        W_exp=W,
        U_W_exp=1.96 * abs(W) * math.hypot(scatter, common),
        W_detect=1e-6,
        uncertainty=lines,
        runs=(bare(RunRow),) * runs,
    )


def report(rows, name="one"):
    return bare(
        Report,
        protocol=name,
        synthetic=True,
        verdict="passes",
        conditions=tuple(rows),
        agreement=bare(AgreementRow),
    )


LEVELS = [(fill, a) for fill in (0.3, 0.5, 0.9) for a in (2.0, 3.0, 4.0, 5.0)]


def session(factor=1.0, name="one", **more):
    rows = [
        row(f"c{i}", factor * fill * a**2.5, fill=fill, a=a, **more)
        for i, (fill, a) in enumerate(LEVELS)
    ]
    return report(rows, name)


def test_a_session_agrees_with_itself_whatever_its_instruments_do():
    found = compare(session(), session(), same_instruments=True)
    assert found.alone == ()
    assert [(pair.A, pair.B) for pair in found.pairs] == [(f"c{i}", f"c{i}") for i in range(12)]
    assert found.overall.relative == 0
    assert not any(pair.significant for pair in found.pairs)
    assert found.ranks.tau == 1
    assert found.ranks.opposite == 0


@pytest.mark.parametrize("same", [True, False])
def test_common_errors_cancel_only_where_the_instruments_are_the_same(same):
    """ln W_B/W_A: sqrt(2) of the scatter 1 %, and sqrt(2) of the sensitivity 2 % where there are
    two of them.
    """
    found = compare(session(), session(1.05, "two"), same_instruments=same)
    u = math.hypot(0.01, 0 if same else 0.02) * math.sqrt(2)
    for pair in found.pairs:
        assert pair.relative == pytest.approx(0.05)
        # the common part of a ratio cancels to the last bit; of B's scatter 1.05 times A's is left
        # in B/A - 1
        assert pair.U_relative == pytest.approx(1.96 * 1.05 * u, rel=1e-3)
        assert pair.significant == (same)  # 0.05 is 3.4 u, and 1.5 u
    assert found.same_instruments == same


@pytest.mark.parametrize("runs", [1, 4])
def test_a_single_run_may_differ_by_its_refill(runs, tmp_path):
    """Its U lacks the scatter between refills: said beside what is significant, and nowhere else."""
    found = compare(session(), session(1.5, "two", runs=runs), same_instruments=True)
    assert all(pair.significant and pair.runs_B == runs for pair in found.pairs)
    write_comparison(found, tmp_path)
    text = (tmp_path / "comparison.md").read_text(encoding="utf-8")
    assert "12 of 12 conditions differ significantly" in text
    assert ("Of these 12 with a single run" in text) == (runs == 1)


def test_false_alarms_are_as_rare_as_stated():
    """Two sessions of the same truth: any of the 12 `significant` in at most 5 % (Holm), within 4
    binomial sigma.
    """
    rng, alarms, tries = np.random.default_rng(7), 0, 400
    for _ in range(tries):
        one, two = session(), session()
        made = []
        for each in (one, two):
            scale = 1 + 0.02 * rng.standard_normal()
            factors = [scale * (1 + 0.01 * rng.standard_normal()) for _ in each.conditions]
            made.append(
                report(
                    [
                        replace(c, W_exp=c.W_exp * f)
                        for c, f in zip(each.conditions, factors, strict=True)
                    ]
                )
            )
        alarms += any(pair.significant for pair in compare(*made).pairs)
    assert alarms / tries <= 0.05 + 4 * math.sqrt(0.05 * 0.95 / tries)


def test_settings_match_and_not_names():
    one, two = session(), session()
    first, second, *rest = [
        replace(each, id=f"x{i}") for i, each in enumerate(reversed(two.conditions))
    ]
    changed = [replace(first, fill=0.123), replace(second, acceleration=1.2 * second.acceleration)]
    found = compare(one, report([*changed, *rest]))
    assert len(found.pairs) == 10
    whys = {entry.id: entry.why for entry in found.alone}
    assert "no condition of B" in whys["c11"]
    assert "18 % apart" in whys["c10"]  # ln 1.2
    assert whys.keys() == {"c10", "c11", "x0", "x1"}


def imported(each, level=1.005, **more):
    """The same condition as an import has it: the level that was measured as the level that was
    set.
    """
    a = each.acceleration * level
    changes = {"acceleration_set": 1.01 * a, "acceleration": a, "frequency": 19.9993, **more}
    return replace(each, id=f"lab_{each.id}", drive="measured", **changes)


def paired(found):
    return [(pair.A, pair.B) for pair in found.pairs]


def test_levels_that_were_measured_match_within_5_percent():
    one = session()
    lab = report([imported(each) for each in one.conditions], "lab")
    names = [(f"c{i}", f"lab_c{i}") for i in range(12)]
    assert paired(compare(one, lab)) == names
    assert paired(compare(lab, one)) == [(b, a) for a, b in names]
    later = report([imported(each, 0.98) for each in one.conditions], "later")
    assert [a for a, b in paired(compare(lab, later)) if a == b] == [
        each.id for each in lab.conditions
    ]
    far = compare(one, report([imported(each, 1.06) for each in one.conditions]))
    assert far.pairs == ()
    assert "5.8 % apart" in far.alone[0].why  # ln 1.06


def test_the_nearest_level_is_matched_and_none_twice():
    one = report([row("low", 1.0, a=2.0), row("high", 1.1, a=2.06)])
    assert paired(compare(one, report([row("b", 1.0, a=2.05)]))) == [("high", "b")]
    two = report([row("x", 1.0, a=2.05), row("y", 1.0, a=2.01)])
    assert paired(compare(one, two)) == [("low", "y"), ("high", "x")]
    # the level that was set goes before the nearest one reached
    drifted = report(
        [
            replace(row("x", 1.0, a=2.0), acceleration=2.05),
            replace(row("y", 1.0, a=2.06), acceleration=2.01),
        ]
    )
    assert paired(compare(one, drifted)) == [("low", "x"), ("high", "y")]


def test_levels_that_differ_widen_U_and_W_is_not_corrected():
    """A rectangle of half width n ln(a_B/a_A) W beside nothing else: U = 1.96 of it over sqrt(3)."""
    one, two = (report([row("a", 1.0, a=a, scatter=1e-9, common=1e-9)]) for a in (2.0, 2.04))
    (pair,) = compare(one, two).pairs
    assert pair.difference == 0
    assert pair.U_difference == pytest.approx(1.96 * 2.5 * math.log(1.02) / math.sqrt(3), rel=1e-3)


def test_what_differs_is_named_on_both_sides():
    found = compare(
        report([row("a", 1.0)]), report([row("b", 1.0, fill=0.6), row("c", 1.0, fill=0.7, a=9.0)])
    )
    whys = {entry.id: entry.why for entry in found.alone}
    assert "nearest is b: fill 0.5 against 0.6" in whys["a"]
    assert "fill 0.7 against 0.5, acceleration_set 9 against 3" in whys["c"]
    assert "fill 0.5 against 0.6" in comparison_sentences(found)[1]


def test_what_one_side_does_not_know_is_listed_and_never_guessed():
    one = session()
    bare = {"material": "not stated", "density": None, "diameter": None}
    found = compare(one, report([imported(each, **bare) for each in one.conditions]))
    assert len(found.pairs) == 12
    assert found.pairs[0].not_compared == ("material", "density", "diameter")
    assert found.pairs[0].material == "stainless"
    assert "does not know it: material, density, diameter." in comparison_sentences(found)[-1]
    # three fills at one level: without the fill they are ambiguous, however near a level is
    found = compare(one, report([imported(each, fill=None) for each in one.conditions]))
    assert found.pairs == ()
    assert "ambiguous" in found.alone[0].why


def test_sessions_have_names_and_words():
    empty = report([])
    told = comparison_sentences(
        compare(empty, report([row("b", 1.0)]), folders=("monday", "friday"))
    )
    assert "A is one (monday) (simulated, no usable condition, passes)." in told[0]
    assert (
        "B is one (friday) (simulated, bed layers, drive prescribed, 1 condition, passes)."
        in told[0]
    )
    other = compare(empty, report([], "two"), folders=("monday", "friday"))
    assert [each.name for each in other.sessions] == ["one", "two"]


def test_the_same_bed_goes_first_and_what_is_ambiguous_is_left_out():
    beds = report([row(f"a{bed}", 1.0, bed=bed) for bed in ("empty", "locked", "layers")])
    found = compare(beds, report([row("b", 2.0)]))
    assert [(pair.A, pair.B) for pair in found.pairs] == [("alayers", "b")]
    assert compare(beds, report([row("b", 2.0, bed="grains")])).pairs == ()
    alone = compare(report([row("a", 1.0)]), report([row("b", 2.0, bed="grains")]))
    assert alone.pairs[0].bed_B == "grains"


def test_what_is_not_known_is_no_difference():
    measured = report(
        [replace(row("m", 1.0), density=None, diameter=None, bed="unknown", exponent=None)]
    )
    assert len(compare(measured, report([row("b", 1.0)])).pairs) == 1


def test_below_detection_no_percentage_is_given():
    found = compare(report([replace(row("a", 1e-9), W_detect=1e-6)]), report([row("b", 1.0)]))
    assert found.pairs[0].relative is None
    assert found.pairs[0].difference == pytest.approx(1.0)


def test_tau_is_scipys():
    rng = np.random.default_rng(3)
    for _ in range(20):
        x, y = rng.integers(0, 6, 15).tolist(), rng.integers(0, 6, 15).tolist()
        assert kendall(x, y) == pytest.approx(kendalltau(x, y).statistic, abs=1e-12)
    assert kendall([1, 1], [1, 2]) is None


def test_orders_that_both_decide_differently_are_named():
    one = report([row("a", 1.0, fill=0.3), row("b", 2.0, fill=0.5)])
    two = report([row("a", 2.0, fill=0.3), row("b", 1.0, fill=0.5)])
    ranks = compare(one, two).ranks
    assert (ranks.tau, ranks.opposite, ranks.decided_opposite) == (-1, 1, ("a and b",))
    assert ranks.interval is None


def test_the_files_hold_the_same_numbers_in_equal_bytes(tmp_path):
    found = compare(session(), session(1.1, "two"))
    first = write_comparison(found, tmp_path / "a")
    second = write_comparison(copy.deepcopy(found), tmp_path / "b")
    assert [path.name for path in first] == [
        "comparison.csv", "comparison.md", "comparison.html", "comparison.svg", "comparison.json",
    ]  # fmt: skip
    assert all(x.read_bytes() == y.read_bytes() for x, y in zip(first, second, strict=True))
    assert json.loads(first[-1].read_text(encoding="utf-8")) == found.document()
    assert Comparison.of(found.document()) == found
    for sentence in comparison_sentences(found)[1:2]:
        assert "10.0 % ±" in sentence
        assert sentence in first[2].read_text(encoding="utf-8")


def test_nothing_in_common_is_said(tmp_path):
    found = compare(report([row("a", 1.0)]), report([row("b", 1.0, fill=0.6)]))
    assert found.overall is None
    write_comparison(found, tmp_path)
    assert "nothing can be compared" in (tmp_path / "comparison.md").read_text(encoding="utf-8")
