"""Data exchanged between a session and other tools' files: a signal in engineering units, a line
spectrum.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from daq.session.record import Record

__all__ = ["CHUNK", "FormatError", "MissingReader", "RecordedSignal", "Samples", "Spectrum", "Wave"]

CHUNK = 65536
"""Samples held at a time; a multiple of four, the numbers in a line of UFF58."""


class FormatError(Exception):
    """A file of another tool cannot be read or written; the message is one sentence."""


class MissingReader(FormatError):
    """The library for a format is not installed."""

    def __init__(self, kind: str, package: str) -> None:
        super().__init__(
            f"reading {kind} needs the package {package}: pip install 'particle-damper-rig[formats]'"
        )


class Samples(Protocol):
    """Samples of one channel, read in order."""

    @property
    def size(self) -> int: ...
    def chunks(self, length: int = CHUNK) -> Iterator[npt.NDArray[np.float64]]: ...
    def samples(self) -> npt.NDArray[np.float64]: ...


@dataclass(frozen=True, eq=False)
class RecordedSignal:
    """A channel of a recorded run in engineering units by the certified sensitivity, without
    corrections.
    """

    record: Record
    run: str
    name: str

    @property
    def size(self) -> int:
        """Number of samples."""
        return self.record.run(self.run).samples

    def read(self, start: int, stop: int) -> npt.NDArray[np.float64]:
        """Return samples start..stop."""
        return np.asarray(self.record.signal(self.run, self.name, start, stop).samples)

    def chunks(self, length: int = CHUNK) -> Iterator[npt.NDArray[np.float64]]:
        """Yield the samples in order, at most `length` at a time."""
        for start in range(0, self.size, length):
            yield self.read(start, min(start + length, self.size))

    def samples(self) -> npt.NDArray[np.float64]:
        """Return all samples at once."""
        return self.read(0, self.size)


@dataclass(frozen=True, eq=False)
class Wave:
    """Evenly sampled values of one channel. rate: Hz; start: ISO 8601, "" where unknown."""

    name: str
    quantity: str
    unit: str
    signal: Samples
    rate: float
    start: str = ""
    direction: str = ""

    @property
    def samples(self) -> npt.NDArray[np.float64]:
        """All samples at once."""
        return self.signal.samples()


@dataclass(frozen=True, eq=False)
class Spectrum:
    """A frequency response at multiples 1, 2, ... of `step` (Hz): response over reference,
    e^(+jwt), peak phasors.
    """

    response: str
    reference: str
    unit: str
    values: npt.NDArray[np.complex128]
    step: float
