"""A block of codes: the output of every acquisition and the unit that a recorder stores."""

from dataclasses import dataclass
from enum import IntFlag

import numpy as np
import numpy.typing as npt

__all__ = ["Block", "Flag", "flag_names"]


class Flag(IntFlag):
    """Quality bits of one block and channel; the values are part of the session file format."""

    OVERLOAD_HI = 1
    OVERLOAD_LO = 2
    INVALID = 4
    OVERRUN = 8
    GAP = 16
    IEPE_OPEN = 32
    IEPE_SHORT = 64
    NOT_SETTLED = 128
    SENSOR_CLIP = 256


def flag_names(bits: int) -> tuple[str, ...]:
    """Return the lower-case names of the bits that are set, lowest first: 3 -> ("overload_hi",
    "overload_lo").
    """
    return tuple(name for flag, name in _NAMES if bits & flag)


_NAMES = tuple((int(flag), str(flag.name).lower()) for flag in Flag)


@dataclass(frozen=True, eq=False)
class Block:
    """Consecutive samples of all channels; the sample index is the only clock.

    start: index of the first sample since the start of the run. codes: (channels, n) int32,
    converter codes; volts = code * range / 2^(bits - 1). flags: (channels,) uint16, bits of `Flag`
    that hold anywhere in the block. clipped: (channels,) uint32, number of samples at either rail
    plus samples in whose interval the sensor itself clipped. settling: the block starts before the
    front end's filter has filled (bit NOT_SETTLED is set too).
    """

    start: int
    codes: npt.NDArray[np.int32]
    flags: npt.NDArray[np.uint16]
    clipped: npt.NDArray[np.uint32]
    settling: bool

    @property
    def count(self) -> int:
        """Number of samples per channel."""
        return int(self.codes.shape[1])
