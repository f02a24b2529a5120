"""The errata and the sentences of the paper: every number that docs/model.md quotes."""

import numpy as np
import pytest

from rig.theory.paper.errata import errata
from rig.theory.paper.erratum import Erratum

ROWS = errata()


def row(equation: str, words: str) -> Erratum:
    (found,) = (r for r in ROWS if r.equation == equation and words in r.subject)
    return found


@pytest.mark.parametrize(
    ("equation", "words", "printed", "corrected"),
    [
        ("5", "h_i", 1.543, 1.106),
        ("5", "mu_i", 1.302, 1.106),
        ("6", "departs", 1.0, 0.0),
        ("7", "cos", 1.0, 0.0),
        ("9", "nothing slips", 0.0875, 0.0),
        ("11, row 4 of B", "approaches", 1.0, 0.0),
        ("11", "random hits", 0.548, 0.0),
        ("11", "wide", 0.812, 0.0),
        ("11", "slip near 0", 1.135, 0.81),
        ("14", "compression", 1.2, 0.8),
        ("15", "sticks", 2.0, 1.0),
        ("17", "e0", -1.0, 0.7),
        ("18", "after the hit", 0.762, 0.66),
        ("14, 18", "one after", 0.562, 0.66),
        ("19c", "height", 0.202, 0.002),
        ("23", "put in", 3.035, 0.904),
        ("text, Fig. 5", "box that it needs", 0.075, 0.18495),
        ("text, Fig. 5", "tested box at", 4752.0, 1926.3),
        ("text, Fig. 5", "limit is reached", 1.0, 0.99),
        ("text, Fig. 7", "velocity of the 7th", 0.06, 0.3153),
        ("text, Fig. 7", "e below", 0.65, 0.2514),
        ("text, Fig. 7", "grain that has", 7.0, 15.6),
    ],
)
def test_numbers(equation: str, words: str, printed: float, corrected: float) -> None:
    found = row(equation, words)
    assert found.printed_value == pytest.approx(printed, rel=2e-3, abs=2e-3)
    assert found.corrected_value == pytest.approx(corrected, rel=2e-3, abs=2e-3)
    assert not found.holds


def test_what_holds_as_printed_has_equal_numbers() -> None:
    for found in ROWS:
        if found.holds and found.printed_value is not None:
            assert found.corrected_value == pytest.approx(
                found.printed_value, rel=1e-12, abs=1e-12
            ), found.subject


def test_every_equation_is_there() -> None:
    """1 to 25, alone or in a group; 8, 10 and 16 among the errata of the system and the wall."""
    named = {int(part.rstrip("abc")) for r in ROWS for part in r.equation.replace("row 4 of B", "").split(", ")
             if part.rstrip("abc").isdigit()}  # fmt: skip
    assert named == set(range(1, 26))


def test_numbers_are_finite_and_repeat() -> None:
    again = errata()
    assert again == ROWS
    values = [v for r in ROWS for v in (r.printed_value, r.corrected_value) if v is not None]
    assert np.isfinite(values).all()
    assert all(type(v) in (float, int) for v in values)
    assert all(type(r.holds) is bool for r in ROWS)
