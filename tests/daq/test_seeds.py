"""Named random streams."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from daq.random_streams import stream

WORDS = st.lists(st.text(max_size=5), min_size=1, max_size=3)


def first(seed: int, *words: str) -> list[int]:
    return stream(seed, *words).integers(0, 2**63, 4).tolist()


@given(seed=st.integers(0, 2**130), words=WORDS)
def test_the_same_words_give_the_same_stream(seed: int, words: list[str]) -> None:
    assert first(seed, *words) == first(seed, *words)


@given(words=WORDS, others=WORDS, seed=st.integers(0, 2**64), other=st.integers(0, 2**64))
def test_other_words_or_seeds_give_another(
    words: list[str], others: list[str], seed: int, other: int
) -> None:
    assert (first(seed, *words) == first(other, *others)) == (words == others and seed == other)


def test_words_are_not_merely_joined() -> None:
    assert first(1, "ab", "c") != first(1, "a", "bc")
    assert first(1, "1", "2") != first(12, "2")


def test_streams_are_independent_of_each_other() -> None:
    a, b = (
        stream(5, "force").standard_normal(20000),
        stream(5, "acceleration").standard_normal(20000),
    )
    assert abs(np.corrcoef(a, b)[0, 1]) < 5 / np.sqrt(20000)


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(ValueError, match="negative"):
        stream(-1, "force")
