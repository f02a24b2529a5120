"""Shapes: what one takes its schema takes, every deviation is told, a reading goes on after a
mistake.
"""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from daq.documents.json_schema import json_schema
from daq.documents.notes import Notes, Unreadable, node_of
from daq.documents.shapes import (
    Choice,
    Each,
    Either,
    Keys,
    List,
    Null,
    Number,
    OneOf,
    Shape,
    Text,
    Then,
    YesNo,
    deviations,
)

POINT = Keys(
    {"x": Number(0.0, 1.0), "name": Text(("a", "b"))},
    {"more": List(Number(whole=True), 1, 3)},
    null=True,
)
LEFT, RIGHT = (
    Keys({"left": Number()}, {"by": Text()}, closed=True),
    Keys({"right": Number()}, closed=True),
)
SHAPES: dict[str, Shape] = {
    "point": POINT,
    "closed": Keys({"x": Number(null=True)}, {"y": YesNo()}, closed=True),
    "each": Each(Number(0.0, above=True)),
    "choice": Choice("kind", {"one": Keys({"x": Number()}), "two": Keys({"y": Text(null=True)})}),
    "one of": OneOf(
        {
            "left": Keys({"left": Number()}, {"by": Text()}, closed=True),
            "right": Keys({"right": Number()}, closed=True),
        },
        "turn",
    ),
    "either": Either(Null(), List(YesNo())),
    "then": Then(Text(), lambda text, *_: text.upper()),
    "once": List(Text(("a", "b")), unique=True),
}
KEYS = st.sampled_from(["x", "y", "name", "more", "kind", "left", "right", "by"])
LEAVES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-3, 3),
    st.floats(-2, 2),
    st.sampled_from(["a", "one", "two"]),
)
VALUES = st.recursive(
    LEAVES, lambda part: st.lists(part, max_size=3) | st.dictionaries(KEYS, part, max_size=3)
)


@pytest.mark.parametrize("name", SHAPES)
def test_reader_and_schema_agree(name: str) -> None:
    shape = SHAPES[name]
    schema = json_schema(shape)
    Draft202012Validator.check_schema(schema)
    validator = Draft202012Validator(schema)

    @given(VALUES)
    def agree(value: Any) -> None:
        assert bool(list(deviations(value, shape))) == bool(list(validator.iter_errors(value)))

    agree()


@pytest.mark.parametrize("name", SHAPES)
def test_a_node_is_read_as_plain_data_are(name: str) -> None:
    @given(VALUES)
    def same(value: Any) -> None:
        found = []
        for node in (value, node_of(value, "file:1")):
            notes = Notes()
            try:
                found.append((SHAPES[name].read(node, "", notes), 0))
            except Unreadable:
                found.append((None, len(notes.mistakes)))
            assert all(mistake.where in ("", "file:1") for mistake in notes.mistakes)
        assert found[0] == found[1]

    same()


def test_every_deviation_is_reported_with_its_path() -> None:
    wrong = {"x": 2, "name": "c", "more": [1, 2.5, "x"], "free": 0}
    assert list(deviations(wrong, POINT, "point")) == [
        "point.x is 2, expected a number from 0 to 1",
        "point.name is 'c', expected one of a, b",
        "point.more[1] is 2.5, expected a whole number",
        "point.more[2] is 'x', expected a whole number",
    ]
    assert list(deviations({"x": None}, POINT, "point")) == [
        "point.x is null, expected a number from 0 to 1",
        "point.name is missing",
    ]
    assert list(deviations({"name": "a", "x": 0.5, "more": []}, POINT)) == [
        "more is a list, expected a list of at least 1 and at most 3"
    ]


def test_lists_are_equally_long() -> None:
    shape = Keys({"a": List(Number()), "b": List(Number())}, as_long=("a", "b"))
    assert list(deviations({"a": [1.0], "b": []}, shape, "it")) == ["it.a, b are not equally long"]


@given(st.lists(st.floats(allow_nan=True, allow_infinity=True)))
def test_a_list_of_floats_is_judged_as_each_of_them(values: list[float]) -> None:
    number = Number(-1.0, 1e3, above=True)
    assert number.holds_all(values) == all(map(number.holds, values))


@pytest.mark.parametrize("value", [float("nan"), float("inf"), 10**400, 1e16, True, "1"])
def test_no_number_is_without_bounds(value: object) -> None:
    assert list(deviations(value, Number()))


def test_hidden_characters_stay_visible_in_a_sentence() -> None:
    assert list(deviations({"a\x1b": 1}, Each(Text()))) == ["a\\x1b is 1, expected text"]
