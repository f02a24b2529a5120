"""Sessions of the first edition are read with today's names."""

from pathlib import Path

from analysis import read_session
from analysis.session.former_names import condition_today, prediction_today
from daq import open_session

OLD = Path(__file__).parents[2] / "data" / "session-v1.h5"


def test_a_session_of_the_first_edition_is_read_with_todays_names() -> None:
    with open_session(OLD) as record:
        assert {condition["drive"] for condition in record.conditions.values()} == {"servo"}
        report = read_session(record)
    assert {row.drive for row in report.conditions} == {"prescribed"}
    assert report.waveform == "ideal"
    assert all(row.W_T_as_printed is not None for row in report.conditions if row.W_T is not None)


def test_words_and_keys_have_todays_names_in_their_places() -> None:
    old = {"id": "c01", "bed": "slug", "drive": "coupled", "mistake": {"kind": "skew"}, "more": 1}
    new = {
        "id": "c01",
        "bed": "single_mass",
        "drive": "shaker",
        "deliberate_error": {"kind": "skew"},
        "more": 1,
    }
    assert condition_today(old) == new
    assert list(condition_today(old)) == list(new)
    assert condition_today(new) == new
    assert condition_today({"bed": 3, "drive": None}) == {"bed": 3, "drive": None}


def test_a_prediction_keeps_todays_key_where_both_stand() -> None:
    old = {
        "conditions": {"c01": {"W_T_paper": 1.0}, "c02": {"W_T_paper": 1.0, "W_T_as_printed": 2.0}}
    }
    assert prediction_today(old) == {
        "conditions": {"c01": {"W_T_as_printed": 1.0}, "c02": {"W_T_as_printed": 2.0}}
    }
    for value in (None, [], {"conditions": 3}, {"conditions": {"c01": None}}):
        assert prediction_today(value) == value
