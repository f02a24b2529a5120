"""Turn errors that a user can correct into one message and an exit code; any other is a defect and
keeps its traceback.
"""

import atexit
import errno
import os
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import typer
from typer.core import TyperGroup

from daq.strange_text import visible
from rig.cli.memory import memory_limit, short_of_memory

BAD_INPUT, INTERRUPTED = 2, 3
FAULTS = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.ESTALE}
"""Error numbers of a failing or full disk, not of a wrong command."""

UsageError: Any = typer.BadParameter.__base__
"""The exception for a wrong option or argument; typer takes it from click or from a copy of its
own.
"""


class Commands(TyperGroup):
    """The command group: the only place where errors become exit codes."""

    def invoke(self, ctx: Any) -> Any:
        """Call the command; exit 2 for bad input, 3 for an interruption, a failure of the machine
        or a late sample.
        """
        from rig.errors import InputError

        short = short_of_memory()
        if short:
            sys.exit(fail(short, INTERRUPTED))
        try:
            return super().invoke(ctx)
        except InputError as error:
            sys.exit(fail(str(error), BAD_INPUT))
        except KeyboardInterrupt:
            kept = (
                "; what was recorded is kept, rig run --resume goes on"
                if ctx.invoked_subcommand == "run"
                else ""
            )
            sys.exit(fail(f"interrupted{kept}", INTERRUPTED))
        except UsageError as error:
            error.message = visible(error.message)
            raise
        except BrokenPipeError:  # the reader has closed the output; 1 would be a verdict
            sys.exit(INTERRUPTED)
        except Exception as error:
            code = _known(error)
            if code is None:
                raise
            fail(_sentence(error), code)
            if _is_write_error(error):
                # HDF5 cannot close a file that it could not write: at exit it would print errors
                # and crash.
                _flush(sys.stdout)
                _flush(sys.stderr)
                os._exit(code)
            sys.exit(code)


def _known(error: Exception) -> int | None:
    """Return the exit code of an error that a user can correct, None for a defect."""
    if isinstance(error, MemoryError):
        return INTERRUPTED
    if isinstance(error, OSError):
        return INTERRUPTED if error.errno in {*FAULTS, errno.ENOMEM} else BAD_INPUT
    from analysis.session.record import AnalysisError
    from daq.chain.clock import Overrun
    from daq.formats.wave import FormatError
    from daq.session.plan import SessionError, WriteError
    from rig.errors import WorkerLost

    if isinstance(error, Overrun | WorkerLost | WriteError):
        return INTERRUPTED
    return BAD_INPUT if isinstance(error, SessionError | AnalysisError | FormatError) else None


def _sentence(error: Exception) -> str:
    """Return an error's message in one line."""
    if isinstance(error, MemoryError) or (
        isinstance(error, OSError) and error.errno == errno.ENOMEM
    ):
        limit = memory_limit()
        told = "" if limit is None else f": this process may use {limit / 1e6:.0f} MB (ulimit -v)"
        return f"out of memory{told}"
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        return visible(f"{os.fsdecode(error.filename)}: {error.strerror.lower()}")
    return visible(" ".join(str(error).split()))


def _is_write_error(error: Exception) -> bool:
    """Return whether HDF5 failed to write a session."""
    if isinstance(error, OSError | MemoryError):
        return False
    from daq.session.plan import WriteError

    return isinstance(error, WriteError)


def fail(message: str, code: int) -> int:
    """Print an error message to standard error, if possible, and return the exit code."""
    # Standard error may be on a full disk, or closed: then the exit code must suffice.
    with suppress(OSError, ValueError):
        print(f"rig: {visible(message, chr(10))}", file=sys.stderr, flush=True)
    return code


def with_whole_output(call: Callable[[], object]) -> None:
    """Run a command and end the process with its exit code after all output is written; 3 where its
    disk is full.

    Characters that the terminal cannot show are written as escapes, so that no name ends a command.
    The process ends without the orderly shutdown of the interpreter and the compiler's libraries,
    which takes 0.3 s.
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    code: Any = 0
    try:
        call()
    except SystemExit as ended:
        code = ended.code
    except OSError as error:  # while help or a usage error was printed
        code = fail(
            _sentence(error),
            BAD_INPUT if isinstance(error.__context__, UsageError) else INTERRUPTED,
        )
    lost = _flush(sys.stdout)
    if lost is not None and lost.errno != errno.EPIPE:
        code = fail(f"the output cannot be written ({lost.strerror})", INTERRUPTED)
    _flush(sys.stderr)
    # os._exit skips the exit functions; some delete temporary folders.
    atexit._run_exitfuncs()
    os._exit(code if isinstance(code, int) else int(code is not None))


def _flush(stream: Any) -> OSError | None:
    """Flush a stream; where that fails, redirect it, or Python tries again at exit and changes the
    exit code.
    """
    try:
        stream.flush()
    except OSError as error:
        with suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)
        return error
    except (AttributeError, ValueError):  # no stream, or a closed one
        pass
    return None
