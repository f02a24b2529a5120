"""Files are whole or the old ones, and nothing is written through a link."""

import itertools
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from daq.whole_files import UNFINISHED, unfinished, whole_file, write_folder, write_whole

OLD = {"a.csv": "old a", "figures/b.svg": "old b", "report.json": "old json"}
NEW = {"a.csv": "new a" * 1000, "figures/b.svg": "new b", "report.json": "x" * 100_000}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    write_folder(tmp_path / "out", OLD)
    return tmp_path / "out"


def contents(folder: Path) -> dict[str, str]:
    found = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_text() for path in found}


def test_all_files_are_replaced_and_nothing_is_left_beside_them(folder: Path) -> None:
    assert [path.name for path in write_folder(folder, NEW)] == ["a.csv", "b.svg", "report.json"]
    assert contents(folder) == NEW


def test_a_full_disk_leaves_every_old_file(folder: Path) -> None:
    """A limit on the size of files stands for the disk: the third file does not fit, the first two
    would.
    """
    program = (
        "import json, resource, signal, sys; from pathlib import Path; from daq.whole_files import write_folder\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN); resource.setrlimit(resource.RLIMIT_FSIZE, (50_000,) * 2)\n"
        "try: write_folder(Path(sys.argv[1]), json.loads(sys.argv[2]))\n"
        "except OSError: sys.exit(7)"
    )
    done = subprocess.run([sys.executable, "-c", program, str(folder), json.dumps(NEW)], timeout=60)
    assert done.returncode == 7
    assert contents(folder) == OLD


@pytest.mark.parametrize("kills_at", range(4))  # the first move is the note's own
def test_a_kill_between_the_moves_leaves_whole_files_and_the_old_last_one(
    folder: Path, monkeypatch: pytest.MonkeyPatch, kills_at: int
) -> None:
    moves: list[object] = []
    move: Callable[..., None] = os.replace

    def replace(part: Path, path: Path) -> None:
        if len(moves) == kills_at:
            raise KeyboardInterrupt
        moves.append(path)
        move(part, path)

    monkeypatch.setattr(os, "replace", replace)
    with pytest.raises(KeyboardInterrupt):
        write_folder(folder, NEW)
    assert unfinished(folder) == (kills_at > 0)
    found = contents(folder)
    assert set(found) == {*OLD, *((UNFINISHED,) if kills_at else ())}
    assert all(found[name] in (OLD[name], NEW[name]) for name in OLD)
    assert found["report.json"] == OLD["report.json"]
    monkeypatch.undo()
    write_folder(folder, NEW)
    assert contents(folder) == NEW


def killed_at(step: int, work: Callable[[], object]) -> bool:
    """Do the work in a process that SIGKILL ends before its `step`-th change of a file system;
    whether it did end.
    """
    child = os.fork()
    if not child:
        left = step

        def count(event: str, values: tuple[object, ...]) -> None:
            nonlocal left
            writes = (
                event == "open"
                and isinstance(values[2], int)
                and values[2] & (os.O_WRONLY | os.O_RDWR)
            )
            if writes or event in ("os.rename", "os.remove", "os.mkdir"):
                left -= 1
                if left < 0:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.addaudithook(count)
        work()
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL


@pytest.mark.skipif(not hasattr(os, "fork"), reason="kills a forked process")
def test_a_kill_at_any_step_leaves_the_old_files_the_new_ones_or_the_note(folder: Path) -> None:
    """Every opening for writing, move, removal and new folder is a step."""
    ends: list[str] = []
    for step in itertools.count():
        write_folder(folder, OLD)
        killed = killed_at(step, lambda: write_folder(folder, NEW))
        found = {
            name: text for name, text in contents(folder).items() if not name.endswith(".part")
        }
        marked = found.pop(UNFINISHED, None) is not None
        ends.append("old" if found == OLD else "new" if found == NEW else "mixed")
        assert marked or ends[-1] != "mixed"
        assert all(found[name] in (OLD[name], NEW[name]) for name in OLD)
        if not killed:
            break
    assert ends[-1] == "new"
    assert not marked
    assert ends.count("mixed") == len(NEW) - 1  # before every move but the first


@pytest.mark.parametrize("name", sorted(OLD))
@pytest.mark.parametrize("dangling", [False, True])
def test_a_link_in_the_place_of_a_file_is_replaced_not_followed(
    folder: Path, name: str, dangling: bool
) -> None:
    victim = folder.parent / "victim"
    if not dangling:
        victim.write_text("precious")
    (folder / name).unlink()
    (folder / name).symlink_to(victim)
    write_folder(folder, NEW)
    assert contents(folder) == NEW
    assert not (folder / name).is_symlink()
    assert victim.exists() is not dangling
    if not dangling:
        assert victim.read_text() == "precious"
    write_whole(folder / name, "again")
    assert (folder / name).read_text() == "again"


def test_a_folder_that_is_a_link_is_refused(folder: Path) -> None:
    elsewhere = folder.parent / "elsewhere"
    elsewhere.mkdir()
    (folder / "figures" / "b.svg").unlink()
    (folder / "figures").rmdir()
    (folder / "figures").symlink_to(elsewhere)
    with pytest.raises(OSError, match="symbolic link"):
        write_folder(folder, NEW)
    assert list(elsewhere.iterdir()) == []
    assert (folder / "report.json").read_text() == OLD["report.json"]


def test_a_pipe_in_the_place_of_a_file_is_not_replaced(folder: Path) -> None:
    (folder / "a.csv").unlink()
    os.mkfifo(folder / "a.csv")
    with pytest.raises(OSError, match="a pipe, which is not replaced"):
        write_folder(folder, NEW)
    with pytest.raises(OSError, match="a pipe"):
        write_whole(folder / "a.csv", "x")
    assert (folder / "a.csv").is_fifo()
    assert (folder / "report.json").read_text() == OLD["report.json"]


def test_the_mode_is_that_of_any_new_file(tmp_path: Path) -> None:
    (tmp_path / "plain").write_text("x")
    write_whole(tmp_path / "ours", "x")
    assert (tmp_path / "ours").stat().st_mode == (tmp_path / "plain").stat().st_mode


def test_a_failure_inside_the_block_leaves_the_old_file(tmp_path: Path) -> None:
    (tmp_path / "x").write_text("old")
    with pytest.raises(TypeError), whole_file(tmp_path / "x") as file:
        file.writelines([b"half", None])
    assert contents(tmp_path) == {"x": "old"}
