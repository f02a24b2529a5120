"""Write files whole or not at all: under a random name in the same folder, then renamed into place.

After a full disk or a kill the old file is still there. An existing entry is replaced and never
written through, so that a symbolic link in a folder received from somebody else leaves its target
untouched. Pipes, sockets and devices are never replaced.
"""

import errno
import os
import secrets
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from daq.regular_files import NotRegular, kind_of_place

__all__ = [
    "UNFINISHED",
    "fresh_file",
    "mark_unfinished",
    "unfinished",
    "whole_file",
    "write_folder",
    "write_whole",
]

UNFINISHED = "UNFINISHED.txt"
"""Note in a folder while its files are replaced one after the other; a kill in between leaves it
there.
"""

WHY = """The files of this folder were being replaced. If no program is at work here any more, it was
stopped in between, and what lies here does not belong together: some of it is older than the rest.
`rig report` of the session writes all of it anew, and removes this note.
"""


# O_EXCL and O_NOFOLLOW: nobody can plant a link under the temporary name.
NEW_ONLY = (
    os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
)


@contextmanager
def whole_file(path: Path) -> Iterator[BinaryIO]:
    """Open a binary file for writing that replaces `path` when the block ends without an error.

    Raises OSError.
    """
    _check_replaceable(path)
    part = _part_of(path)
    with _removed_on_failure([part]):
        with _create(part) as file:
            yield file
        os.replace(part, path)


def write_whole(path: Path, data: str | bytes) -> None:
    """Write text (UTF-8, line ends unchanged) or bytes to `path`, whole or not at all.

    Raises OSError.
    """
    with whole_file(path) as file:
        file.write(_encoded(data))


def fresh_file(path: Path) -> BinaryIO:
    """Open a new binary file at `path` for writing piece by piece. Raises OSError.

    An existing file or link is removed, not followed.
    """
    _check_replaceable(path)
    path.unlink(missing_ok=True)
    return _create(path)


def write_folder(folder: Path, contents: Mapping[str, str | bytes]) -> tuple[Path, ...]:
    """Write files into a folder, created if missing, and return their paths.

    contents: relative path -> text or bytes. All are written under temporary names before the first
    is renamed, in the given order, so that a full disk leaves every old file. A kill between the
    renames leaves some old files, and the note UNFINISHED, which is there from before the first
    rename until after the last. Raises OSError, also where a folder inside `folder` is a symbolic
    link, which could lead anywhere.
    """
    parts: dict[Path, Path] = {}
    with _removed_on_failure(parts):
        for name, data in contents.items():
            path = folder / name
            _make_parents(folder, path)
            _check_replaceable(path)
            part = _part_of(path)
            parts[part] = path
            with _create(part) as file:
                file.write(_encoded(data))
        mark_unfinished(folder)
        for part, path in parts.items():
            os.replace(part, path)
        (folder / UNFINISHED).unlink(missing_ok=True)
    return tuple(parts.values())


def mark_unfinished(folder: Path) -> None:
    """Leave the note that the files of a folder do not belong together, until `write_folder`
    removes it. Raises OSError.
    """
    write_whole(folder / UNFINISHED, WHY)


def unfinished(folder: Path) -> bool:
    """Return whether the replacement of a folder's files was interrupted, or is under way."""
    return os.path.lexists(folder / UNFINISHED)


def _make_parents(folder: Path, path: Path) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    for parent in path.parents:
        if parent == folder:
            return
        if parent.is_symlink():
            raise FileExistsError(
                f"{parent} is a symbolic link; the files would be written elsewhere"
            )


def _check_replaceable(path: Path) -> None:
    """Raise NotRegular for anything but a file or a folder: a superuser could replace a device."""
    kind = kind_of_place(path)
    # A folder is let through: the rename then fails with the system's own message.
    if kind not in ("", "a file", "a folder"):
        raise NotRegular(errno.EEXIST, f"{kind}, which is not replaced", str(path))


def _part_of(path: Path) -> Path:
    """Return a temporary path in the same folder, so that the final rename stays on one file
    system.
    """
    return path.with_name(f".{path.name[:200]}.{secrets.token_hex(6)}.part")


def _create(part: Path) -> BinaryIO:
    return os.fdopen(os.open(part, NEW_ONLY, 0o666), "wb")


def _encoded(data: str | bytes) -> bytes:
    return data.encode("utf-8") if isinstance(data, str) else data


@contextmanager
def _removed_on_failure(parts: Mapping[Path, Path] | list[Path]) -> Iterator[None]:
    """Delete the temporary files if the block raises."""
    try:
        yield
    except BaseException:
        for part in parts:
            part.unlink(missing_ok=True)
        raise
