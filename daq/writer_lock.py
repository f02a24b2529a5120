"""One writer per session file, also across processes; the lock dies with its holder, however it dies."""

import os
import sys
from pathlib import Path

if sys.platform != "win32":
    import fcntl

__all__ = ["AlreadyLocked", "WriterLock"]


class AlreadyLocked(Exception):
    """Another live process writes this file."""


class WriterLock:
    """Advisory lock on `<path>.lock`, held from construction to release.

    The session file itself cannot carry the lock: HDF5 locks and unlocks it with the same call when readers open it.
    Raises AlreadyLocked when another recorder, in this or another process, holds it. Without file locks (Windows)
    it does nothing.
    """

    def __init__(self, path: Path) -> None:
        self._path = path.with_name(path.name + ".lock")
        self._descriptor = -1
        if sys.platform == "win32":
            return
        while True:
            self._descriptor = os.open(self._path, os.O_RDWR | os.O_CREAT, 0o644)
            try:
                fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                os.close(self._descriptor)
                raise AlreadyLocked(f"{path} is being written by another process") from None
            # A holder removes its lock file on release: a lock on a removed file locks nothing, so try again.
            if self._is_current():
                return
            os.close(self._descriptor)

    def _is_current(self) -> bool:
        try:
            return os.path.samestat(os.fstat(self._descriptor), os.stat(self._path))
        except FileNotFoundError:
            return False

    def release(self) -> None:
        """Give the lock up and remove its file; again is harmless."""
        if self._descriptor < 0:
            return
        self._path.unlink(missing_ok=True)
        os.close(self._descriptor)
        self._descriptor = -1
