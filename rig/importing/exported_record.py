"""Import of records that `rig export` wrote. The JSON file beside each states which corrections the
samples have and the certificates of the channels, which the mapping need not repeat.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from analysis.signals.correction import pole_phase
from daq.chain.channel import ChannelInfo
from daq.formats.sidecar import Sidecar, read_sidecar, sidecar_of
from rig.errors import InputError, Mistake
from rig.importing.mapping import AccelerationColumn, Column, ForceColumn, RecordMap

__all__ = ["certificate_of", "channel_in", "sidecar_for", "with_certificate"]

CERTIFIED = ("model", "serial", "direction", "calibration_date", "gain_tolerance")
"""Fields of a mapping's column that are taken from the certificate where they have their default."""


def sidecar_for(file: Path, digest: str, mapping: RecordMap) -> Sidecar | None:
    """Return the sidecar of a record with the SHA-256 `digest`, None for none.

    Raises InputError if the mapping asks for a correction that the samples already have, and
    FormatError for a damaged sidecar.
    """
    found = read_sidecar(file, digest)
    if found is None or not found.corrected:
        return found
    for name, column in (("force", mapping.force), ("acceleration", mapping.acceleration)):
        for field, none in (("time_constant", "none"), ("delay", 0.0)):
            value = getattr(column, field)
            if value != none:
                found_there = f"{field} {value:g} s, which {sidecar_of(file).name} beside {file.name} says is undone already"
                allowed = f"no {field}, or the file of rig export --raw"
                raise InputError(Mistake("", f"{name}.{field}", found_there, allowed))
    return found


def channel_in(sidecar: Sidecar, column: Column) -> str | None:
    """Return the exported channel that a mapping's column names, as "name", "name [unit]" or by its
    position from 1; None for none.
    """
    for name, certificate in sidecar.channels.items():
        if column.channel in (name, f"{name} [{certificate['unit']}]"):
            return name
    names = list(sidecar.channels)
    if column.channel.isdecimal() and 1 <= int(column.channel) <= len(names):
        return names[int(column.channel) - 1]
    return None


def certificate_of(sidecar: Sidecar | None, column: Column) -> Mapping[str, Any] | None:
    """Return the certificate of a mapping's column, None for none."""
    name = None if sidecar is None else channel_in(sidecar, column)
    return None if sidecar is None or name is None else sidecar.channels[name]


def with_certificate(
    channel: ChannelInfo,
    column: ForceColumn | AccelerationColumn,
    certificate: Mapping[str, Any],
    corrected: bool,
    frequency: float,
) -> ChannelInfo:
    """Return a row of the channel table whose fields that the mapping does not state are taken from
    the certificate.

    corrected : whether poles and delay are corrected in the samples. The uncertainty of a pole then
        remains as an uncertainty of the channel's delay that causes the same phase at `frequency`.
    frequency : of the drive, Hz
    """
    default = type(column)(channel=column.channel)
    own = {
        name: certificate[name]
        for name in CERTIFIED
        if getattr(column, name) == getattr(default, name)
    }
    if column.calibration_U is None:
        own["calibration_U"] = certificate["calibration_U"]
    if column.noise is None:
        own["noise_rms"] = certificate["noise_rms"]
    poles = certificate["time_constants"]
    tolerance = column.delay_tolerance or certificate["skew_tolerance"]
    if corrected:
        spreads = (
            certificate["time_constant_spread"],
            certificate["corner_tolerance"] / math.sqrt(3),
        )
        omega = 2 * math.pi * frequency
        # Phase of a high pass: atan(1 / (omega T)); its derivative by ln T is -sin(2 phase) / 2.
        phases = [
            0.5 * spread * math.sin(2 * pole_phase(omega, pole))
            for pole, spread in zip(poles, spreads, strict=False)
        ]
        # sqrt(3): a tolerance is the half width of a rectangular distribution.
        own["skew_tolerance"] = math.hypot(
            tolerance, *(math.sqrt(3) * phase / omega for phase in phases)
        )
    else:
        own["skew_tolerance"] = tolerance
        if column.delay == 0.0:
            own["skew"] = -certificate["delay"]
        if column.time_constant == "none" and poles:
            own["time_constant"] = poles[0]
            own["time_constant_spread"] = certificate["time_constant_spread"]
            own["corner"] = 1 / (2 * math.pi * poles[1]) if len(poles) > 1 else 0.0
            own["corner_tolerance"] = certificate["corner_tolerance"]
    return replace(channel, **own)
