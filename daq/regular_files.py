"""Open regular files and nothing else: opening a pipe or device can block for ever, and reading one
may never end.
"""

import os
import stat
from io import BufferedReader
from pathlib import Path

__all__ = ["NotRegular", "kind_of_place", "open_regular"]

KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}
AT_ONCE = (
    os.O_RDONLY
    | getattr(os, "O_NONBLOCK", 0)
    | getattr(os, "O_NOCTTY", 0)
    | getattr(os, "O_BINARY", 0)
)


class NotRegular(OSError):
    """The path leads to something other than a regular file, which `strerror` names."""


def kind_of_place(path: Path) -> str:
    """Return the kind of object at a path, links followed: "a file", "a folder", "a pipe", ...; ""
    for nothing.
    """
    try:
        return _kind(os.stat(path))
    except (OSError, ValueError):  # ValueError: a null character
        return ""


def open_regular(path: Path) -> BufferedReader:
    """Open a regular file for reading, without blocking.

    Raises OSError; NotRegular for anything but a file.
    """
    _check(path, os.stat(path))  # before opening, which alone can rewind a tape
    descriptor = os.open(path, AT_ONCE)
    try:
        _check(path, os.fstat(descriptor))  # the path may have been replaced since the first check
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def _check(path: Path, found: os.stat_result) -> None:
    kind = _kind(found)
    if kind != "a file":
        raise NotRegular(0, f"{kind}, no file", str(path))


def _kind(found: os.stat_result) -> str:
    return (
        "a file"
        if stat.S_ISREG(found.st_mode)
        else KINDS.get(stat.S_IFMT(found.st_mode), "no file")
    )
