"""Write a run of a session for other tools: CSV, SEP-005, MATLAB."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from daq.formats.wave import Wave
from daq.json_text import json_text
from daq.strange_text import cell_text
from daq.whole_files import whole_file

__all__ = ["sep005", "write_csv", "write_mat", "write_sep005"]

QUANTITIES = {"force": "f", "acceleration": "a"}
"""SEP-005's letters for quantities."""


def write_csv(path: Path, waves: Sequence[Wave]) -> None:
    """Write one column per channel, chunk by chunk, with 17 digits, which read back to the same
    numbers. Raises OSError.

    There is no time column: rate, start and all other facts are in the file beside it.
    """
    head = io.StringIO()
    csv.writer(head, lineterminator="\n").writerow(
        [cell_text(f"{wave.name} [{wave.unit}]") for wave in waves]
    )
    with whole_file(path) as file:
        file.write(head.getvalue().encode())
        for chunks in zip(*(wave.signal.chunks() for wave in waves), strict=True):
            np.savetxt(file, np.stack(chunks, axis=1), fmt="%.17g", delimiter=",")


def sep005(waves: Sequence[Wave]) -> list[dict[str, Any]]:
    """Return the waves as SEP-005 dicts: data, name, unit_str, fs, quantity, start_timestamp."""
    return [_facts(wave) for wave in waves]


def write_sep005(path: Path, waves: Sequence[Wave]) -> None:
    """Write SEP-005 dicts to an npz file without pickle: arrays data_0, data_1, ... and the rest as
    JSON in `channels`.

    Raises OSError.
    """
    entries = sep005(waves)
    arrays = {f"data_{number}": entry.pop("data") for number, entry in enumerate(entries)}
    told = np.array(json_text(entries, None))
    with whole_file(path) as file:
        np.savez_compressed(file, channels=told, **arrays)


def write_mat(path: Path, waves: Sequence[Wave], facts: dict[str, Any]) -> None:
    """Write MATLAB (version 5): one column vector per channel, `fs` in Hz, `units`, `start` and
    `session`. Raises OSError.
    """
    from scipy import io as matlab

    values: dict[str, Any] = {wave.name: wave.samples[:, np.newaxis] for wave in waves}
    values |= {"fs": waves[0].rate, "start": waves[0].start, "session": json_text(facts, None)}
    values["units"] = {wave.name: wave.unit for wave in waves}

    with whole_file(path) as file:
        matlab.savemat(file, values, long_field_names=True, do_compression=True)  # type: ignore[attr-defined, no-untyped-call, unused-ignore]


def _facts(wave: Wave) -> dict[str, Any]:
    """Return one wave as a SEP-005 dict."""
    # pyFRF takes whole numbers of Hz only
    rate = int(wave.rate) if wave.rate.is_integer() else wave.rate
    found: dict[str, Any] = {
        "data": wave.samples,
        "name": wave.name,
        "unit_str": wave.unit,
        "fs": rate,
    }
    if wave.quantity in QUANTITIES:
        found["quantity"] = QUANTITIES[wave.quantity]
    if wave.start:
        found["start_timestamp"] = wave.start
    return found
