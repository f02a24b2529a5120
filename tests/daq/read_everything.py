"""A program: reads each session file named, all of it, in a child process of its own, and prints
how that went.

The first file is a good one: it loads the libraries.

One line per file: "read", "refused", "signal 11", or "TRACE" with what came out.
"""

import os
import signal
import sys
import tempfile
import traceback
import warnings
from pathlib import Path


def use(path: Path) -> None:
    from analysis import read_session, write_report
    from analysis.session.documents import session_document_deviations
    from daq.session.record import open_session
    from daq.session.validate import session_deviations
    from rig.cli.commands.sessions import _facts

    with open_session(path, 20.0) as record:
        for _ in (*session_deviations(record), *session_document_deviations(record)):
            pass
        _facts(record)
        with tempfile.TemporaryDirectory() as folder:
            write_report(read_session(record), folder, figures=False)


def outcome(path: Path) -> str:
    from analysis import AnalysisError
    from daq.session.plan import SessionError

    try:
        use(path)
    except (SessionError, AnalysisError):
        return "refused"
    except BaseException:  # noqa: BLE001  whatever comes out is what is asked for here
        return "TRACE " + traceback.format_exc().strip().replace("\n", " | ")[-600:]
    return "read"


def main() -> None:
    warnings.simplefilter("ignore")
    use(Path(sys.argv[1]))
    for name in sys.argv[2:]:
        reading, writing = os.pipe()
        child = os.fork()
        if not child:
            signal.alarm(120)
            os.write(writing, outcome(Path(name)).encode())
            os._exit(0)
        os.close(writing)
        with os.fdopen(reading, "rb") as pipe:
            said = pipe.read().decode()
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        print(f"{name}\t{said if code == 0 else f'signal {-code}'}", flush=True)


if __name__ == "__main__":
    main()
