"""Read channels of WAV files: codes of a converter, or floating numbers. A WAV file states a rate and
no unit.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from daq.formats.column import FileColumn, hertz, name_of, numbers
from daq.formats.wave import FormatError

__all__ = ["read_wav"]


def read_wav(path: Path, wanted: Sequence[str]) -> dict[str, FileColumn]:
    """Return channels by their position from 1. FormatError where the file is malformed or cut."""
    from scipy.io import wavfile

    reader: Any = wavfile
    try:
        rate, table = reader.read(path)
    except ValueError as error:
        raise FormatError(f"{path} cannot be read as wav: {error}") from error
    table = np.atleast_2d(table.T).T
    names = [str(n + 1) for n in range(table.shape[1])]
    found = {}
    for name in wanted:
        n = names.index(name_of(path, names, name, "channel"))
        own = numbers(path, f"channel {name}", table[:, n])
        found[name] = FileColumn(
            own.samples, rate=hertz(path, "the rate", rate), codes=own.codes, resolution=own.resolution
        )
    return found
