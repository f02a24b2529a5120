"""Errors a user can mend become one clear message and an exit code; any other is a defect with its traceback."""

import errno
import os
import sys
from typing import Any

from typer.core import TyperGroup

BAD_INPUT, INTERRUPTED = 2, 3
FAULTS = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EIO, errno.EROFS, errno.ESTALE}
"""What a disk says that fails under a good command."""


class Commands(TyperGroup):
    """The command group: the one place where errors turn into exit codes."""

    def invoke(self, ctx: Any) -> Any:
        """Call the command; exit 2 for bad input, 3 where it was interrupted or could not keep its pace."""
        from rig.errors import InputError

        try:
            return super().invoke(ctx)
        except InputError as error:
            sys.exit(_fail(str(error), BAD_INPUT))
        except KeyboardInterrupt:
            kept = "; what was recorded is kept, rig run --resume goes on" if ctx.invoked_subcommand == "run" else ""
            sys.exit(_fail(f"interrupted{kept}", INTERRUPTED))
        except Exception as error:
            code = _known(error)
            if code is None:
                raise
            _fail(str(error), code)
            if _is_write_error(error):
                # HDF5 cannot put away a file that it could not write: it would print its own words, and crash.
                sys.stdout.flush()
                sys.stderr.flush()
                os._exit(code)
            sys.exit(code)


def _known(error: Exception) -> int | None:
    from analysis import AnalysisError
    from daq.clock import Overrun
    from daq.formats.wave import FormatError
    from daq.session import SessionError, WriteError
    from rig.campaign.executor import WorkerLost

    if isinstance(error, Overrun | WorkerLost | WriteError):
        return INTERRUPTED
    if isinstance(error, OSError) and error.errno in FAULTS:
        return INTERRUPTED
    return BAD_INPUT if isinstance(error, SessionError | AnalysisError | FormatError | OSError) else None


def _is_write_error(error: Exception) -> bool:
    from daq.session import WriteError

    return isinstance(error, WriteError)


def _fail(message: str, code: int) -> int:
    print(f"rig: {message}", file=sys.stderr)
    return code
