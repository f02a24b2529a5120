"""Claims: what each test finds where the truth is known, how often it is wrong, and the entry of
the report.
"""

import numpy as np
import pytest
from claim_data import entry, judged, result
from scipy import stats

from analysis.comparison.claim_tests import TESTS, Level, Question

S, N = 0.05, 4  # scatter of ln W between runs, runs of a condition


@pytest.fixture(params=[400, pytest.param(2000, marks=pytest.mark.slow)])
def trials(request):
    """How many cases are drawn."""
    return request.param


def most(trials):
    """A test at 5 % is wrong more often than this in 0.1 % of all seeds."""
    return int(stats.binom.ppf(0.999, trials, 0.05))


def runs(rng, ln_W, s=S, n=N):
    return np.exp(ln_W + s * rng.standard_normal(n))


def levels_of(rng, ln_Ws, s=S):
    return [Level(str(i), (result(runs(rng, ln_W, s)),)) for i, ln_W in enumerate(ln_Ws)]


def wrong(kind, question, draw, verdict, trials):
    """How many of the drawn cases get a verdict."""
    rng = np.random.default_rng(1)
    return sum(TESTS[kind](draw(rng), question).verdict == verdict for _ in range(trials))


def test_a_false_best_is_rare(trials):
    """Value 1 is claimed; value 2 is better by nothing that can be told: the worst case for a false
    `holds`.
    """
    for means in ((0, 1, 1.001), (0.9, 1, 1.001, 0.9, 1.001), (1, 1, 1.001, 1, 1, 1)):
        found = wrong(
            "optimum",
            Question(("1",), (), 1),
            lambda rng, m=means: levels_of(rng, m),
            "holds",
            trials,
        )
        assert found <= most(trials), means


def test_a_true_best_is_rarely_denied(trials):
    """Value 1 is best by a hair, in four cases: any of them may deny it, each at 5 % over their
    number.
    """
    question = Question(("1",), (), 4)
    rng = np.random.default_rng(2)
    denied = sum(
        any(
            TESTS["optimum"](levels_of(rng, (1, 1.001, 1, 0)), question).verdict == "does not hold"
            for _ in range(4)
        )
        for _ in range(trials // 2)
    )
    assert denied <= most(trials // 2)


@pytest.mark.parametrize(("kind", "sign"), [("order", 1), ("rise", 1), ("fall", -1)])
def test_a_false_order_is_rare(kind, sign, trials):
    """One step is flat, the others are clear; and where every step is flat, the opposite is rarely
    found either.
    """
    question = Question(("0", "3"), (), 1)
    steps = sign * np.array([0, 1, 1, 2.0])
    assert wrong(kind, question, lambda rng: levels_of(rng, steps), "holds", trials) <= most(trials)
    assert wrong(
        kind, question, lambda rng: levels_of(rng, [0, 0, 0, 0]), "does not hold", trials
    ) <= most(trials)


def power_law(rng, n):
    return [
        Level(str(a), (result(runs(rng, n * np.log(level)), level),))
        for a in (1, 2, 3, 4)
        if (level := a * (1 + 0.003 * rng.standard_normal(N))).any()
    ]


def test_a_false_nonlinearity_is_rare(trials):
    question = Question((), (0.1,), 1)
    assert wrong("nonlinear", question, lambda rng: power_law(rng, 2.1), "holds", trials) <= most(
        trials
    )
    assert wrong("nonlinear", question, lambda rng: power_law(rng, 1.9), "holds", trials) <= most(
        trials
    )
    assert wrong(
        "nonlinear", question, lambda rng: power_law(rng, 2.1), "does not hold", trials
    ) <= most(trials)


def test_a_false_zero_is_rare(trials):
    """At exactly 2 % of full W neither verdict is more frequent than its level."""

    def draw(rng):
        return [
            Level(
                "e",
                (
                    result(
                        runs(rng, np.log(0.02)),
                    ),
                ),
            ),
            Level("f", (result(runs(rng, 0.0)),)),
        ]

    for verdict in ("holds", "does not hold"):
        assert wrong(
            "nearly_zero", Question(("e", "f"), (0.02,), 1), draw, verdict, trials
        ) <= most(trials)


@pytest.mark.parametrize("offset", [0.055, 0.085])
def test_a_false_seven_per_cent_is_rare(offset, trials):
    """At exactly a limit, with a scale error that is common to all conditions."""

    def draw(rng, u=0.004):
        scale = 1 + u * rng.standard_normal()
        W_T = (1.0, 2.0, 3.0, 4.0)
        made = [
            result(scale * w * (1 + offset) * (1 + 0.01 * rng.standard_normal(N)), W_T=w, scale=u)
            for w in W_T
        ]
        return [Level("", tuple(made))]

    for verdict in ("holds", "does not hold"):
        assert wrong(
            "offset_within", Question((), (0.055, 0.085), 1), draw, verdict, trials
        ) <= most(trials)


def test_clear_cases_are_told():
    rng = np.random.default_rng(3)
    best = TESTS["optimum"](levels_of(rng, (0, 1, 2, 1)), Question(("2",), (), 1))
    assert (best.found, best.verdict, best.ties) == ("2", "holds", ())
    other = TESTS["optimum"](levels_of(rng, (0, 1, 2, 1)), Question(("1",), (), 1))
    assert (other.found, other.verdict) == ("2", "does not hold")
    either = TESTS["optimum"](levels_of(rng, (0, 2, 2, 1)), Question(("1", "2"), (), 1))
    assert (either.verdict, either.ties) == ("holds", ("1", "2"))
    tie = TESTS["optimum"](levels_of(rng, (0, 2, 2, 1)), Question(("1",), (), 1))
    assert (tie.verdict, tie.ties) == ("undecided", ("1", "2"))
    rise = TESTS["rise"](levels_of(rng, (0, 1, 2)), Question(("0", "2"), (), 1))
    assert (rise.found, rise.verdict) == ("0 < 1 < 2", "holds")
    fall = TESTS["fall"](levels_of(rng, (0, 1, 1)), Question(("0", "2"), (), 1))
    assert (fall.found[:5], fall.verdict) == ("0 < 1", "does not hold")
    assert TESTS["nonlinear"](power_law(rng, 3), Question((), (0.1,), 1)).verdict == "holds"
    assert TESTS["nonlinear"](power_law(rng, 2), Question((), (0.5,), 1)).verdict == "does not hold"


def test_what_is_not_seen_may_lose_and_never_wins():
    """An energy below the detection limit (1e-6 J here) enters by its upper limit."""
    rng = np.random.default_rng(4)
    nothing = Level("0", (result([1e-3, -1e-3, 2e-3, -2e-3]),))
    full = [Level(str(i), (result(runs(rng, x)),)) for i, x in ((1, 1.0), (2, 2.0))]
    assert TESTS["rise"]([nothing, *full], Question(("0", "2"), (), 1)).verdict == "holds"
    assert (
        TESTS["fall"]([full[1], full[0], nothing], Question(("2", "0"), (), 1)).verdict == "holds"
    )
    assert TESTS["optimum"]([nothing, *full], Question(("2",), (), 1)).verdict == "holds"
    faint = [Level(str(i), (result(runs(rng, -20.0)),)) for i in (1, 2)]
    assert TESTS["fall"]([nothing, *faint], Question(("0", "2"), (), 1)).verdict == "undecided"
    assert TESTS["optimum"]([nothing, *faint], Question(("0",), (), 1)).verdict == "undecided"
    assert TESTS["nonlinear"]([nothing, *full], Question((), (0.1,), 1)).verdict == "undecided"


def test_a_scale_error_changes_no_verdict_and_no_number_of_the_order():
    one, two = (
        levels_of(np.random.default_rng(5), np.log([1, 1.1, 1.3]) + shift) for shift in (0.0, 0.07)
    )
    for kind in ("optimum", "rise", "fall"):
        question = Question(("0", "2"), (), 1)
        first, second = TESTS[kind](one, question), TESTS[kind](two, question)
        assert (first.found, first.verdict, first.ties) == (
            second.found,
            second.verdict,
            second.ties,
        )


def test_still_conditions_do_not_shrink_the_scatter():
    """An empty box scatters 0.1 %: pooled with the beds it would make their ties look like
    differences.
    """
    rng = np.random.default_rng(6)
    beds = levels_of(rng, (1.0, 1.0))
    empty = [Level(f"e{i}", (result(runs(rng, -3.0, 1e-3), still=True),)) for i in range(6)]
    alone, together = (
        TESTS["optimum"](levels, Question(("0",), (), 1)).why for levels in (beds, [*beds, *empty])
    )
    scatter = [why.split("a run scatters by ")[1].split(";")[0] for why in (alone, together)]
    assert scatter[0] == scatter[1]


def test_a_mean_over_another_field_takes_the_same_conditions_of_each_level():
    rng = np.random.default_rng(7)
    results = {
        f"{k}{v}": result(runs(rng, m + k)) for v, m in (("a", 0.0), ("b", 0.08)) for k in range(8)
    }
    claim = entry("optimum", ["b"])
    claim["cases"] = [
        {
            "at": {},
            "levels": [{"value": v, "conditions": [f"{k}{v}" for k in range(8)]} for v in "ab"],
        }
    ]
    claim["over"] = "drive.acceleration"
    (found,) = judged([claim], results)
    assert (found.verdict, found.found) == (
        "holds",
        "b",
    )  # 8 % against 5 % / sqrt(16): 6 standard deviations
    del results["0a"]
    assert judged([claim], results)[0].verdict == "undecided"


def table(rng, cases, best):
    return {
        f"{k}{v}": result(runs(rng, 3.0 if v == best[k - 1] else 1.0), W_T=1.0 + (v == "b"))
        for k in range(1, cases + 1)
        for v in "abc"
    }


def test_a_claim_over_several_cases_holds_where_it_holds_in_each():
    rng = np.random.default_rng(8)
    claim = entry("optimum", ["b"], cases=3, levels="abc")
    (same,) = judged([claim], table(rng, 3, "bbb"))
    assert (same.verdict, same.found) == ("holds", "b")
    assert [case.at for case in same.cases] == [
        "acceleration 1 m/s^2",
        "acceleration 2 m/s^2",
        "acceleration 3 m/s^2",
    ]
    (other,) = judged([claim], table(rng, 3, "bbc"))
    assert other.verdict == "does not hold"
    assert other.found.endswith("acceleration 3 m/s^2: c")
    assert other.why == "3 cases: does not hold in 1, holds in 2"
    assert "W_T is largest at b" in other.cases[0].why


def test_an_imposed_claim_is_called_so_unless_it_fails():
    rng = np.random.default_rng(9)
    claim = entry("optimum", ["b"], levels="abc", imposed="it was put in")
    (good,) = judged([claim], table(rng, 1, "b"))
    assert good.verdict == "imposed"
    assert good.why.startswith("it was put in; ")
    assert judged([claim], table(rng, 1, "a"))[0].verdict == "does not hold"


def test_what_was_not_measured_is_undecided():
    rng = np.random.default_rng(10)
    results = table(rng, 1, "b")
    nothing = {**entry("rise", ["a", "b"]), "cases": []}
    twice = entry("optimum", ["b"], levels="abc")
    twice["cases"][0]["levels"][0]["conditions"] = ["1a", "1b"]
    once = {name: result([1.0]) for name in results}
    assert [found.verdict for found in judged([nothing, twice], results)] == [
        "undecided",
        "undecided",
    ]
    for kind, values, limits in (
        ("optimum", ["b"], []),
        ("order", ["a", "b"], []),
        ("nonlinear", [], [0.1]),
        ("offset_within", [], [0, 1.0]),
    ):
        claim = entry(kind, values, limits, levels="abc")
        assert judged([claim], once)[0].verdict == "undecided", kind
        assert judged([claim], {})[0].verdict == "undecided", kind
    missing = entry("nearly_zero", ["a", "x"], [0.02])
    assert judged([missing], results)[0].verdict == "undecided"


def test_every_kind_says_what_it_tests():
    texts = {kind: judged([entry(kind, ["a", "b"], [0.02, 0.5])], {})[0].test for kind in TESTS}
    assert texts["rise"] == "W rises with fill from a to b"
    assert len(set(texts.values())) == len(TESTS)
