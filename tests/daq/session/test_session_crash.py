"""A session while it is written, after its writer was killed, and resumed. Writers are other
processes.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py
import numpy as np
import pytest
import session_plans as given

from daq import open_session
from daq.session.hdf5_flags import marked_open
from daq.session.plan import SessionError
from daq.session.writer import Recorder
from daq.session.writer_lock import is_locked

STEP = 4000
SCALARS = {"force_use": 0.5, "stroke_use": 0.25}

WRITER = """
import sys
sys.path.insert(0, sys.argv[2])
import session_plans as given
from daq.session.writer import Recorder
recorder = Recorder.create(sys.argv[1], given.plan())
print("created", flush=True)
for line in sys.stdin:
    run, start, stop = line.split()[0], *map(int, line.split()[1:])
    if stop > start:
        recorder.append(run, given.block(start, given.codes(seed=int(run[-1]))[:, start:stop]))
    else:
        recorder.finish(run, {"force_use": 0.5, "stroke_use": 0.25})
    print("done", flush=True)
recorder.close()
"""


class Writer:
    """A recorder in another process, driven line by line."""

    def __init__(self, path: Path) -> None:
        command = [sys.executable, "-c", WRITER, str(path), str(Path(__file__).parents[1])]
        self.process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self.heard("created")

    def heard(self, word: str) -> None:
        assert self.process.stdout is not None
        assert self.process.stdout.readline().strip() == word

    def do(self, run: str, start: int, stop: int) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{run} {start} {stop}\n")
        self.process.stdin.flush()
        self.heard("done")

    def kill(self) -> None:
        os.kill(self.process.pid, signal.SIGKILL)
        self.process.wait()


@contextmanager
def writing(path: Path) -> Iterator[Writer]:
    writer = Writer(path)
    try:
        yield writer
    finally:
        if writer.process.poll() is None:
            writer.kill()
        for stream in (writer.process.stdin, writer.process.stdout):
            assert stream is not None
            stream.close()


def test_readers_follow_a_live_writer(tmp_path: Path) -> None:
    path = tmp_path / "session.h5"
    with (
        writing(path) as writer,
        open_session(path) as record,
        h5py.File(path, "r", swmr=True) as plain,
    ):
        assert record.run("run_0001").samples == 0
        for start in range(0, given.SAMPLES, STEP):
            writer.do("run_0001", start, start + STEP)
            assert record.run("run_0001").samples == start + STEP
            np.testing.assert_array_equal(
                record.codes("run_0001", "force"), given.codes(seed=1)[0, : start + STEP]
            )
            plain["run_0001/data/force"].refresh()
            np.testing.assert_array_equal(
                plain["run_0001/data/force"][: start + STEP], given.codes(seed=1)[0, : start + STEP]
            )
        assert not record.run("run_0001").complete
        writer.do("run_0001", 0, 0)
        assert record.run("run_0001").complete
        assert record.scalars("run_0001") == SCALARS


def test_what_was_recorded_survives_a_kill_and_the_session_resumes(tmp_path: Path) -> None:
    path = tmp_path / "session.h5"
    with writing(path) as writer:
        writer.do("run_0002", 0, given.SAMPLES)
        writer.do("run_0002", 0, 0)
        writer.do("run_0001", 0, STEP)
        writer.kill()
    with open_session(path) as record, h5py.File(path, "r", swmr=True) as plain:
        assert [(run.samples, run.complete) for run in record.runs] == [
            (STEP, False),
            (given.SAMPLES, True),
            (0, False),
        ]
        np.testing.assert_array_equal(
            record.codes("run_0001", "force"), given.codes(seed=1)[0, :STEP]
        )
        np.testing.assert_array_equal(plain["run_0002/data/force"][:], given.codes(seed=2)[0])
    with Recorder.resume(path) as recorder:
        assert recorder.completed() == {"run_0002"}
        assert recorder.record().run("run_0001").samples == 0
        with pytest.raises(SessionError, match="complete already"):
            recorder.append("run_0002", given.block(0, given.codes()))
        for number, run in ((1, "run_0001"), (3, "run_0003")):
            recorder.append(run, given.block(0, given.codes(seed=number)))
            recorder.finish(run, SCALARS)
        assert recorder.record().complete
    with h5py.File(path, "r") as plain:
        for number in (1, 2, 3):
            np.testing.assert_array_equal(
                plain[f"run_000{number}/data/acceleration"][:], given.codes(seed=number)[1]
            )


def test_a_resumed_session_equals_one_that_was_never_stopped(tmp_path: Path) -> None:
    def finished(recorder: Recorder) -> None:
        for number in (1, 2, 3):
            run = f"run_000{number}"
            if run not in recorder.completed():
                recorder.append(run, given.block(0, given.codes(seed=number)))
                recorder.finish(run, SCALARS)

    with writing(tmp_path / "stopped.h5") as writer:
        writer.do("run_0001", 0, given.SAMPLES)
        writer.do("run_0001", 0, 0)
        writer.do("run_0002", 0, STEP)
        writer.kill()
    with Recorder.resume(tmp_path / "stopped.h5") as recorder:
        finished(recorder)
    with Recorder.create(tmp_path / "whole.h5", given.plan()) as recorder:
        finished(recorder)
    with (
        open_session(tmp_path / "stopped.h5") as stopped,
        open_session(tmp_path / "whole.h5") as whole,
    ):
        assert stopped.runs == whole.runs
        for run in whole.runs:
            np.testing.assert_array_equal(
                stopped.codes(run.name, "force"), whole.codes(run.name, "force")
            )
            np.testing.assert_array_equal(stopped.blocks(run.name), whole.blocks(run.name))


def test_there_is_one_writer_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "session.h5"
    with writing(path):
        with pytest.raises(SessionError, match="being written"):
            Recorder.resume(path)
        with pytest.raises(SessionError, match="being written"):
            Recorder.create(path, given.plan(), overwrite=True)
    Recorder.resume(path).close()
    with Recorder.resume(path), pytest.raises(SessionError, match="being written"):
        Recorder.resume(path)


def test_a_kill_while_creating_leaves_nothing_that_looks_like_a_session(tmp_path: Path) -> None:
    path = tmp_path / "session.h5"
    (tmp_path / "session.h5.part").write_bytes(b"what a killed writer left")
    with pytest.raises(SessionError, match="no session file"):
        open_session(path)
    with Recorder.create(path, given.plan()) as recorder:
        assert recorder.completed() == set()
    assert [entry.name for entry in tmp_path.iterdir()] == ["session.h5"]


def test_resuming_a_complete_session_changes_nothing(tmp_path: Path) -> None:
    path = tmp_path / "session.h5"
    with Recorder.create(path, given.plan()) as recorder:
        for run in ("run_0001", "run_0002", "run_0003"):
            recorder.append(run, given.block(0, given.codes()))
            recorder.finish(run, SCALARS)
    with Recorder.resume(path) as recorder:
        assert len(recorder.completed()) == 3
    with open_session(path) as record:
        assert record.complete
        assert record.run("run_0002").samples == given.SAMPLES


def read_all(path: Path) -> None:
    with open_session(path) as record:
        for run in record.runs:
            record.codes(run.name, "force")
            record.blocks(run.name)
        for name in record.documents:
            record.document(name)
        assert record.channels
        assert record.protocol_text


def test_a_killed_writers_file_that_is_damaged_too_is_refused_at_once(tmp_path: Path) -> None:
    """In the reader's side of the single-writer mode HDF5 would take the damage for a write and
    wait for its end.
    """
    path = tmp_path / "session.h5"
    with writing(path) as writer:
        writer.do("run_0001", 0, STEP)
        writer.kill()
    assert marked_open(path)
    data = bytearray(path.read_bytes())
    start = data.find(b"OHDR", 48)  # an object below the root
    data[start + 20] ^= 0xFF
    path.write_bytes(data)
    before = path.read_bytes()
    with pytest.raises(SessionError, match="damaged"):
        read_all(path)
    assert path.read_bytes() == before


def test_a_living_writer_is_distinguished_from_a_dead_one(tmp_path: Path) -> None:
    path = tmp_path / "session.h5"
    with writing(path) as writer:
        assert is_locked(path)
        writer.kill()
        assert not is_locked(path)
        assert (tmp_path / "session.h5.lock").exists()
    with Recorder.resume(path):
        assert is_locked(path)
    assert not is_locked(path)
