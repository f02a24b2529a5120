"""What the stated 95 % hold with refills of the bed itself, which are skewed.

`PYTHONPATH=. python tests/physics/test_refill_coverage.py` prints, for each condition of fill_rate,
the skew of 1000 refills and the fraction of 4000 sessions of 4 and 8 refills whose U of W_exp holds
their mean, beside that of Student's U, and how many refills 93 % of the latter needs.
"""

import math

import numpy as np
import pytest
from refill_sessions import FILLS, LEVELS, Bank

from analysis.comparison.refills import SKEWED, TRIED, WANTED, held, refill_columns
from analysis.uncertainty.skewed_scatter import skew, stretch

LOW, HIGH = WANTED, 0.97
CERTIFIED = 0.008  # relative standard uncertainty of the default rig's instruments


def covered(source: Bank, a: int, f: int, n: int, sessions: int) -> float:
    """Share of sessions whose U of W_exp, as the analysis states it, holds the mean of the
    condition's refills. The instruments' errors are drawn from the budget's own lines."""
    rng = np.random.default_rng([9, a, f])
    W, inside = float(source.W[a, f].mean()), 0
    for _ in range(sessions):
        found = source.condition(a, f, rng, n)
        certified = math.hypot(*(line.part for line in found.lines if line.shared))
        inside += abs(found.W_exp.value - W + certified * rng.standard_normal()) <= found.W_exp.U
    return inside / sessions


def test_skewed_refills_are_covered():
    """90 % fill at 4 and 5 m/s^2, 4000 sessions drawn from 120 pourings apart from the predicted
    ones: the share is good to 0.4 % by the sessions (one sigma) and to 1.3 % by how well few
    pourings tell the tail; two of both together. Student's U holds 92 and 88 %."""
    source, slack = Bank.of(("90 %",), (4, 5), 120), 2 * math.hypot(0.004, 0.013)
    for a, plain in ((0, 0.92), (1, 0.88)):
        assert held(source.W[a, 0], CERTIFIED, 4)[0] == pytest.approx(plain, abs=slack)
        assert held(source.W[a, 0], CERTIFIED, 4, [stretch(source.refills[a][0], 4)])[
            0
        ] == pytest.approx(0.95, abs=slack)


def test_a_normal_scatter_is_not_stretched():
    """The 95 % quantile of 8192 sessions of four is good to 2 % of itself (Student's density there
    is .014): three.
    """
    values = tuple(np.random.default_rng(1).standard_normal(4000).tolist())
    assert stretch(values, 4) == pytest.approx(1.0, abs=0.06)
    assert (
        stretch((), 4) == stretch((1.0,), 4) == stretch((1.0, 1.0), 4) == stretch(values, 1) == 1.0
    )


def test_the_report_says_what_a_large_skew_leaves():
    source = Bank.of(("90 %",), (2, 5), 4)
    rng = np.random.default_rng(1)
    even, skewed = (refill_columns(source.condition(a, 0, rng, 4)) for a in (0, 1))
    assert even.refill_coverage is None
    assert even.refills_needed is None
    assert abs(even.refill_skew) < SKEWED < abs(skewed.refill_skew)
    assert -0.06 < skewed.refill_mean < -0.02  # 3 % less than the nominal bed
    assert 0.85 < skewed.refill_coverage < 0.96
    assert skewed.refills_needed in (4, *TRIED)


@pytest.mark.slow
@pytest.mark.parametrize("a", range(len(LEVELS)))
def test_stated_intervals_hold(a):
    """90 % fill, the most skewed, as the analysis states U, within three standard deviations of
    2000 sessions: what `held` computes at once. Below a skew of 1 93 to 97 %."""
    source, slack = Bank.of(("90 %",), LEVELS, 1000), 3 * math.sqrt(LOW * (1 - LOW) / 2000)
    found, factor = covered(source, a, 0, 4, 2000), stretch(source.refills[a][0], 4)
    certified = source.condition(a, 0, np.random.default_rng(1), 4)
    relative = (
        math.hypot(*(line.part for line in certified.lines if line.shared)) / certified.W_exp.value
    )
    assert found == pytest.approx(held(source.W[a, 0], relative, 4, [factor])[0], abs=slack)
    assert abs(skew(source.W[a, 0].tolist())) >= 1 or LOW - slack < found < HIGH + slack


def main() -> None:
    source = Bank.of(FILLS, LEVELS, 1000)
    print(
        "level, fill: skew, predicted; at 4 and 8 refills U/Student's U hold; refills for 93 % of the latter"
    )
    for a, level in enumerate(LEVELS):
        for f, fill in enumerate(FILLS):
            W, predicted = source.W[a, f], source.refills[a][f]
            shares = [held(W, CERTIFIED, n, (stretch(predicted, n), 1.0)) for n in (4, 8)]
            needed = next(
                (n for n in TRIED if held(W, CERTIFIED, n)[0] >= WANTED), f"more than {TRIED[-1]}"
            )
            shown = ", ".join(f"{100 * ours:.1f}/{100 * theirs:.1f} %" for ours, theirs in shares)
            print(
                f"{level} m/s^2, {fill}: {skew(W.tolist()):.2f}, {skew(predicted):.2f}; {shown}; {needed}",
                flush=True,
            )


if __name__ == "__main__":
    main()
