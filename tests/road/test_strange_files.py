"""Paths and terminals that differ from the usual: pipes, devices, folders in place of files, names that
no encoding has, full disks and memory limits each end in one sentence.

The commands run with a terminal that has ASCII only, in a folder whose name no encoding has.
"""

import json
import os
import re
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest
from small_protocol import SMALL

NAME = "\udcff\udc80 ä力±"
"""A name that is no UTF-8, with a space and letters that a terminal may lack."""

ASCII = {
    "PYTHONIOENCODING": "ascii:strict",
    "LC_ALL": "C",
    "PYTHONUTF8": "0",
    "PYTHONCOERCECLOCALE": "0",
}
MAP = "schema: rig/map/1\nname: lab\nforce: {channel: '1'}\nacceleration: {channel: '2'}\nrate: 10240 Hz\nsettle: 0.5 s\n"
SETS = (
    "--set",
    "vary={scene.bed: [layers, locked]}",
    "--set",
    "acquire.settle=10",
    "--set",
    "acquire.record=8",
)

LONG = "1" + "0" * 400
"""A whole number beyond every float."""

Command = Callable[..., dict[str, Any]]
"""Calls the command `rig` with words; F in them stands for the strange folder."""


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("strange") / NAME
    folder.mkdir()
    (folder / "p.yaml").write_text(SMALL)
    (folder / "map.yaml").write_text(MAP)
    (folder / "folder").mkdir()
    os.mkfifo(folder / "pipe")
    with socket.socket(socket.AF_UNIX) as bound:
        bound.bind(os.path.relpath(folder / "socket"))
    (folder / "device").symlink_to("/dev/zero")
    for suffix in (".csv", ".npz", ".mat", ".h5", ".uff", ".tdms", ".yaml"):
        (folder / f"pipe{suffix}").symlink_to("pipe")
    return folder


@pytest.fixture(scope="module")
def bare_rig(place: Path) -> Iterator[Command]:
    program = [sys.executable, str(Path(__file__).parent / "many_commands.py")]
    environment = {
        **os.environ,
        **ASCII,
        "PYTHONPATH": str(Path(__file__).parents[2]),
        "OPENBLAS_NUM_THREADS": "1",
    }
    with subprocess.Popen(
        program,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
        cwd=place,
    ) as running:
        assert running.stdin is not None
        assert running.stdout is not None

        def call(words: str | Sequence[str], **to: str) -> dict[str, Any]:
            given = words.split() if isinstance(words, str) else words
            job = {"words": [re.sub(r"\bF/", f"{place}/", word) for word in given], **to}
            print(json.dumps(job), file=running.stdin, flush=True)
            found = json.loads(running.stdout.readline())
            assert "Traceback" not in found["err"], found["err"]
            return found

        yield call
        running.stdin.close()


@pytest.fixture(scope="module")
def session(bare_rig: Command, place: Path) -> Path:
    found = bare_rig(["run", "F/p.yaml", "--out", "F/s", *SETS])
    assert found["code"] in (0, 1), found["err"]
    return place / "s"


@pytest.fixture(scope="module")
def rig(bare_rig: Command, session: Path) -> Command:
    """Where a session has been recorded."""
    assert session.is_dir()
    return bare_rig


WITH_A_PATH = (
    "check P",
    "run P",
    "model P",
    "calibrate P --target 0.07 --out F/c.yaml",
    "check F/p.yaml --rig P",
    "run F/p.yaml --rig P",
    "report P",
    "report F/s P",
    "info P",
    "info P --validate",
    "replay P",
    "export P --to csv",
    "import P --map F/map.yaml --out F/i",
    "import F/r.csv --map P --out F/i",
)
SOME = ("check P", "info P", "import F/r.csv --map P --out F/i")
SLOW = pytest.mark.slow
WHAT = {"pipe": "a pipe", "socket": "a socket", "device": "a device", "folder": "a folder"}


@pytest.mark.parametrize(("kind", "commands"), [
    ("pipe", WITH_A_PATH), *((kind, SOME) for kind in ("socket", "device", "folder")),
    *(pytest.param(kind, WITH_A_PATH, marks=SLOW) for kind in ("socket", "device", "folder")),
])  # fmt: skip
def test_what_is_no_file_is_said_and_never_waited_for(
    rig: Command, place: Path, kind: str, commands: Sequence[str]
) -> None:
    (place / "r.csv").write_text("1,2\n")
    for words in commands:
        found = rig(
            words.replace("P", f"F/{kind}", 1)
            if words != "report F/s P"
            else f"report F/s F/{kind}"
        )
        assert (found["code"], found["out"]) == (2, ""), words
        assert found["err"].isascii()
        assert found["err"].count("\n") == 1
        if words in ("check P", "import F/r.csv --map P --out F/i") or (
            kind != "folder" and words == "info P"
        ):
            assert WHAT[kind] in found["err"]


@pytest.mark.parametrize("suffix", ["csv", "npz", "mat", "h5", "uff", "tdms"])
def test_a_record_that_is_a_pipe(rig: Command, suffix: str) -> None:
    found = rig(f"import F/pipe.{suffix} --map F/map.yaml --out F/i")
    assert found["code"] == 2
    assert "is a pipe, no file" in found["err"]


@pytest.mark.usefixtures("session")
@pytest.mark.parametrize("damage", ["pipe", "cut", "nested", "no text"])
def test_a_file_beside_a_record_that_cannot_be_read_is_refused(
    rig: Command, place: Path, damage: str
) -> None:
    """It may say what is corrected in the record: without it a pole might be undone twice."""
    assert rig("export F/s --to csv --run 1 --out F/e.csv --force")["code"] == 0
    beside = place / "e.csv.json"
    text = beside.read_bytes()
    beside.unlink()
    if damage == "pipe":
        os.mkfifo(beside)
    else:
        beside.write_bytes(
            {"cut": text[: len(text) // 2], "nested": b"[" * 100_000, "no text": b"\xff\xfe"}[
                damage
            ]
        )
    done = rig("import F/e.csv --map F/map.yaml --out F/imported")
    beside.unlink()
    assert done["code"] == 2
    assert "cannot be read" in done["err"]


def test_a_pipe_in_the_place_of_a_lock(rig: Command, session: Path) -> None:
    """A reader needs none; a writer refuses it, and leaves it there."""
    lock = session / "session.h5.lock"
    os.mkfifo(lock)
    assert rig("info F/s")["code"] == 0
    done = rig("run nulls --set repeats=1 --set acquire.record=4 --out F/s --force")
    assert done["code"] == 2
    assert "no regular file" in done["err"]
    assert lock.is_fifo()
    lock.unlink()


@pytest.mark.parametrize(
    "words",
    [
        "init P --force",
        "schema --out P --force",
        "export F/s --to csv --run 1 --out P --force",
        pytest.param("report F/s --out P", marks=SLOW),
    ],
)
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_what_is_no_file_is_not_replaced(rig: Command, place: Path, words: str, kind: str) -> None:
    before = os.lstat(place / kind)
    assert rig(words.replace("P", f"F/{kind}"))["code"] == 2
    assert os.path.samestat(os.lstat(place / kind), before)


@pytest.mark.parametrize(
    "words",
    [
        "check F/p.yaml",
        "report F/s --out F/again",
        "info F/s --json",
        "export F/s --to mat --json",
        "--help",
        *(
            pytest.param(words, marks=SLOW)
            for words in (
                "model F/p.yaml",
                "report F/s F/s",
                "info F/s",
                "info F/s --validate",
                "replay F/s",
                "run --help",
                "export F/s --to uff58",
                "init F/new.yaml",
                "schema --out F/schema.json",
                "catalog material",
            )
        ),
    ],
)
def test_a_terminal_that_knows_ascii_and_a_path_that_no_encoding_has(
    rig: Command, words: str
) -> None:
    found = rig(words)
    assert found["code"] in (0, 1), found["err"]
    assert (found["out"] + found["err"]).isascii()
    if "--json" in words:
        json.loads(found["out"])


@pytest.mark.parametrize(
    "words",
    [
        [NAME],
        ["check", NAME],
        ["check", "--" + NAME],
        ["check", "F/p.yaml", "--set", f"{NAME}=1"],
        ["catalog", NAME],
        ["check", "F/p.yaml", "--set", f"name={NAME}"],
        ["check", "F/p.yaml", "--rig", NAME],
        ["run", "F/p.yaml", NAME],
        ["report", NAME],
        ["export", "F/s", "--to", NAME],
        ["export", "F/s", "--to", "csv", "--run", NAME],
        ["replay", "F/s", "--speed", NAME],
        ["model", "--study", NAME],
        ["schema", NAME],
        ["run", "F/p.yaml", "--seed", NAME],
    ],
)
def test_words_that_no_encoding_has(rig: Command, words: list[str]) -> None:
    found = rig(words)
    assert found["code"] == 2
    assert found["err"].isascii()


@pytest.mark.parametrize(
    "words",
    [
        "info F/s",
        "--help",
        "--version",
        *(
            pytest.param(words, marks=SLOW)
            for words in (
                "check F/p.yaml",
                "model F/p.yaml --json",
                "report F/s",
                "replay F/s",
                "export F/s --to csv",
                "catalog",
            )
        ),
    ],
)
def test_a_full_disk_under_all_output_is_three(rig: Command, words: str) -> None:
    assert rig(words, stdout="/dev/full", stderr="/dev/full")["code"] == 3


def test_a_full_disk_under_one_of_them_is_three_where_anything_was_to_be_written(
    rig: Command,
) -> None:
    assert rig("info F/s", stdout="/dev/full")["code"] == 3
    assert rig("info F/s", stderr="/dev/full")["code"] == 0
    assert rig("export F/s --to csv", stderr="/dev/full")["code"] == 3  # its progress
    for words in (
        "check F/nothing.yaml",
        "check --nonsense",
        "nonsense",
    ):  # said or not, it is bad input
        assert rig(words, stderr="/dev/full")["code"] == 2


@pytest.mark.parametrize("megabytes", [200, 1100])
def test_a_limit_of_memory_is_called_one(megabytes: int, place: Path) -> None:
    program = (
        f"import resource; resource.setrlimit(resource.RLIMIT_AS, ({megabytes * 10**6},) * 2); "
        "import sys; sys.argv = ['rig', 'check', 'p.yaml']; from rig.cli.app import main; main()"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, "-c", program]
    done = subprocess.run(
        command,
        cwd=place,
        capture_output=True,
        text=True,
        env=environment,
        timeout=300,
        check=False,
    )
    assert done.returncode == 3
    assert done.stderr.startswith(
        f"rig: too little memory: this process may use {megabytes} MB (ulimit -v)"
    )
