"""Writing files that a user asked for: whole or not at all."""

import os
from pathlib import Path

from rig.errors import InputError, Mistake


def write_new(path: Path, text: str, overwrite: bool) -> None:
    """Write a text file through a temporary one; InputError where it exists, unless it may be replaced."""
    if path.exists() and not overwrite:
        raise InputError(Mistake(str(path), "", "a file that exists", "a new path, or --force to replace it"))
    part = path.with_name(path.name + ".part")
    try:
        part.write_text(text, encoding="utf-8")
        os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise InputError(Mistake(str(path), "", f"no way to write it ({error.strerror})", "a writable path")) from None
