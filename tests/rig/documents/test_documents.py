"""YAML and quantities on top of the shapes: lines in every message, units in every number, text
that reads back.
"""

import math
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from daq.documents.notes import Notes, Unreadable, node_of
from daq.documents.shapes import Keys, plain
from rig.documents.yaml_reader import MAX_DEPTH, read_document, read_value, read_yaml
from rig.documents.yaml_writer import write_yaml
from rig.errors import InputError
from rig.units import SMALLEST, UNITS, Quantity

LENGTH = Quantity("length", 0.0, 20.0, above=True)


def test_a_document_is_read_with_the_line_of_every_mistake() -> None:
    shape = Keys({"a": LENGTH, "b": LENGTH}, closed=True)
    notes = Notes()
    root = read_yaml("b: 5 mm\na: 150\nc: 1\n", "file", notes.mistakes)
    with pytest.raises(InputError) as caught:
        read_document(shape, root, notes)
    assert [str(mistake).split(": found")[0] for mistake in caught.value.mistakes] == [
        "file:2: a",
        "file:3: c",
    ]
    assert "did you mean 150 mm?" in str(caught.value)
    good = Notes()
    assert read_document(shape, read_yaml("b: 5 mm\na: 1\n", "file", []), good) == {
        "b": 0.005,
        "a": 1.0,
    }
    assert good.place_of("a") == "file:2"


@pytest.mark.parametrize("dimension", UNITS)
def test_a_quantity_reads_what_it_writes(dimension: str) -> None:
    quantity = Quantity(dimension)

    @given(
        st.floats(allow_nan=False, allow_infinity=False).filter(
            lambda x: x == 0 or abs(x) >= SMALLEST
        )
    )
    def same(value: float) -> None:
        found = quantity.read(node_of(plain(quantity, value)), "", Notes())
        assert found == value
        assert math.copysign(1.0, found) == (math.copysign(1.0, value) if value else 1.0)  # type: ignore[arg-type]

    same()


@pytest.mark.parametrize(
    "value",
    ["5 mm", 0.005, "1.5e1m", "none", None, "-5 mm", 0, -1, 21, "mm", "5 kg", True, [1], "nothing"],
)
def test_a_quantity_and_its_schema_agree(value: object) -> None:
    quantity = Quantity("length", 0.0, 20.0, above=True, null=True, words=("none",))
    notes = Notes()
    with suppress(Unreadable):
        quantity.read(value, "", notes)
    assert bool(notes.mistakes) == bool(
        list(Draft202012Validator(quantity.schema({})).iter_errors(value))
    )


@given(
    st.dictionaries(
        st.text(st.characters(min_codepoint=97, max_codepoint=122), min_size=1),
        st.text() | st.floats(),
    )
)
def test_what_is_written_as_yaml_is_read_back(data: dict[str, object]) -> None:
    finite = {
        key: value for key, value in data.items() if isinstance(value, str) or math.isfinite(value)
    }  # type: ignore[arg-type]
    if finite:
        assert read_yaml(write_yaml(finite), "text", []).plain() == finite


def test_depth_is_bounded() -> None:
    assert read_value("[" * (MAX_DEPTH - 1) + "]" * (MAX_DEPTH - 1), "here")
    with pytest.raises(InputError, match="more than 20 levels"):
        read_value("[" * (MAX_DEPTH + 1) + "]" * (MAX_DEPTH + 1), "here")
