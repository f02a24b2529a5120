"""Regular files and nothing else: opening a pipe or a device can wait for ever, reading one can have no end."""

import os
import stat
from io import BufferedReader
from pathlib import Path

__all__ = ["NotRegular", "kind_of_place", "open_regular"]

KINDS = {
    stat.S_IFDIR: "a folder", stat.S_IFIFO: "a pipe", stat.S_IFSOCK: "a socket", stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}  # fmt: skip
AT_ONCE = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0)


class NotRegular(OSError):
    """What lies at a path is no regular file; `strerror` says what it is."""


def kind_of_place(path: Path) -> str:
    """Return what a path leads to, links followed: "a file", "a folder", "a pipe", ..., "" for nothing."""
    try:
        return _kind(os.stat(path))
    except (OSError, ValueError):  # ValueError: a null character
        return ""


def open_regular(path: Path) -> BufferedReader:
    """Open a regular file for reading, waiting for nobody. Raises OSError, NotRegular for any other thing."""
    _check(path, os.stat(path))  # opening alone can rewind a tape
    descriptor = os.open(path, AT_ONCE)
    try:
        _check(path, os.fstat(descriptor))  # another thing may have come to the path since
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def _check(path: Path, found: os.stat_result) -> None:
    kind = _kind(found)
    if kind != "a file":
        raise NotRegular(0, f"{kind}, no file", str(path))


def _kind(found: os.stat_result) -> str:
    return "a file" if stat.S_ISREG(found.st_mode) else KINDS.get(stat.S_IFMT(found.st_mode), "no file")
