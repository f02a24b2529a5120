"""Classes as documents: the way there and back is the identity, and what is damaged is refused with
its place.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as st

from daq.documents.classes import (
    LEFT_OUT,
    AtLeast,
    DocumentError,
    finite,
    from_document,
    shape_of,
    to_document,
)
from daq.documents.json_schema import json_schema
from daq.documents.shapes import Each, Either, Keys, List, Null, Number, Text, YesNo, deviations

Size = Annotated[float | None, Number(0.0)]


@dataclass(frozen=True, slots=True)
class Part:
    name: str
    size: Size
    note: Annotated[str | None, Text(), LEFT_OUT] = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Whole:
    from_: float
    count: Annotated[int, Number(1, whole=True)]
    good: bool
    word: Annotated[str, Text(("one", "two"))]
    parts: Annotated[tuple[Part, ...], AtLeast(1)]
    pair: tuple[float, float]
    lengths: tuple[float, ...] = ()
    texts: Mapping[str, str]
    either: float | str | tuple[float, ...] | None = None
    part: Part | None
    times: Annotated[int, LEFT_OUT] = 1


NUMBER = st.floats(-1e14, 1e14)
PART = st.builds(
    Part, st.text(max_size=3), st.none() | st.floats(0.0, 1e14), st.none() | st.text(max_size=3)
)
WHOLE = st.builds(
    Whole,
    from_=NUMBER,
    count=st.integers(1, 9),
    good=st.booleans(),
    word=st.sampled_from(["one", "two"]),
    parts=st.lists(PART, min_size=1, max_size=3).map(tuple),
    pair=st.tuples(NUMBER, NUMBER),
    lengths=st.lists(NUMBER, max_size=3).map(tuple),
    texts=st.dictionaries(st.text(max_size=2), st.text(max_size=2), max_size=2),
    either=st.none() | NUMBER | st.text(max_size=3) | st.lists(NUMBER, max_size=2).map(tuple),
    part=st.none() | PART,
    times=st.integers(1, 3),
)
DOCUMENT = {
    "from": 1.0,
    "count": 2,
    "good": True,
    "word": "one",
    "parts": [{"name": "a", "size": None}],
    "pair": [1, 2.5],
    "lengths": [],
    "texts": {"k": "v"},
    "either": [1.0],
    "part": None,
}


@given(WHOLE)
def test_there_and_back_is_the_identity(whole: Whole) -> None:
    document = to_document(whole)
    assert list(deviations(document, shape_of(Whole))) == []
    assert from_document(Whole, document) == whole
    assert to_document(from_document(Whole, document)) == document


def test_a_document_comes_back_as_it_was_keys_in_order() -> None:
    document = to_document(from_document(Whole, DOCUMENT))
    assert document == DOCUMENT
    assert list(document) == list(DOCUMENT)


def test_the_shape_is_what_the_annotations_say() -> None:
    shape = shape_of(Whole)
    part = Keys({"name": Text(), "size": Number(0.0, null=True)}, {"note": Text()})
    required = {
        "from": Number(),
        "count": Number(1, whole=True),
        "good": YesNo(),
        "word": Text(("one", "two")),
        "parts": List(part, 1),
        "pair": List(Number(), 2, 2),
        "texts": Each(Text()),
        "part": replace(part, null=True),
    }
    assert {name: json_schema(one) for name, one in shape.required.items()} == {
        name: json_schema(one) for name, one in required.items()
    }
    assert shape.optional.keys() == {"lengths", "either", "times"}
    assert json_schema(shape.optional["lengths"]) == json_schema(List(Number()))


def test_further_keys_are_passed_over() -> None:
    parts = [{**DOCUMENT["parts"][0], "later": {}}]  # type: ignore[index,dict-item]
    assert from_document(Whole, {**DOCUMENT, "parts": parts, "new": 1}) == from_document(
        Whole, DOCUMENT
    )


@pytest.mark.parametrize("key", shape_of(Whole).required)
def test_a_missing_key_is_named(key: str) -> None:
    with pytest.raises(DocumentError, match=f"^{key} is missing$"):
        from_document(Whole, {name: value for name, value in DOCUMENT.items() if name != key})


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"count": 1.5}, "count is 1.5, expected a whole number from 1"),
        ({"count": 0}, "count is 0, expected a whole number from 1"),
        ({"from": math.nan}, "from is nan, expected a number"),
        ({"word": "three"}, "word is 'three', expected one of one, two"),
        ({"parts": []}, "parts is a list, expected a list of at least 1"),
        (
            {"parts": [{"name": "a", "size": -1.0}]},
            r"parts\[0\].size is -1.0, expected a number from 0 or null",
        ),
        (
            {"parts": [{"name": "a", "size": 1.0, "note": None}]},
            r"parts\[0\].note is null, expected text",
        ),
        ({"pair": [1.0]}, "pair is a list, expected a list of at least 2 and at most 2"),
        ({"texts": {"k": 1}}, "texts.k is 1, expected text"),
        ({"either": True}, "either is True, expected"),
        ({"part": {"name": 1, "size": None}}, "part.name is 1, expected text"),
    ],
)
def test_what_is_damaged_is_refused_with_its_place(change: dict[str, object], told: str) -> None:
    with pytest.raises(DocumentError, match=f"^{told}"):
        from_document(Whole, {**DOCUMENT, **change})
    with pytest.raises(DocumentError, match=f"^whole.{told}"):
        from_document(Whole, {**DOCUMENT, **change}, "whole")


def test_no_number_without_an_end_is_written() -> None:
    """Where None is allowed it is there before anything is written; elsewhere it is null in the
    document alone.
    """
    whole = from_document(Whole, DOCUMENT)
    bad = replace(
        whole, from_=math.nan, pair=(math.inf, 1.0), either=-math.inf, parts=(Part("a", math.inf),)
    )
    assert finite(bad).parts == (Part("a", None),)
    assert finite(bad).either is None
    assert math.isnan(finite(bad).from_)
    assert to_document(bad) == to_document(whole) | {
        "from": None,
        "pair": [None, 1.0],
        "either": None,
    }
    assert finite(whole) is whole


def test_what_has_no_place_in_a_document_is_refused() -> None:
    @dataclass(frozen=True)
    class Strange:
        value: set[int]

    with pytest.raises(TypeError, match="set"):
        shape_of(Strange)


def test_null_or_a_list_is_either() -> None:
    @dataclass(frozen=True)
    class Listed:
        values: tuple[float, ...] | None

    shape = shape_of(Listed).required["values"]
    assert json_schema(shape) == json_schema(Either(Null(), List(Number())))
    for value in (None, [1.0]):
        assert to_document(from_document(Listed, {"values": value})) == {"values": value}
