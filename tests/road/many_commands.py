"""A program: runs command lines of `rig`, each in a child process of its own, and says how that
went.

Reads from standard input, a line each, JSON of {"words": [...], "stdout": path, "stderr": path},
the paths being where its output goes instead; answers each with a line of JSON, {"code", "out",
"err"}. The libraries are loaded once. A command that does not end is killed: code -9; an exception
that nobody caught: code 99.
"""

import atexit
import gc
import json
import os
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from typing import Any, NoReturn

import rig.cli.app

PATIENCE = 120
"""Seconds after which a command is taken to wait for ever."""

TRACE = 99


def end(call: Callable[[], None]) -> NoReturn:
    """Call, and end the process as an interpreter would."""
    code: Any = TRACE
    try:
        call()
    except SystemExit as ended:
        code = ended.code or 0
    except BaseException:  # noqa: BLE001  whatever comes out is what is asked for here
        with suppress(OSError):
            traceback.print_exc()
            sys.stderr.flush()
    os._exit(code)


def run(words: list[str], folder: Path, stdout: str = "", stderr: str = "") -> dict[str, Any]:
    """Run one command; its exit code and what it wrote."""
    files = [folder / "out", folder / "err"]
    for file in files:
        file.write_bytes(b"")
    child = os.fork()
    if not child:
        os.setpgid(0, 0)
        atexit._clear()  # what ends this program is not the command's to call
        for descriptor, place in enumerate((stdout or files[0], stderr or files[1]), start=1):
            os.dup2(os.open(place, os.O_WRONLY), descriptor)
        sys.argv = [
            "rig",
            *(os.fsdecode(word.encode("utf-8", "surrogateescape")) for word in words),
        ]
        end(rig.cli.app.main)
    signal.signal(signal.SIGALRM, lambda *_: os.killpg(child, signal.SIGKILL))
    signal.alarm(PATIENCE)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    signal.alarm(0)
    out, err = (file.read_bytes().decode("utf-8", "surrogateescape") for file in files)
    return {"code": code, "out": out, "err": err}


if __name__ == "__main__":
    commands = ("check", "exchange", "model", "replay", "run", "sessions")
    heavy = ("analysis.report.html", "rig.importing.to_session", "rig.cli.app")
    for module in (*heavy, *(f"rig.cli.commands.{name}" for name in commands)):
        import_module(module)
    gc.collect()
    gc.freeze()  # children share the pages of what is loaded
    with tempfile.TemporaryDirectory() as folder:
        for line in sys.stdin:
            print(json.dumps(run(folder=Path(folder), **json.loads(line))), flush=True)
