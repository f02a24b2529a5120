"""The JSON file beside an exported record: everything that UFF58, CSV and the like have no field
for.

`run_0001.uff.json` beside `run_0001.uff`: the run, whether poles and delays are corrected in the
samples, the position of the whole cycles, the quality flags, and the certificate of each channel.
It identifies the record by its SHA-256, so that it never describes other samples. `rig import`
reads it.
"""

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from daq.documents.shapes import Each, Keys, List, Number, Shape, Text, YesNo, deviations
from daq.formats.wave import FormatError
from daq.regular_files import open_regular

__all__ = ["SCHEMA", "FlaggedBlock", "Sidecar", "is_sidecar", "read_sidecar", "sidecar_of"]

SCHEMA = "rig/export/1"
LARGEST_FILE = 2**26  # bytes
COUNT = Number(0, 1e12, whole=True)
CERTIFICATE: dict[str, Shape] = {
    "unit": Text(),
    "model": Text(),
    "serial": Text(),
    "direction": Text(),
    "calibration_date": Text(),
    "sensitivity": Number(),
    "calibration_U": Number(0, 1),
    "gain_tolerance": Number(0, 1),
    "time_constants": List(Number(1e-9, 1e9)),
    "time_constant_spread": Number(0, 1),
    "corner_tolerance": Number(0, 1),
    "delay": Number(-1e9, 1e9),
    "skew_tolerance": Number(0, 1),
    "noise_rms": Number(0, 1e12),
    "full_scale": Number(0),
}
SHAPE = Keys(
    {
        "schema": Text((SCHEMA,)),
        "sha256": Text(),
        "run": Text(),
        "order": COUNT,
        "repeat": COUNT,
        "corrected": YesNo(),
        "rate": Number(0, 1e9, above=True),
        "start": Text(),
        "window": Keys(
            {"start": Number(0, 1e12), "cycles": COUNT, "samples_per_cycle": Number(0, 1e12)}
        ),
        "flags": List(Keys({"start": COUNT, "count": COUNT, "flags": Each(COUNT)})),
        "channels": Each(Keys(CERTIFICATE)),
    }
)


@dataclass(frozen=True)
class FlaggedBlock:
    """Samples start..start + count; flags: their quality bits (daq.chain.block.Flag) by channel."""

    start: int
    count: int
    flags: Mapping[str, int]


@dataclass(frozen=True)
class Sidecar:
    """Content of the file beside an exported record.

    corrected: poles and delays are corrected in the samples. rate: Hz. window: first sample of the
    whole cycles in the measured part (fractional where a cycle is not a whole number of samples),
    their number, samples per cycle. channels: certificates.
    """

    corrected: bool
    rate: float
    window: tuple[float, int, float]
    flags: tuple[FlaggedBlock, ...]
    channels: Mapping[str, Mapping[str, Any]]


def sidecar_of(path: Path) -> Path:
    """Return the path of the file beside an exported record."""
    return path.with_name(path.name + ".json")


def is_sidecar(path: Path) -> bool:
    """Return whether a file was written by `rig export` beside a record."""
    try:
        return _document(path) is not None
    except FormatError:
        return False


def read_sidecar(path: Path, digest: str) -> Sidecar | None:
    """Return the sidecar of the record `path`, whose SHA-256 is `digest`; None where there is none
    of ours.

    Raises FormatError where the file cannot be read, because it may be a truncated one of ours, and
    where it is one of ours but malformed, or belongs to other samples.
    """
    beside = sidecar_of(path)
    document = _document(beside)
    if document is None:
        return None
    for sentence in deviations(document, SHAPE):
        raise FormatError(f"{beside}: {sentence}")
    if document["sha256"] != digest:
        raise FormatError(
            f"{path} is not the file that {beside.name} was written for (another SHA-256): export the run again, or "
            "remove the JSON file and state in the mapping what it would have"
        )
    window = document["window"]
    return Sidecar(
        document["corrected"],
        float(document["rate"]),
        (window["start"], int(window["cycles"]), window["samples_per_cycle"]),
        tuple(
            FlaggedBlock(block["start"], block["count"], block["flags"])
            for block in document["flags"]
        ),
        document["channels"],
    )


def _document(path: Path) -> dict[str, Any] | None:
    """Return the JSON value of a file of ours, None for any other or none.

    Raises FormatError where it is not JSON.
    """
    if not os.path.lexists(path):
        return None
    try:
        with open_regular(path) as file:
            text = file.read(LARGEST_FILE + 1)
        if len(text) > LARGEST_FILE:
            raise ValueError(f"it is larger than {LARGEST_FILE} bytes")
        document = json.loads(text.decode("utf-8"))
    except (ValueError, OSError, RecursionError) as error:
        raise FormatError(
            f"{path} cannot be read ({error}), and may state what is corrected in the record: export the run again, or "
            "remove it"
        ) from error
    return document if isinstance(document, dict) and document.get("schema") == SCHEMA else None
