"""An installation and a home that cannot be written: compiled code goes to a private temporary
folder.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from daq.caches import writable

ROOT = Path(__file__).parents[2]
NOWHERE = f"{os.devnull}/home"
"""Below a file: no folder can be made there, by root either."""


@pytest.fixture(scope="module")
def read_only(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the packages in which `__pycache__` cannot be made, by root either: files stand in
    their places.
    """
    folder = tmp_path_factory.mktemp("site")
    for package in ("daq", "analysis", "rig"):
        shutil.copytree(
            ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__")
        )
    for module in folder.rglob("*.py"):
        (module.parent / "__pycache__").touch()
    return folder


def start(place: Path, program: str, temporary: Path, **changes: str) -> subprocess.Popen[str]:
    names = ("HOME", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "NUMBA_CACHE_DIR", "MPLCONFIGDIR")
    env = {name: value for name, value in os.environ.items() if name not in names}
    env |= {
        "PYTHONPATH": str(place),
        "TMPDIR": str(temporary),
        "PYTHONDONTWRITEBYTECODE": "1",
        **changes,
    }
    return subprocess.Popen(
        [sys.executable, "-c", program],
        cwd=place,
        env=env,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )


def outcome(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    out, err = process.communicate(timeout=240)
    return process.returncode, out, err


USE = """
import rig, analysis.signals.compiled_loops, daq.chain.noise, rig.kernels.roots, matplotlib
matplotlib.get_configdir()
print("done")
"""


@pytest.mark.parametrize(
    "changes",
    [
        {"HOME": NOWHERE},
        {"HOME": "not/absolute"},
        {"HOME": NOWHERE, "NUMBA_CACHE_DIR": NOWHERE, "MPLCONFIGDIR": NOWHERE},
        {"XDG_CACHE_HOME": NOWHERE, "XDG_CONFIG_HOME": NOWHERE},
    ],
    ids=str,
)
def test_nothing_is_said_and_nothing_is_left_in_the_work_folder(
    read_only: Path, tmp_path: Path, changes: dict[str, str]
) -> None:
    before = sorted(read_only.rglob("*"))
    done = outcome(start(read_only, USE, tmp_path, **changes))
    assert done == (0, "done\n", "")
    assert sorted(read_only.rglob("*")) == before
    (kept,) = tmp_path.glob("particle-damper-rig-*")
    assert kept.stat().st_mode & 0o777 == 0o700


@pytest.mark.parametrize("package", ["daq", "analysis", "rig"])
def test_several_processes_share_one_folder(read_only: Path, tmp_path: Path, package: str) -> None:
    program = (
        f"import {package}, os; print(os.environ['NUMBA_CACHE_DIR'], os.environ['MPLCONFIGDIR'])"
    )
    processes = [start(read_only, program, tmp_path, HOME=NOWHERE) for _ in range(4)]
    results = [outcome(process) for process in processes]
    assert len(set(results)) == 1
    code, out, err = results[0]
    assert (code, err) == (0, "")
    assert all(Path(word).is_relative_to(tmp_path) for word in out.split())


@pytest.mark.parametrize("taken", ["open to others", "a link", "a file"])
def test_a_folder_that_others_could_fill_is_not_used(
    read_only: Path, tmp_path: Path, taken: str
) -> None:
    """numba unpickles what it finds."""
    name = tmp_path / f"particle-damper-rig-{os.getuid()}"
    if taken == "open to others":
        name.mkdir()
        name.chmod(0o777)
    elif taken == "a link":
        (tmp_path / "elsewhere").mkdir(mode=0o700)
        name.symlink_to(tmp_path / "elsewhere")
    else:
        name.touch()
    program = "import daq, os; print(os.environ['NUMBA_CACHE_DIR'])"
    code, out, err = outcome(start(read_only, program, tmp_path, HOME=NOWHERE))
    assert (code, err) == (0, "")
    assert not out.startswith(f"{name}/")
    assert [
        path.name for path in tmp_path.iterdir() if path.name.startswith("particle-damper-rig-")
    ] == [name.name]


def test_where_the_home_can_be_written_nothing_is_set(read_only: Path, tmp_path: Path) -> None:
    program = "import rig, os; print(sorted({'NUMBA_CACHE_DIR', 'MPLCONFIGDIR'} & set(os.environ)))"
    assert outcome(start(read_only, program, tmp_path, HOME=str(tmp_path))) == (0, "[]\n", "")
    assert list(tmp_path.iterdir()) == []


def test_another_version_has_a_folder_of_its_own(read_only: Path, tmp_path: Path) -> None:
    program = "import daq, os; print(os.environ['NUMBA_CACHE_DIR'])"
    first = outcome(start(read_only, program, tmp_path, HOME=NOWHERE))
    os.utime(read_only / "rig" / "kernels" / "roots.py", ns=(1, 1))
    assert outcome(start(read_only, program, tmp_path, HOME=NOWHERE)) != first


def test_writable_makes_nothing(tmp_path: Path) -> None:
    assert writable(tmp_path / "a" / "b")
    assert not writable(Path(NOWHERE))
    assert list(tmp_path.iterdir()) == []
