"""Text from strangers: in no output can it steer a terminal, hide, begin a line, be a formula or be
markup.
"""

import io
import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_protocol import SMALL
from strange import clean, hostile, shape_of, swapped

from daq.json_text import json_text
from daq.session.plan import SessionError
from daq.session.record import open_session
from daq.strange_text import cell_text, visible
from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.cli.commands.exchange import export_session
from rig.cli.commands.sessions import (
    compare_sessions,
    report_sessions,
    session_info,
    validate_session,
)
from rig.cli.terminal.tables import Terminal, table
from rig.errors import InputError
from rig.importing.mapping import read_mapping
from rig.protocol.load import load_protocol

FREE = ("small", "stainless", "question", "claim", "default", "not stated", "recorded by others")
"""Text of the session's documents that is free; the same everywhere."""

ATTRIBUTES = ("model", "serial", "direction", "calibration_date", "coupling")


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three conditions, two repeats, with claims and varied paths."""
    out = tmp_path_factory.mktemp("own") / "session"
    text = f"{SMALL}question: question\nexpect: [{{claim: claim, rise: drive.acceleration, from: 2 m/s^2, to: 4 m/s^2}}]\n"
    sets = (
        "vary={scene.bed: [layers, locked], drive.acceleration: [2 m/s^2, 4 m/s^2]}",
        "repeats.n=2",
    )
    protocol = load_protocol(text, sets=sets)
    run(campaign_of(protocol, load_rig(protocol.rig), text), out, workers=1)
    return out / "session.h5"


def told_by_strangers(session: Path, target: Path, texts: list[str]) -> None:
    """A copy of the session whose ids, names, units and other free text are the texts."""
    shutil.copy(session, target)
    with h5py.File(target, "r+", libver=("v110", "v110")) as file:
        ids = [condition["id"] for condition in json.loads(file["session/conditions"][()])]
        values = json.loads(file["session/rig"][()])["values"]
        told = [
            value[key]
            for value in values[:9]
            for key in ("path", "unit", "status", "source")
            if value[key]
        ]
        free = dict.fromkeys([*ids, *FREE, *told])
        # ids stay different from each other
        swap = {
            text: f"{texts[n % len(texts)]}{n if text in ids else ''}"
            for n, text in enumerate(free)
        }
        for owner in (file["session"], file["session/truth"]):
            for name in [
                n
                for n in owner
                if isinstance(owner[n], h5py.Dataset) and owner[n].dtype.kind == "S"
            ]:
                if name in ("protocol_text", "scalars"):
                    continue
                value = swapped(json.loads(owner[name][()]), swap, ids)
                if name == "provenance":
                    value["command"] = texts[0]
                del owner[name]
                owner.create_dataset(name, data=np.array(json.dumps(value).encode()))
        for channel in file["session/channels"].values():
            for n, name in enumerate(ATTRIBUTES):
                text = texts[n % len(texts)].replace("\0", "")
                channel.attrs[name] = np.array(text.encode() or b"x")


def outputs(
    session: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> tuple[dict[str, Any], list[int]]:
    """Every command that reads a session: the shape of its files, and the lines that each printed."""
    lines = []

    def told(command: Callable[[], object]) -> None:
        capsys.readouterr()
        command()
        shown = capsys.readouterr()
        for text in shown:
            clean(text)
        lines.append(len(shown.out.splitlines()))

    told(lambda: report_sessions([session], folder / "report", False))
    told(lambda: report_sessions([session], folder / "report", True))
    told(lambda: compare_sessions([session, session], folder / "compared", False, True))
    told(lambda: session_info(session, False))
    told(lambda: session_info(session, True))
    told(lambda: validate_session(session, False))
    for to in ("csv", "uff58"):
        told(lambda to=to: export_session(session, to, "1", folder / f"r.{to[:3]}", False, False))  # type: ignore[misc]
    return shape_of(folder), [lines[0], *lines[2:4]]


@pytest.fixture
def plain_outputs(
    session: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> tuple[dict[str, Any], list[int]]:
    monkeypatch.setenv("COLUMNS", "3000")  # so that no table wraps
    target = tmp_path / "plain.h5"
    told_by_strangers(session, target, ["a", "b", "c", "d"])
    return outputs(target, tmp_path / "plain", capsys)


@pytest.mark.slow
def test_what_strangers_write_is_text_in_every_output(
    session: Path,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    plain_outputs: tuple[dict[str, Any], list[int]],
) -> None:
    """The outputs of a session full of hostile text are made of the same elements and lines as
    those of a tame one.
    """
    count = 0

    @settings(max_examples=12)
    @given(st.lists(hostile, min_size=4, max_size=9))
    def every(texts: list[str]) -> None:
        nonlocal count
        count += 1
        target = tmp_path / f"{count}.h5"
        told_by_strangers(session, target, texts)
        files, _ = outputs(target, tmp_path / str(count), capsys)
        for name, shape in plain_outputs[0].items():
            assert files[name] == shape, name

    every()


@given(hostile)
def test_a_string_is_one_line_of_a_terminal_and_no_markup(text: str) -> None:
    console = Terminal(file=io.StringIO(), width=10_000)
    console.print(text)
    console.print(table("t", ("a", "b"), [(text, "x"), ("y", text)]))
    shown = console.file.getvalue()  # type: ignore[attr-defined]
    clean(shown)
    assert len(shown.splitlines()) == 5
    assert shown.startswith(visible(text).rstrip()[:20])


@settings(max_examples=30)
@given(
    st.dictionaries(
        hostile,
        st.lists(hostile | st.integers() | st.none() | st.floats(allow_nan=False), max_size=3),
    )
)
def test_json_reads_back_and_hides_nothing(value: Any) -> None:
    assert json.loads(json_text(value)) == value
    clean(json_text(value))


@given(st.floats(allow_nan=False) | st.integers())
def test_numbers_stay_numbers_in_cells(value: float) -> None:
    assert cell_text(value) is value


@pytest.mark.parametrize(
    "name", ["", ".x", "..", "-x", "a/b", "a\\b", "a b", "\x1b[2J", "ä", "a\n", "session", "x|y"]
)
def test_runs_are_named_so_that_files_can_be(session: Path, tmp_path: Path, name: str) -> None:
    target = tmp_path / "theirs.h5"
    shutil.copy(session, target)
    with h5py.File(target, "r+", libver=("v110", "v110")) as file:
        runs = json.loads(file["session/runs"][()])
        runs[0]["name"] = name
        del file["session/runs"]
        file["session"].create_dataset("runs", data=np.array(json.dumps(runs).encode()))
    with pytest.raises(SessionError, match="has a run called") as caught:
        open_session(target)
    clean(str(caught.value))


@given(hostile)
def test_a_mistake_is_one_line(text: str) -> None:
    quoted = json.dumps(f"{text}é")  # JSON's escapes are YAML's, in double quotes
    mistakes = []
    for document in (
        f"schema: rig/protocol/1\nname: {quoted}\n",
        f"{quoted}: 1\n",
        f"x: &a {quoted}\n",
    ):
        with pytest.raises(InputError) as caught:
            load_protocol(document + "\n")
        mistakes += str(caught.value).splitlines()
        assert len(str(caught.value).splitlines()) == len(caught.value.mistakes)
    for line in mistakes:
        clean(line)


def test_a_mapping_may_hold_any_text(tmp_path: Path) -> None:
    text = '{schema: rig/map/1, name: "\\e[2J", force: {channel: "\\e", unit: "\\u202E"}, acceleration: {channel: "1"}}'
    (tmp_path / "map.yaml").write_text(text)
    with pytest.raises(InputError) as caught:
        read_mapping(tmp_path / "map.yaml")
    clean(str(caught.value))
