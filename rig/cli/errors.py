"""Errors a user can mend become one clear message and an exit code; any other is a defect with its traceback."""

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
"""What a disk says that fails under a good command."""

UsageError: Any = typer.BadParameter.__base__
"""What a wrong option or argument raises; typer has it from a package or from a copy of its own."""


class Commands(TyperGroup):
    """The command group: the one place where errors turn into exit codes."""

    def invoke(self, ctx: Any) -> Any:
        """Call the command; exit 2 for bad input, 3 where it was interrupted, failed by the machine or was late."""
        from rig.errors import InputError

        short = short_of_memory()
        if short:
            sys.exit(fail(short, INTERRUPTED))
        try:
            return super().invoke(ctx)
        except InputError as error:
            sys.exit(fail(str(error), BAD_INPUT))
        except KeyboardInterrupt:
            kept = "; what was recorded is kept, rig run --resume goes on" if ctx.invoked_subcommand == "run" else ""
            sys.exit(fail(f"interrupted{kept}", INTERRUPTED))
        except UsageError as error:
            error.message = visible(error.message)
            raise
        except BrokenPipeError:  # whoever read the output has seen enough: not 1, which is a verdict
            sys.exit(INTERRUPTED)
        except Exception as error:
            code = _known(error)
            if code is None:
                raise
            fail(_sentence(error), code)
            if _is_write_error(error):
                # HDF5 cannot put away a file that it could not write: it would print its own words, and crash.
                _flush(sys.stdout)
                _flush(sys.stderr)
                os._exit(code)
            sys.exit(code)


def _known(error: Exception) -> int | None:
    if isinstance(error, MemoryError):
        return INTERRUPTED
    if isinstance(error, OSError):
        return INTERRUPTED if error.errno in {*FAULTS, errno.ENOMEM} else BAD_INPUT
    from analysis import AnalysisError
    from daq.chain.clock import Overrun
    from daq.formats.wave import FormatError
    from daq.session.plan import SessionError, WriteError
    from rig.errors import WorkerLost

    if isinstance(error, Overrun | WorkerLost | WriteError):
        return INTERRUPTED
    return BAD_INPUT if isinstance(error, SessionError | AnalysisError | FormatError) else None


def _sentence(error: Exception) -> str:
    """What an error says, in one line."""
    if isinstance(error, MemoryError) or (isinstance(error, OSError) and error.errno == errno.ENOMEM):
        limit = memory_limit()
        told = "" if limit is None else f": this process may use {limit / 1e6:.0f} MB (ulimit -v)"
        return f"out of memory{told}"
    if isinstance(error, OSError) and error.strerror and error.filename is not None:
        return visible(f"{os.fsdecode(error.filename)}: {error.strerror.lower()}")
    return visible(" ".join(str(error).split()))


def _is_write_error(error: Exception) -> bool:
    if isinstance(error, OSError | MemoryError):
        return False
    from daq.session.plan import WriteError

    return isinstance(error, WriteError)


def fail(message: str, code: int) -> int:
    """Say what went wrong, line by line where there is anybody to hear it, and return the exit code."""
    with suppress(OSError, ValueError):  # a full disk under standard error, or none at all: the code has to do
        print(f"rig: {visible(message, chr(10))}", file=sys.stderr, flush=True)
    return code


def with_whole_output(call: Callable[[], object]) -> None:
    """Run a command and end the process with its exit code, all output written; 3 where a disk under it is full.

    What a terminal cannot show is written as an escape, so that no name and no sign ends a command. The interpreter
    and the compiler's libraries are not taken down piece by piece: that is .3 s in which nothing happens.
    """
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="backslashreplace")
    code: Any = 0
    try:
        call()
    except SystemExit as ended:
        code = ended.code
    except OSError as error:  # while help, or what is wrong with an option, was printed
        code = fail(_sentence(error), BAD_INPUT if isinstance(error.__context__, UsageError) else INTERRUPTED)
    lost = _flush(sys.stdout)
    if lost is not None and lost.errno != errno.EPIPE:
        code = fail(f"the output cannot be written ({lost.strerror})", INTERRUPTED)
    _flush(sys.stderr)
    atexit._run_exitfuncs()
    os._exit(code if isinstance(code, int) else int(code is not None))


def _flush(stream: Any) -> OSError | None:
    """Write out what a stream holds; where that fails, drop it, or Python tries again at exit and changes the code."""
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
