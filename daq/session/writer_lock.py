"""One writer per session file, also across processes; the lock dies with its holder, even if that
is killed.
"""

import os
import stat
import sys
import time
from pathlib import Path

from daq.regular_files import open_regular

if sys.platform != "win32":
    import fcntl

__all__ = ["AlreadyLocked", "WriterLock", "is_locked"]

TRIES, PAUSE = 3, 0.02
"""Attempts, and seconds in between: a reader that tests for a live writer (`is_locked`) holds the
lock briefly.
"""


class AlreadyLocked(Exception):
    """Another live process writes this file."""


def is_locked(path: Path) -> bool:
    """Return whether a live process writes the session at `path`; without file locks (Windows)
    always True.
    """
    if sys.platform == "win32":
        return True
    try:
        with open_regular(path.with_name(path.name + ".lock")) as file:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:
        return False
    return False


class WriterLock:
    """Advisory lock on `<path>.lock`, held from construction to release.

    The session file itself cannot carry the lock, because HDF5 locks and unlocks it with the same
    call when readers open it. Raises AlreadyLocked when another recorder, in this or another
    process, holds it. Without file locks (Windows) it does nothing.
    """

    def __init__(self, path: Path) -> None:
        self._path = path.with_name(path.name + ".lock")
        self._descriptor = -1
        if sys.platform == "win32":
            return
        tries = TRIES
        while True:
            self._descriptor = os.open(
                self._path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK, 0o644
            )
            if not stat.S_ISREG(os.fstat(self._descriptor).st_mode):
                os.close(self._descriptor)
                self._descriptor = -1
                raise AlreadyLocked(
                    f"{self._path} is no regular file, and so no lock of a writer: remove it"
                )
            try:
                fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                os.close(self._descriptor)
                tries -= 1
                if not tries:
                    raise AlreadyLocked(f"{path} is being written by another process") from None
                time.sleep(PAUSE)
                continue
            # The previous holder removes its lock file on release. A lock on a removed file
            # protects nothing: try again.
            if self._is_current():
                return
            os.close(self._descriptor)

    def _is_current(self) -> bool:
        try:
            return os.path.samestat(os.fstat(self._descriptor), os.stat(self._path))
        except FileNotFoundError:
            return False

    def release(self) -> None:
        """Release the lock and remove its file; may be called again."""
        if self._descriptor < 0:
            return
        self._path.unlink(missing_ok=True)
        os.close(self._descriptor)
        self._descriptor = -1
