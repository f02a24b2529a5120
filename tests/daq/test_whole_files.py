"""Files are whole or the old ones, and nothing is written through a link."""

import json
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from daq.whole_files import whole_file, write_folder, write_whole

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
    """A limit on the size of files stands for the disk: the third file does not fit, the first two would."""
    program = (
        "import json, resource, signal, sys; from pathlib import Path; from daq.whole_files import write_folder\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN); resource.setrlimit(resource.RLIMIT_FSIZE, (50_000,) * 2)\n"
        "try: write_folder(Path(sys.argv[1]), json.loads(sys.argv[2]))\n"
        "except OSError: sys.exit(7)"
    )
    done = subprocess.run([sys.executable, "-c", program, str(folder), json.dumps(NEW)], timeout=60)
    assert done.returncode == 7
    assert contents(folder) == OLD


@pytest.mark.parametrize("kills_at", range(3))
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
    found = contents(folder)
    assert set(found) == set(OLD)
    assert all(found[name] in (OLD[name], NEW[name]) for name in OLD)
    assert found["report.json"] == OLD["report.json"]


@pytest.mark.parametrize("name", sorted(OLD))
@pytest.mark.parametrize("dangling", [False, True])
def test_a_link_in_the_place_of_a_file_is_replaced_not_followed(folder: Path, name: str, dangling: bool) -> None:
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
