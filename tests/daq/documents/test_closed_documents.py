"""Dataclasses as closed documents: read, written back, with their defaults in the schema."""

from dataclasses import dataclass
from typing import Annotated, Literal

import pytest

from daq.documents.classes import keys_of, paths_of, shape_at
from daq.documents.json_schema import json_schema
from daq.documents.notes import Notes, Unreadable, node_of
from daq.documents.shapes import Number, Text, one_of, plain, some_of


@dataclass(frozen=True)
class Pair:
    left: Annotated[float, Number(0.0, 1.0)] = 0.5
    right: Annotated[float, Number(0.0, 1.0)] = 0.5


@dataclass(frozen=True)
class Sheet:
    title: str
    colour: Annotated[str, one_of("red", "green")] = "red"
    side: Literal["front", "back"] = "front"
    pair: Pair = Pair()
    marks: Annotated[tuple[str, ...], some_of("a", "b")] = ()
    copies: int | None = None
    other: Pair | None = None


def read(data: object) -> tuple[object, list[str]]:
    notes = Notes(known=tuple(paths_of(Sheet)))
    try:
        return keys_of(Sheet).read(node_of(data, "f:1"), "", notes), [
            str(m) for m in notes.mistakes
        ]
    except Unreadable:
        return None, [str(m) for m in notes.mistakes]


def test_what_is_written_is_read_back() -> None:
    sheet = Sheet("x", "green", "back", Pair(0.1, 0.2), ("b", "a"), 3, Pair())
    assert read(plain(keys_of(Sheet), sheet)) == (sheet, [])
    assert read({"title": 12}) == (Sheet("12"), [])


def test_a_plain_value_stands_for_every_part_of_a_group_that_is_alike() -> None:
    assert read({"title": "x", "pair": 0.3}) == (Sheet("x", pair=Pair(0.3, 0.3)), [])


def test_every_mistake_at_once_and_the_rest_is_read() -> None:
    sheet, found = read(
        {"title": "x", "color": "red", "side": "bak", "pair": {"left": 2}, "marks": ["a", "a"]}
    )
    assert sheet == Sheet("x")
    assert [line.partition(": found")[0] for line in found] == [
        "f:1: color", "f:1: side", "f:1: pair.left", "f:1: marks",
    ]  # fmt: skip
    assert "did you mean 'colour'?" in found[0]
    assert "did you mean 'back'?" in found[1]
    assert "'a' twice" in found[3]


def test_a_key_in_the_wrong_place_is_sent_home() -> None:
    assert "did you mean pair.left?" in read({"title": "x", "left": 0.1})[1][0]


def test_what_is_missing_has_no_value() -> None:
    sheet, (line,) = read({})
    assert sheet is None
    assert line == "f:1: title: found nothing; allowed: an entry title"


def test_paths_and_the_shapes_at_them() -> None:
    assert list(paths_of(Sheet))[3:6] == ["pair", "pair.left", "pair.right"]
    assert shape_at(Sheet, "pair.left") == Number(0.0, 1.0)
    assert shape_at(Sheet, "colour") == Text(("red", "green"), as_written=True)
    assert shape_at(Sheet, "pair.up") is None


def test_the_schema_has_the_defaults_and_the_groups() -> None:
    schema = json_schema(keys_of(Sheet))
    assert schema["required"] == ["title"]
    assert schema["additionalProperties"] is False
    assert schema["properties"]["colour"] == {"enum": ["red", "green"], "default": "red"}
    assert schema["properties"]["copies"]["default"] is None
    assert schema["$defs"]["Pair"]["properties"]["left"]["default"] == 0.5


def test_a_type_without_a_shape_is_refused_at_once() -> None:
    @dataclass(frozen=True)
    class Odd:
        part: complex = 0j

    with pytest.raises(TypeError, match="complex"):
        keys_of(Odd)
