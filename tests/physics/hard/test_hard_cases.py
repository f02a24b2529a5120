"""Every hard case of the stability page, one test each, and the page itself."""

from pathlib import Path

import pytest

from rig.benchmarks.hard.case import Case, CaseOutcome, at_least, at_most, decade, exactly
from rig.benchmarks.hard.suite import CASES, outcome
from rig.benchmarks.stability import PAGE, differences, page
from rig.theory.single_mass import MassInGap, single_mass_total
from rig.theory.total import TooManyEvents


@pytest.mark.parametrize("case", CASES, ids=[case.name for case in CASES])
def test_the_case_holds(case: Case) -> None:
    found = outcome(case.name)
    failed = [measure for measure in (*found.measured, *found.naive) if not measure.held]
    assert failed == []
    assert found.held


@pytest.mark.slow
def test_bouncing_for_hours_is_given_up_by_name() -> None:
    """Each cycle has fewer events than are refused; the mean would need 1e8 of them. Fast twin: the
    tiny gap.
    """
    with pytest.raises(TooManyEvents):
        single_mass_total(MassInGap(1.0, 0.0, 1e-10, 0.0, 0.0, 1.0, 0.0, 0.0), 5.0, 20.0)


def test_names_are_unique() -> None:
    assert len({case.name for case in CASES}) == len(CASES)


def test_the_page_is_what_the_command_writes() -> None:
    assert differences(Path(PAGE).read_text(encoding="utf-8"), page()) == []


def test_pages_may_differ_by_what_machines_round_apart_and_no_more() -> None:
    line = "| case | error: below 1e-13 (at most 1e-9), hits: 4, share: ~0.81 | yes |"
    for other in (
        line.replace("1e-13", "1e-12"),
        line.replace("below 1e-13", "0"),
        line.replace("0.81", "0.82"),
    ):
        assert differences(line, other) == []
    for old, new in (
        ("1e-13", "1e-11"),
        ("hits: 4", "hits: 5"),
        ("0.81", "0.92"),
        ("yes", "**no**"),
        ("1e-9", "1e-8"),
    ):
        assert len(differences(line, line.replace(old, new))) == 1
    assert differences(line, f"{line}\n{line}") == ["1 lines stored, 2 made"]


def test_what_is_not_a_number_holds_no_limit() -> None:
    nan = float("nan")
    assert not any(
        m.held for m in (at_most("", nan, 1.0), at_least("", nan, 0.0), exactly("", nan, nan))
    )
    assert not CaseOutcome(()).held
    assert not CaseOutcome((at_most("", 1.0, 2.0),), naive=(at_least("", 1.0, 2.0),)).held


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"),
        (2e-13, "below 1e-12"),
        (1e-12, "below 1e-11"),
        (0.5, "below 1e0"),
        (float("inf"), "not finite"),
    ],
)
def test_decades(value: float, shown: str) -> None:
    assert decade(value) == shown
