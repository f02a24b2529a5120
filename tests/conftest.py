"""Tests state laws and never time anything: no deadline, and the same examples in every run."""

import subprocess
import sys
import tempfile

import pytest
from hypothesis import settings

settings.register_profile("laws", deadline=None, derandomize=True)
settings.load_profile("laws")

QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
SHORT = (
    "--set",
    "repeats=1",
    "--set",
    "acquire.settle=2",
    "--set",
    "acquire.record=4",
    "--set",
    "expect=[]",
)
COMPILED_BY = (
    ("run", "single_mass_vertical", *SHORT),
    ("run", "fill_rate", *SHORT, "--set", "vary={scene.grains.fill: [0 %, 90 %]}"),
    ("run", "shaker_fill", *SHORT, "--set", "vary={scene.grains.fill: [0 %, 30 %]}"),
)
"""Commands that call most compiled functions; most of a minute where nothing is compiled yet, two
seconds later.
"""


def pytest_configure(config: pytest.Config) -> None:
    """Compile before xdist's workers start: each would compile the same for itself, and at the same
    time.
    """
    if config.getoption("numprocesses", None) and not hasattr(config, "workerinput"):
        rig = (sys.executable, "-c", "from rig.cli.app import main; main()")
        with tempfile.TemporaryDirectory() as folder:
            for process in [
                subprocess.Popen(
                    [*rig, *words, "--out", f"{folder}/{k}"], cwd=config.rootpath, **QUIET
                )
                for k, words in enumerate(COMPILED_BY)
            ]:
                process.wait()  # a failure is for the tests to tell
