"""Kills, full disks, folders that go: what was recorded stays, the word is clear, and resuming ends
where it should.
"""

import os
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from small_protocol import SMALL, Rig

from daq import open_session

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="kills and limits of other processes"
)


def kills(folder: Path, count: int, seed: int) -> list[str]:
    program = Path(__file__).parent / "kill_and_resume.py"
    command = [sys.executable, str(program), str(folder), str(count), str(seed)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join((str(ROOT), str(program.parent)))}
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=60 + 40 * count,
        env=environment,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert [line for line in lines if line.startswith("BAD")] == []
    assert len(lines) == count
    return lines


def test_three_kills(tmp_path: Path) -> None:
    kills(tmp_path, 3, 2)


@pytest.mark.slow
def test_a_hundred_kills(tmp_path: Path) -> None:
    lines = kills(tmp_path, 100, 1)
    assert (
        sum("no file yet" not in line for line in lines) > 30
    )  # most of them hit the recording itself


@contextmanager
def recording(folder: Path, out: Path) -> Iterator[subprocess.Popen[str]]:
    """`rig run` in a process of its own, once its session has its first samples; paced, so that
    there is time.
    """
    (folder / "p.yaml").write_text(SMALL)
    fewer = ("--set", "vary={}", "--set", "scene.bed=locked", "--set", "repeats.n=3", "--set", "acquire.settle=4",
             "--set", "acquire.record=400")  # fmt: skip
    words = ["run", str(folder / "p.yaml"), "--out", str(out), "--speed", "20", *fewer]
    command = [sys.executable, "-c", "from rig.cli.app import main; main()", *words]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT
    )
    try:
        for _ in range(600):
            assert process.poll() is None, process.communicate()
            if (out / "session.h5").exists() and samples(out / "session.h5"):
                break
            time.sleep(0.05)
        yield process
    finally:
        process.kill()
        process.communicate()


def samples(path: Path) -> int:
    with open_session(path) as record:
        return sum(info.samples for info in record.runs)


def test_a_second_process_reads_while_it_is_written(tmp_path: Path) -> None:
    with recording(tmp_path, tmp_path / "o") as process:
        seen = [samples(tmp_path / "o" / "session.h5")]
        for _ in range(200):
            time.sleep(0.05)
            seen.append(samples(tmp_path / "o" / "session.h5"))
            if len(set(seen)) > 3:
                break
        assert process.poll() is None
    assert seen == sorted(seen)
    assert len(set(seen)) > 3


def test_a_full_disk_stops_with_three_and_keeps_what_was_there(
    rig_command: Rig, tmp_path: Path
) -> None:
    """The kernel refuses every write beyond a limit set under way: the same failed call as on a
    full disk.
    """
    out = tmp_path / "o"
    with recording(tmp_path, out) as process:
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (4096, 4096))
        _, said = process.communicate(timeout=60)
    assert process.returncode == 3, said
    assert f"cannot write to {out / 'session.h5'}" in said
    assert "Traceback" not in said
    assert samples(out / "session.h5") > 0
    fewer = ("--set", "vary={}", "--set", "scene.bed=locked", "--set", "repeats.n=3", "--set", "acquire.settle=4",
             "--set", "acquire.record=400")  # fmt: skip
    done = rig_command("run", tmp_path / "p.yaml", "--out", out, "--resume", *fewer)
    assert done.returncode in (0, 1), done.stderr
    whole = rig_command("run", tmp_path / "p.yaml", "--out", tmp_path / "whole", *fewer)
    assert whole.returncode == done.returncode
    assert (out / "report.json").read_bytes() == (tmp_path / "whole" / "report.json").read_bytes()
    with (
        open_session(out / "session.h5") as a,
        open_session(tmp_path / "whole" / "session.h5") as b,
    ):
        for info in b.runs:
            np.testing.assert_array_equal(a.codes(info.name, "force"), b.codes(info.name, "force"))


@pytest.mark.parametrize("how", ["removed", "renamed"])
def test_a_folder_that_disappears_ends_with_code_3(tmp_path: Path, how: str) -> None:
    out = tmp_path / "o"
    with recording(tmp_path, out) as process:
        if how == "removed":
            shutil.rmtree(out)
        else:
            out.rename(tmp_path / "elsewhere")
        _, said = process.communicate(timeout=120)
    assert process.returncode == 3, said
    assert "has gone while it was written" in said
    assert "Traceback" not in said
    assert not out.exists()
    if how == "renamed":
        assert samples(tmp_path / "elsewhere" / "session.h5") > 0


@pytest.mark.skipif(os.geteuid() == 0, reason="root writes anywhere")
def test_a_folder_that_cannot_be_written_is_refused_before_anything_runs(
    rig_command: Rig, tmp_path: Path
) -> None:
    (tmp_path / "p.yaml").write_text(SMALL)
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o555)
    done = rig_command("run", tmp_path / "p.yaml", "--out", closed / "o")
    assert done.returncode == 2
    assert "cannot be written" in done.stderr
    assert list(closed.iterdir()) == []


def test_no_room_for_the_session_ends_with_code_3(small: Path, tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-c",
        "from rig.cli.app import main; main()",
        "run",
        str(small),
        "--out",
        str(tmp_path / "o"),
    ]

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (65536, 65536))

    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=120,
        cwd=ROOT,
        preexec_fn=limit,
        check=False,
    )
    assert done.returncode == 3, done.stderr
    assert "cannot create the session" in done.stderr
    assert "Traceback" not in done.stderr
    assert not (tmp_path / "o" / "session.h5").exists()
    assert list((tmp_path / "o").iterdir()) == []
