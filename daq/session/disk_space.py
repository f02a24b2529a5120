"""Allocate disk space in advance, so that a full disk is reported before anything is recorded."""

import errno
import os
from pathlib import Path

__all__ = ["reserve"]

NOT_SUPPORTED = {errno.EOPNOTSUPP, errno.EINVAL, errno.ENOSYS}


def reserve(path: Path, size: int | None = None) -> None:
    """Allocate the disk space of a file's first `size` bytes, its present size for None; create it
    where missing.

    Raises OSError where there is not enough. Does nothing where the system or the file system does
    not support it.
    """
    if not hasattr(os, "posix_fallocate"):
        return
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        wanted = os.fstat(descriptor).st_size if size is None else size
        if wanted:
            os.posix_fallocate(descriptor, 0, wanted)
    except OSError as error:
        if error.errno not in NOT_SUPPORTED:
            raise
    finally:
        os.close(descriptor)
