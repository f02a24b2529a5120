"""Files and places of strangers: what is no file, has no end, unpacks without end or says absurd
things is a sentence.

The commands run where the terminal knows ASCII alone, in a folder whose name no encoding has.
"""

import json
import os
import re
import socket
import subprocess
import sys
import weakref
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import scipy.io
from small_protocol import SMALL

import daq.expansion
from daq.formats.reading import read_columns
from daq.formats.sidecar import read_sidecar
from daq.formats.uff58 import write_uff58
from daq.formats.wave import FormatError, Wave
from daq.formats.writing import write_csv
from daq.session.plan import SessionError
from daq.session.record import open_session
from rig.errors import InputError
from rig.importing.mapping import read_mapping

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


# Rates


def as_npz(path: Path, value: str) -> None:
    told = '[{"name": "F", "fs": 1000.0}, {"name": "a", "fs": %s}]' % value  # noqa: UP031  braces
    np.savez(path, channels=np.array(told), data_0=np.arange(100.0), data_1=np.arange(100.0))


def as_mat(path: Path, value: str) -> None:
    scipy.io.savemat(path, {"F": np.arange(100.0), "a": np.arange(100.0), "fs": float(value)})


def as_tdms(path: Path, value: str) -> None:
    nptdms = pytest.importorskip("nptdms")
    step = {
        "wf_increment": value if value.isalpha() and value not in ("nan", "inf") else float(value)
    }
    with nptdms.TdmsWriter(path) as writer:
        writer.write_segment(
            [nptdms.ChannelObject("x", name, np.arange(100.0), step) for name in "Fa"]
        )


def as_uff(path: Path, value: str) -> None:
    pytest.importorskip("pyuff")
    waves = [Wave(name, "force", "N", Held(np.arange(100.0)), 1000.0) for name in "Fa"]
    write_uff58(path, "x", waves)
    path.write_text(path.read_text().replace("  1.00000e-03", f"{float(value):13.5e}"))


class Held:
    """Samples in memory."""

    def __init__(self, values: np.ndarray) -> None:
        self.values, self.size = values, values.size

    def chunks(self, length: int = 64) -> Iterator[np.ndarray]:
        yield from (self.values[start : start + length] for start in range(0, self.size, length))

    def samples(self) -> np.ndarray:
        return self.values


ABSURD = ("0", "-1", "1e-12", "1e12", "nan", "inf")
RATES: dict[str, tuple[str, Callable[[Path, str], None], tuple[str, ...]]] = {
    "sep005": (
        "x.npz",
        as_npz,
        (
            "0",
            "-1",
            "NaN",
            "Infinity",
            "-Infinity",
            "1e999",
            "1e12",
            '"x"',
            "null",
            "true",
            "[]",
            "{}",
            LONG,
        ),
    ),
    "mat": ("x.mat", as_mat, ABSURD),
    "tdms": ("x.tdms", as_tdms, ("-1", "1e-12", "1e12", "nan", "inf", "text")),
    "uff58": ("x.uff", as_uff, ABSURD),
}


@pytest.mark.parametrize("kind", RATES)
def test_a_rate_that_is_none_is_a_sentence(tmp_path: Path, kind: str) -> None:
    name, make, values = RATES[kind]
    first = "x/F" if kind == "tdms" else "F"
    for value in values:
        make(tmp_path / name, value)
        with pytest.raises(FormatError, match=r"fs|rate|wf_increment|reading data-set") as caught:
            read_columns(tmp_path / name, kind, [first, first.replace("F", "a")])
        assert re.search("expected|cannot be read", str(caught.value))
        assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize(
    "value", ["0", "-1", "nan", ".nan", ".inf", "-.inf", "1e999", "x", "[]", "true", LONG]
)
@pytest.mark.parametrize(
    "field", ["rate", "frequency", "settle", "length", "condition: {density", "force: {noise"]
)
def test_a_number_of_a_mapping_that_is_none_is_a_sentence(
    tmp_path: Path, field: str, value: str
) -> None:
    if (field, value) in (("settle", "0"), ("force: {noise", "0")):
        return
    head = "schema: rig/map/1\nname: x\nacceleration: {channel: a}\n"
    force = "" if field.startswith("force") else "force: {channel: F}\n"
    close = ", channel: F}" if field.startswith("force") else "}" if "{" in field else ""
    (tmp_path / "map.yaml").write_text(f"{head}{force}{field}: {value}{close}\n")
    with pytest.raises(InputError) as caught:
        read_mapping(tmp_path / "map.yaml")
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("value", ["0", "-1", "NaN", "Infinity", "1e999", '"x"', "null", LONG])
def test_a_rate_beside_an_export_that_is_none_is_a_sentence(tmp_path: Path, value: str) -> None:
    (tmp_path / "r.csv.json").write_text('{"schema": "rig/export/1", "rate": %s}' % value)  # noqa: UP031
    with pytest.raises(FormatError, match="rate"):
        read_sidecar(tmp_path / "r.csv", "")


@pytest.mark.parametrize("value", ["0", "-1", "NaN", "Infinity", "1e300", '"x"', "[]", LONG])
@pytest.mark.parametrize("owner", ["session", "run"])
def test_a_rate_of_a_session_that_is_none_is_a_sentence(
    session: Path, tmp_path: Path, owner: str, value: str
) -> None:
    path = tmp_path / "theirs.h5"
    path.write_bytes((session / "session.h5").read_bytes())
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        if owner == "run":
            runs = json.loads(file["session/runs"][()])
            runs[0]["rate"] = "HERE"
            del file["session/runs"]
            file["session/runs"] = np.array(json.dumps(runs).replace('"HERE"', value).encode())
        else:
            odd = {'"x"': np.array(b"x"), "[]": np.array([1.0, 2.0]), LONG: 1e307}
            file["session"].attrs["rate"] = odd[value] if value in odd else float(json.loads(value))
    with pytest.raises(SessionError, match="rate"):
        open_session(path)


# Bombs


ZEROS = np.zeros(2**18)


def zip_bomb(path: Path) -> None:
    np.savez_compressed(path, channels=np.array('[{"name": "F", "fs": 1000.0}]'), data_0=ZEROS)


def mat_bomb(path: Path) -> None:
    scipy.io.savemat(path, {"F": ZEROS}, do_compression=True)


def h5_bomb(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file.create_dataset("F", data=ZEROS, compression="gzip", chunks=True)


def mat73_bomb(path: Path) -> None:
    with h5py.File(path, "w", userblock_size=512) as file:
        file.create_dataset("F", data=ZEROS, compression="gzip", chunks=True)
    with path.open("r+b") as head:
        head.write(b"MATLAB 7.3 MAT-file")


def chunk_bomb(path: Path) -> None:
    """One value, in a chunk of two million."""
    with h5py.File(path, "w") as file:
        file.create_dataset(
            "F", data=ZEROS[:1], maxshape=(None,), compression="gzip", chunks=(2**18,)
        )


BOMBS = {"npz": ("sep005", zip_bomb), "mat": ("mat", mat_bomb), "h5": ("hdf5", h5_bomb), "73.mat": ("mat", mat73_bomb),
         "chunk.h5": ("hdf5", chunk_bomb)}  # fmt: skip


@pytest.mark.parametrize("name", BOMBS)
def test_a_file_that_unpacks_to_far_more_than_a_record_does_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """2 MiB of zeros in some kB, the floor lowered below them; at the floor as it is they are
    welcome.
    """
    kind, make = BOMBS[name]
    path = tmp_path / f"x.{name}"
    make(path)
    assert not read_columns(path, kind, ["F"])["F"].samples.any()
    for module in (daq.expansion, sys.modules["daq.formats.reading"]):
        monkeypatch.setattr(module, "ALWAYS", 2**18)
    with pytest.raises(FormatError, match="would unpack from"):
        read_columns(path, kind, ["F"])


@pytest.mark.parametrize("name", ["npz", "mat", "h5"])
def test_a_measurement_packs_less_than_the_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """Sixteen bits of a sine with two of noise pack to a third or so: welcome at any size, so
    without a floor too.
    """
    noise = np.random.default_rng(1).integers(0, 4, ZEROS.size)
    record = np.round(20000 * np.sin(0.01 * np.arange(ZEROS.size))) + noise
    monkeypatch.setattr(sys.modules[__name__], "ZEROS", record)
    for module in (daq.expansion, sys.modules["daq.formats.reading"]):
        monkeypatch.setattr(module, "ALWAYS", 0)
    kind, make = BOMBS[name]
    make(tmp_path / f"x.{name}")
    assert np.array_equal(read_columns(tmp_path / f"x.{name}", kind, ["F"])["F"].samples, record)


def test_a_packed_csv_is_no_csv(tmp_path: Path) -> None:
    import gzip

    (tmp_path / "x.csv.gz").write_bytes(gzip.compress(b"F,a\n" + b"0,0\n" * 2**18))
    with pytest.raises(FormatError):
        read_columns(tmp_path / "x.csv.gz", "csv", ["F"])


class Streamed:
    """Chunks of which two at most are there when the next is asked for."""

    size = 40 * 1024

    def chunks(self, length: int = 1024) -> Iterator[np.ndarray]:
        given: list[weakref.ref[np.ndarray]] = []
        length = min(length, 1024)
        for start in range(0, self.size, length):
            chunk = start + np.arange(float(length))
            given.append(weakref.ref(chunk))
            yield chunk
            del chunk
            assert (
                sum(one() is not None for one in given) <= 2
            )  # one is written, one is in zip's own hands

    def samples(self) -> np.ndarray:
        raise AssertionError("all samples at once")


def test_csv_and_uff58_are_written_bit_by_bit(tmp_path: Path) -> None:
    waves = [
        Wave("F", "force", "N", Streamed(), 1000.0),
        Wave("a", "acceleration", "m/s^2", Streamed(), 1000.0),
    ]
    write_csv(tmp_path / "x.csv", waves)
    assert np.array_equal(
        np.loadtxt(tmp_path / "x.csv", skiprows=1, delimiter=",")[:, 1], np.arange(Streamed.size)
    )
    write_uff58(tmp_path / "x.uff", "x", waves)
