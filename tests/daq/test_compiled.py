"""Kernels kept on disk are loaded without numba's compiler, and give what compiled ones give."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

KERNEL = """
import math
import numpy as np
from daq.compiled import njit

@njit(cache=True)
def means(x, pairs):
    found = np.zeros((2, x.shape[0]))
    for k in range(x.shape[0]):
        found[0, k] = math.sin(x[k]) ** 3
        found[1, k] = x[: k + 1].max() if pairs else x[k] // 0.3
    return found
"""

CALL = """
import sys
import numpy as np
from kernel import means
for pairs in (True, False):
    print(means(np.linspace(0.1, 2.0, 7), pairs).tolist())
print(means.stats.cache_hits == {}, "numba.core.inline_closurecall" in sys.modules, file=sys.stderr)
"""


def called(folder: Path, text: str, cache: Path | None = None) -> tuple[str, str]:
    environment = {**os.environ, "PYTHONPATH": f"{folder}{os.pathsep}{ROOT}"}
    if cache is not None:
        environment["NUMBA_CACHE_DIR"] = str(cache)
    done = subprocess.run(
        [sys.executable, "-c", text], env=environment, check=True, capture_output=True, text=True
    )
    return done.stdout, done.stderr.strip()


def test_a_kept_kernel_gives_the_same_and_needs_no_compiler(tmp_path: Path) -> None:
    """The compiler's own module is imported in the process that compiles, in no other."""
    (tmp_path / "kernel.py").write_text(KERNEL, encoding="utf-8")
    compiled, how = called(tmp_path, CALL, tmp_path / "kept")
    kept, later = called(tmp_path, CALL, tmp_path / "kept")
    assert how == "True True"
    assert later == "False False"
    assert kept == compiled
    assert len(kept.splitlines()) == 2


def test_a_second_signature_is_compiled_after_the_first_was_loaded(tmp_path: Path) -> None:
    """The compiler is ready when it is needed, however late."""
    (tmp_path / "kernel.py").write_text(KERNEL, encoding="utf-8")
    single = CALL.replace("np.linspace(0.1, 2.0, 7)", "np.linspace(0.1, 2.0, 7).astype(np.float32)")
    called(tmp_path, CALL, tmp_path / "kept")
    both, _ = called(tmp_path, CALL + single, tmp_path / "kept")
    alone, _ = called(tmp_path, single, tmp_path / "other")
    assert both.endswith(alone)


def test_a_cache_that_fails_is_asked_in_numbas_own_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the short way raises, the whole preparation is made, as numba would."""
    from numba.core.cpu import CPUContext
    from numba.core.registry import cpu_target

    from daq.compiled import _looks_first

    context, made = cpu_target.target_context, []
    monkeypatch.setattr(CPUContext, "refresh", lambda self: made.append(self))

    def load(_cache: object, signature: object, given: CPUContext) -> str:
        given.refresh()
        if not made:
            raise KeyError(signature)
        return "loaded"

    assert _looks_first(load)(None, "f8(f8)", context) == "loaded"
    assert made == [context]


RUN = """
import sys
from rig.cli.app import app
try:
    app(["run", "fill_rate", "--set", "repeats=2", "--set", "acquire.record=4 cycles",
         "--vary", "scene.grains.fill=[0, 0.5]", "--workers", "2", "--out", sys.argv[1]])
except SystemExit:
    pass
print("loaded:", *sorted({"scipy.linalg", "numba.core.inline_closurecall"} & set(sys.modules)), file=sys.stderr)
"""


def test_a_run_and_its_report_load_no_compiler_and_no_linear_algebra(tmp_path: Path) -> None:
    """Kernels that call np.sum, np.append and their like would load scipy.linalg at each start."""
    for number in range(2):
        text = RUN.replace("sys.argv[1]", repr(str(tmp_path / str(number))))
        _, said = called(tmp_path, text)
    assert said.splitlines()[-1].strip() == "loaded:"
