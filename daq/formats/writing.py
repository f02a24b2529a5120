"""A run of a session as other tools like it: CSV with a JSON beside it, SEP-005, MATLAB."""

import csv
import io
import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from daq.formats.wave import Wave

__all__ = ["sep005", "write_csv", "write_mat", "write_sep005"]

QUANTITIES = {"force": "f", "acceleration": "a"}
"""SEP-005's letters."""


def write_csv(path: Path, waves: Sequence[Wave], facts: dict[str, Any]) -> None:
    """A column per channel, 17 digits (they read back to the same numbers), no time column: rate, start and all other
    facts stand in the JSON file of the same name. Raises OSError."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow([f"{wave.name} [{wave.unit}]" for wave in waves])
    np.savetxt(text, np.stack([wave.samples for wave in waves], axis=1), fmt="%.17g", delimiter=",")
    _whole(path, lambda part: part.write_text(text.getvalue(), encoding="utf-8", newline="\n"))
    channels = [{name: value for name, value in _facts(wave).items() if name != "data"} for wave in waves]
    document = {**facts, "rate": waves[0].rate, "start": waves[0].start, "channels": channels}
    told = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
    _whole(path.with_suffix(".json"), lambda part: part.write_text(told, encoding="utf-8", newline="\n"))


def sep005(waves: Sequence[Wave]) -> list[dict[str, Any]]:
    """The waves as SEP-005 dicts: data, name, unit_str, fs, quantity, start_timestamp."""
    return [_facts(wave) for wave in waves]


def write_sep005(path: Path, waves: Sequence[Wave]) -> None:
    """SEP-005 dicts in an npz file without pickle: arrays data_0, data_1, ... and the rest as JSON in `channels`.

    Raises OSError.
    """
    entries = sep005(waves)
    arrays = {f"data_{number}": entry.pop("data") for number, entry in enumerate(entries)}
    told = np.array(json.dumps(entries, ensure_ascii=False))
    _whole(path, lambda part: _save(part, channels=told, **arrays))


def write_mat(path: Path, waves: Sequence[Wave], facts: dict[str, Any]) -> None:
    """MATLAB (version 5): a column vector per channel, `fs` in Hz, `units`, `start` and `session`. Raises OSError."""
    from scipy import io as matlab

    values: dict[str, Any] = {wave.name: wave.samples[:, np.newaxis] for wave in waves}
    values |= {"fs": waves[0].rate, "start": waves[0].start, "session": json.dumps(facts, ensure_ascii=False)}
    values["units"] = {wave.name: wave.unit for wave in waves}

    def write(part: Path) -> None:
        with part.open("wb") as file:
            matlab.savemat(file, values, long_field_names=True, do_compression=True)  # type: ignore[attr-defined, no-untyped-call, unused-ignore]

    _whole(path, write)


def _facts(wave: Wave) -> dict[str, Any]:
    rate = int(wave.rate) if wave.rate.is_integer() else wave.rate  # pyFRF takes whole numbers of Hz only
    found: dict[str, Any] = {"data": wave.samples, "name": wave.name, "unit_str": wave.unit, "fs": rate}
    if wave.quantity in QUANTITIES:
        found["quantity"] = QUANTITIES[wave.quantity]
    if wave.start:
        found["start_timestamp"] = wave.start
    return found


def _save(part: Path, **arrays: Any) -> None:
    with part.open("wb") as file:
        np.savez_compressed(file, **arrays)


def _whole(path: Path, write: Callable[[Path], object]) -> None:
    """Write a file under a temporary name, so that it is whole or not there."""
    part = path.with_name(path.name + ".part")
    try:
        write(part)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)
