"""What crosses the border between a session and other tools' files: a signal in engineering units, a line spectrum."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from daq.session_record import Record

__all__ = ["FormatError", "MissingReader", "Spectrum", "Wave", "waves_of"]


class FormatError(Exception):
    """A file of another tool cannot be read or written; the message is one clear sentence."""


class MissingReader(FormatError):
    """The library that reads a format is not installed."""

    def __init__(self, kind: str, package: str) -> None:
        super().__init__(f"reading {kind} needs the package {package}: pip install 'particle-damper-rig[formats]'")


@dataclass(frozen=True, eq=False)
class Wave:
    """Evenly sampled values of one channel. rate: Hz; start: ISO 8601, "" where it is not known."""

    name: str
    quantity: str
    unit: str
    samples: npt.NDArray[np.float64]
    rate: float
    start: str = ""
    direction: str = ""


@dataclass(frozen=True, eq=False)
class Spectrum:
    """A frequency response at multiples 1, 2, ... of `step` (Hz): response over reference, e^(+jwt), peak phasors."""

    response: str
    reference: str
    unit: str
    values: npt.NDArray[np.complex128]
    step: float


def waves_of(record: Record, run: str) -> tuple[Wave, ...]:
    """All channels of a run in engineering units (certified sensitivities), in the order of the channel table."""
    info = record.run(run)
    waves = []
    for channel in record.channels.values():
        signal = record.signal(run, channel.name)
        waves.append(
            Wave(channel.name, channel.quantity, channel.unit, signal.samples, info.rate, info.t0, channel.direction)
        )
    return tuple(waves)
