"""Records that `rig export` wrote: the file beside each says what is undone, and what the mapping
need not repeat.
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

SAID = ("model", "serial", "direction", "calibration_date", "gain_tolerance")
"""Fields of a mapping's column that the certificate fills where they have their default."""


def sidecar_for(file: Path, digest: str, mapping: RecordMap) -> Sidecar | None:
    """Return what stands beside a record with the SHA-256 `digest`, None where there is nothing.

    Raises InputError where the mapping asks for a correction that is done already; FormatError for
    a damaged file.
    """
    found = read_sidecar(file, digest)
    if found is None or not found.corrected:
        return found
    for name, column in (("force", mapping.force), ("acceleration", mapping.acceleration)):
        for field, none in (("time_constant", "none"), ("delay", 0.0)):
            value = getattr(column, field)
            if value != none:
                told = f"{field} {value:g} s, which {sidecar_of(file).name} beside {file.name} says is undone already"
                allowed = f"no {field}, or the file of rig export --raw"
                raise InputError(Mistake("", f"{name}.{field}", told, allowed))
    return found


def channel_in(sidecar: Sidecar, column: Column) -> str | None:
    """Return the exported channel behind a mapping's column, "name", "name [unit]" or its position;
    None for none.
    """
    for name, certificate in sidecar.channels.items():
        if column.channel in (name, f"{name} [{certificate['unit']}]"):
            return name
    names = list(sidecar.channels)
    if column.channel.isdecimal() and 1 <= int(column.channel) <= len(names):
        return names[int(column.channel) - 1]
    return None


def certificate_of(sidecar: Sidecar | None, column: Column) -> Mapping[str, Any] | None:
    """Return the certificate of a mapping's column; None where nothing states one."""
    name = None if sidecar is None else channel_in(sidecar, column)
    return None if sidecar is None or name is None else sidecar.channels[name]


def with_certificate(
    channel: ChannelInfo,
    column: ForceColumn | AccelerationColumn,
    certificate: Mapping[str, Any],
    corrected: bool,
    frequency: float,
) -> ChannelInfo:
    """Return a row of the channel table with what the mapping leaves open filled from the
    certificate.

    corrected: poles and delay are undone in the samples; what is not known of a pole then stays as
    uncertainty of the channel's time, of equal phase at `frequency` (Hz).
    """
    default = type(column)(channel=column.channel)
    own = {
        name: certificate[name] for name in SAID if getattr(column, name) == getattr(default, name)
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
        phases = [
            0.5 * spread * math.sin(2 * pole_phase(omega, pole))
            for pole, spread in zip(poles, spreads, strict=False)
        ]
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
