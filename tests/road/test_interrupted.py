"""Ctrl-C: a clean stop with exit code 3, a session that goes on where it stopped, and the same
report at the end.
"""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from small_protocol import Rig

COMMAND = (
    sys.executable,
    "-c",
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); from rig.cli.app import main; main()",
)
"""As from a terminal: a shell's background job, as the tests may be one, inherits an ignored
SIGINT.
"""


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="needs process groups")
def test_ctrl_c_stops_cleanly_and_the_session_goes_on(
    tmp_path: Path, small: Path, rig_command: Rig
) -> None:
    """The terminal sends SIGINT to every process of the group: here as soon as a tenth of the runs
    is said to be done, in a campaign that is held to ten times real time (a quarter of a second a
    run)."""
    stopped, whole = tmp_path / "stopped", tmp_path / "whole"
    words = ("run", str(small), "--out", str(stopped), "--speed", "10")
    with subprocess.Popen(
        [*COMMAND, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        assert process.stderr is not None
        first = next(line for line in process.stderr if not line.startswith("compiling"))
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=120)
    assert first.endswith("of 18 runs\n")
    assert process.returncode == 3, err
    assert (
        err.splitlines()[-1]
        == "rig: interrupted; what was recorded is kept, rig run --resume goes on"
    )
    assert "Traceback" not in err
    assert not (stopped / "report.json").exists()
    assert "complete: False" in rig_command("info", stopped).stdout

    assert rig_command("run", small, "--out", stopped).returncode == 2  # not without --resume
    resumed = rig_command("run", small, "--out", stopped, "--resume")
    assert resumed.returncode == rig_command("run", small, "--out", whole).returncode
    assert (stopped / "report.json").read_bytes() == (whole / "report.json").read_bytes()
    assert "complete: True" in rig_command("info", stopped).stdout
    assert out == ""
