"""Linear algebra has one thread, unless the user says otherwise."""

import gc
import os
from collections.abc import Iterator

import pytest

from rig.cli import app

NAME = "OPENBLAS_NUM_THREADS"


@pytest.fixture(autouse=True)
def _as_before() -> Iterator[None]:
    threshold = gc.get_threshold()
    yield
    gc.set_threshold(*threshold)


@pytest.mark.parametrize(("given", "expected"), [(None, "1"), ("2", "2")])
def test_one_thread_or_the_users(
    monkeypatch: pytest.MonkeyPatch, given: str | None, expected: str
) -> None:
    monkeypatch.setenv(NAME, given or "")
    if given is None:
        monkeypatch.delenv(NAME)
    seen = []
    monkeypatch.setattr(app, "with_whole_output", lambda _: seen.append(os.environ.get(NAME)))
    app.main()
    assert seen == [expected]
