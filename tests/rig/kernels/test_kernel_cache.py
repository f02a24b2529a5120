"""Compiled code never outlives a change in a function that it calls."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from rig.kernels import drop_stale

CALLEE = "from numba import njit\n\n@njit(cache=True)\ndef inner():\n    return {value}\n"
CALLER = "from numba import njit\nfrom kernels.callee import inner\n\n@njit(cache=True)\ndef outer():\n    return inner()\n"
ASK = """
import sys
from pathlib import Path
from rig.kernels import drop_stale
if sys.argv[1] == "drop":
    drop_stale(Path("kernels"))
from kernels.caller import outer
print(outer())
"""


def answer(folder: Path, how: str) -> int:
    place = os.pathsep.join((str(folder), str(Path.cwd())))
    env = {**os.environ, "PYTHONPATH": place}
    command = [sys.executable, "-c", ASK, how]
    done = subprocess.run(
        command, cwd=folder, env=env, capture_output=True, text=True, check=True, timeout=120
    )
    return int(done.stdout)


def test_a_change_in_one_folder_reaches_what_is_compiled_in_another(tmp_path: Path) -> None:
    """Only indexes older than the youngest module go, wherever in the package both lie."""
    callee, older, newer = (
        tmp_path / "kernels" / name
        for name in ("rows/callee.py", "grains/__pycache__/a.nbi", "__pycache__/b.nbi")
    )
    for path, seconds in ((older, 100), (callee, 200), (newer, 300)):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        os.utime(path, (seconds, seconds))
    drop_stale(tmp_path / "kernels")
    assert (older.exists(), newer.exists()) == (False, True)


@pytest.mark.parametrize(("how", "after"), [("keep", 1), ("drop", 2)])
def test_a_changed_callee_is_compiled_anew(tmp_path: Path, how: str, after: int) -> None:
    """`keep` shows what numba does by itself: it answers with the code of before."""
    package = tmp_path / "kernels"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "caller.py").write_text(CALLER)
    (package / "callee.py").write_text(CALLEE.format(value=1))
    assert answer(tmp_path, how) == 1
    (package / "callee.py").write_text(CALLEE.format(value=2))
    assert answer(tmp_path, how) == after
    assert answer(tmp_path, how) == after


COMPILE = """
import sys
from numba import njit
from rig.cli.terminal.output import say_compiling
from rig.kernels.compiling import tell_of_compiling
tell_of_compiling(say_compiling)
from kernels.caller import outer
outer()
"""


def test_compiling_is_announced_once_and_loading_is_not(tmp_path: Path) -> None:
    package = tmp_path / "kernels"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "caller.py").write_text(CALLER.replace("inner.callee", "callee"))
    (package / "callee.py").write_text(CALLEE.format(value=1))
    env = {**os.environ, "PYTHONPATH": os.pathsep.join((str(tmp_path), str(Path.cwd())))}
    command = [sys.executable, "-c", COMPILE]
    said = [
        subprocess.run(
            command, cwd=tmp_path, env=env, capture_output=True, text=True, check=True, timeout=120
        )
        for _ in range(2)
    ]
    assert [done.stderr.count("compiling") for done in said] == [1, 0]
