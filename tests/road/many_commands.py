"""A program: runs each command line named, in a child process of its own, and prints how that went.

Reads from standard input a JSON list of {"words": [...], "stdout": path or null, "stderr": path or null, "memory":
bytes or null}; prints a JSON list of {"code", "out", "err"}, what a path swallowed left out. The libraries are loaded
once, before the first.
"""

import json
import os
import resource
import sys
import tempfile
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

import rig.cli


TRACE = 99


def end(call: Callable[[], None]) -> NoReturn:
    """Call, and end the process as an interpreter would."""
    code: Any = 1
    try:
        call()
    except SystemExit as ended:
        code = ended.code or 0
    except BaseException:  # noqa: BLE001  whatever comes out is what is asked for here
        code = TRACE
        with suppress(OSError):
            traceback.print_exc()
            sys.stderr.flush()
    os._exit(code)


def run(job: dict[str, Any], folder: Path) -> dict[str, Any]:
    places = {1: job.get("stdout") or folder / "out", 2: job.get("stderr") or folder / "err"}
    child = os.fork()
    if not child:
        for descriptor, place in places.items():
            opened = os.open(place, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
            os.dup2(opened, descriptor)
            os.close(opened)
        if job.get("memory"):
            resource.setrlimit(resource.RLIMIT_AS, (job["memory"],) * 2)
        sys.argv = ["rig", *(os.fsdecode(word.encode("utf-8", "surrogateescape")) for word in job["words"])]
        end(rig.cli.main)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    texts = [
        "" if name in job and job[name] else (folder / short).read_bytes().decode("utf-8", "surrogateescape")
        for name, short in (("stdout", "out"), ("stderr", "err"))
    ]
    return {"code": code, "out": texts[0], "err": texts[1]}


if __name__ == "__main__":
    jobs = json.loads(os.fsdecode(sys.stdin.buffer.read()))
    import analysis.report.html
    import rig.cli.exchange
    import rig.cli.replay
    import rig.cli.run
    import rig.cli.sessions

    with tempfile.TemporaryDirectory() as folder:
        found = [run(job, Path(folder)) for job in jobs]
    print(json.dumps(found))
