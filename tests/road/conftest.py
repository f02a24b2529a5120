"""A small protocol and the command line, as a user has them."""

import subprocess
import sys
from pathlib import Path

import pytest
from small_protocol import SMALL, Rig


@pytest.fixture(scope="session")
def rig_command(tmp_path_factory: pytest.TempPathFactory) -> Rig:
    """The command `rig` in a process of its own, in an empty folder."""
    folder = tmp_path_factory.mktemp("work")

    def call(*words: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", "from rig.cli.app import main; main()", *map(str, words)]
        return subprocess.run(
            command, cwd=cwd or folder, capture_output=True, text=True, timeout=300, check=False
        )

    return call


@pytest.fixture(scope="session")
def small(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("protocols") / "small.yaml"
    path.write_text(SMALL)
    return path
