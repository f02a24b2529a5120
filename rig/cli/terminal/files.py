"""Write files that a user requested, whole or not at all."""

import os
from pathlib import Path

from daq.whole_files import write_whole
from rig.errors import InputError, Mistake


def write_new(path: Path, text: str, overwrite: bool) -> None:
    """Write a text file, whole or not at all.

    Raises InputError where it exists, unless it may be replaced.
    """
    if os.path.lexists(path) and not overwrite:
        raise InputError(
            Mistake(str(path), "", "a file that exists", "a new path, or --force to replace it")
        )
    try:
        write_whole(path, text)
    except OSError as error:
        raise InputError(
            Mistake(str(path), "", f"no way to write it ({error.strerror})", "a writable path")
        ) from None
