"""Session files of others, damaged or made to harm: a clear word or a right result, never a
traceback.
"""

import os
import subprocess
import sys
from collections import Counter
from pathlib import Path

import h5py
import numpy as np
import pytest
from small_protocol import SMALL, Rig

from rig.campaign.resolve import campaign_of
from rig.campaign.runner import run
from rig.catalog.rig_file import load_rig
from rig.protocol.load import load_protocol

DAQ_TESTS = Path(__file__).parent.parent / "daq"
SETS = ("vary={scene.bed: [layers, locked]}", "acquire.settle=2", "acquire.record=6")


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two conditions, two repeats, a few cycles."""
    out = tmp_path_factory.mktemp("foreign")
    protocol = load_protocol(SMALL, sets=SETS)
    run(campaign_of(protocol, load_rig(protocol.rig), SMALL), out, workers=1)
    return out / "session.h5"


def outcomes(session: Path, folder: Path, seeds: range) -> dict[int, str]:
    """How reading the mutations went, by seed."""
    sys.path.insert(0, str(DAQ_TESTS))
    from session_mutations import mutated

    paths = {seed: folder / f"{seed}.h5" for seed in seeds}
    for seed, path in paths.items():
        mutated(session, path, seed)
    command = [
        sys.executable,
        str(DAQ_TESTS / "read_everything.py"),
        str(session),
        *map(str, paths.values()),
    ]
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=3000, env=environment, check=True
    )
    found = dict(line.split("\t", 1) for line in done.stdout.splitlines())
    for path in paths.values():
        path.unlink()
    return {seed: found[str(path)] for seed, path in paths.items()}


def check(found: dict[int, str]) -> Counter[str]:
    traces = {seed: text for seed, text in found.items() if text.startswith("TRACE")}
    assert traces == {}
    return Counter(found.values())


def test_forty_mutated_files(session: Path, tmp_path: Path) -> None:
    kinds = check(outcomes(session, tmp_path, range(40)))
    assert kinds["read"] > 4  # samples and free text may change without making a file wrong
    assert kinds["refused"] > 12


@pytest.mark.slow
def test_a_thousand_mutated_files(session: Path, tmp_path: Path) -> None:
    """A few make the HDF5 library itself crash or hang: there the process ends, which the command
    line turns into a sentence (the tests of the watch)."""
    kinds: Counter[str] = Counter()
    for first in range(1000, 2000, 100):
        kinds += check(outcomes(session, tmp_path, range(first, first + 100)))
    assert sum(kinds.values()) == 1000
    assert sum(count for kind, count in kinds.items() if kind.startswith("signal")) <= 20


@pytest.mark.parametrize(
    "kind", ["external link", "soft link", "external bytes", "filter", "newer schema", "huge"]
)
def test_what_a_foreign_file_may_not_do(
    rig_command: Rig, session: Path, tmp_path: Path, kind: str
) -> None:
    path = tmp_path / "theirs.h5"
    path.write_bytes(session.read_bytes())
    name = "run_0001/data/force"
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        codes = file[name][()]
        if kind == "newer schema":
            file.attrs["schema"] = "rig/session/2"
        else:
            del file[name]
        if kind == "external link":
            file[name] = h5py.ExternalLink(str(session), name)
        elif kind == "soft link":
            file[name] = h5py.SoftLink("/run_0002/data/force")
        elif kind == "external bytes":
            secret = tmp_path / "secret"
            secret.write_bytes(codes.tobytes())
            file.create_dataset(
                name, shape=codes.shape, dtype="<i4", external=[(str(secret), 0, codes.nbytes)]
            )
        elif kind == "filter":
            file.create_dataset(name, data=codes, compression="lzf")
        elif kind == "huge":
            file.create_dataset(name, shape=(2**44,), dtype="<i4", chunks=(2**14,))
    words = {
        "external link": "run_0001/data/force is missing",
        "soft link": "run_0001/data/force is missing",
        "external bytes": "in another file",
        "filter": "packed by a filter",
        "newer schema": "newer version",
        "huge": "more than the file holds",
    }
    for command in ("report", "replay"):
        done = rig_command(command, path)
        assert done.returncode == 2
        assert words[kind] in done.stderr
        assert "Traceback" not in done.stderr


def test_gzip_and_shuffle_are_read(rig_command: Rig, session: Path, tmp_path: Path) -> None:
    path = tmp_path / "packed.h5"
    path.write_bytes(session.read_bytes())
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        for info in [name for name in file if name != "session"]:
            for channel in ("force", "acceleration"):
                codes, attributes = (
                    file[f"{info}/data/{channel}"][()],
                    dict(file[f"{info}/data/{channel}"].attrs),
                )
                del file[f"{info}/data/{channel}"]
                packed = file.create_dataset(
                    f"{info}/data/{channel}", data=codes, compression="gzip", shuffle=True
                )
                packed.attrs.update(attributes)
    assert rig_command("report", path, "--out", tmp_path / "o").returncode in (0, 1)
    assert (tmp_path / "o" / "report.json").read_bytes() == (
        session.parent / "report.json"
    ).read_bytes()


def test_the_validator_lists_everything_at_once(
    rig_command: Rig, session: Path, tmp_path: Path
) -> None:
    assert rig_command("info", "--validate", session).returncode == 0
    path = tmp_path / "theirs.h5"
    path.write_bytes(session.read_bytes())
    with h5py.File(path, "r+", libver=("v110", "v110")) as file:
        file["run_0001/data/force"].attrs["units"] = "kN"
        del file["run_0002"].attrs["t0"]
        rows = file["run_0003/blocks"][()]
        rows["start"][1] += 3
        file["run_0003/blocks"][...] = rows
        del file["session/prediction"]
        file["session"].create_dataset(
            "prediction", data=np.array(b'{"conditions": {"c01": {"W_T": [1.0]}}}')
        )
    done = rig_command("info", "--validate", path)
    assert done.returncode == 1
    for words in ("units is 'kN', expected 'N'", "run_0002 has no attribute t0", "do not follow each other",
                  "prediction.conditions.c01.acceleration is missing", "4 deviations"):  # fmt: skip
        assert words in done.stdout


WATCHED = """
import os, signal, sys, time
from pathlib import Path
from rig.cli.terminal.watch import go_on_watched
from daq.session.time_limit import limited
go_on_watched(Path("theirs.h5"))
print("child", flush=True)
{then}
"""


@pytest.mark.parametrize(
    ("then", "code", "words"),
    [
        ("sys.exit(1)", 1, ""),
        (
            "os.kill(os.getpid(), signal.SIGSEGV)",
            2,
            "theirs.h5: damaged: the HDF5 library crashed on it (SIGSEGV)",
        ),
        (
            "with limited(0.05): time.sleep(20)",
            2,
            "theirs.h5: damaged: the HDF5 library hung on it",
        ),
        ("os.kill(os.getpid(), signal.SIGKILL)", 3, "ended from outside"),
    ],
)
@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes by fork here")
def test_a_crash_or_a_hang_becomes_a_sentence(then: str, code: int, words: str) -> None:
    command = [sys.executable, "-c", WATCHED.format(then=then)]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=60,
        cwd=Path(__file__).parents[2],
        check=False,
    )
    assert done.returncode == code
    assert done.stdout == "child\n"
    assert words in done.stderr
