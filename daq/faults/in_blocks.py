"""Deliberate faults in an acquisition's blocks: the codes recorded instead, and the quality bits
set.

    dropout     the samples are lost: code 0, bit GAP cable_open  only the input's own noise; bit
    IEPE_OPEN where the input feeds its sensor and so can detect it stuck       the last code before
    the fault is repeated spike       size x range is added, at one sample or for the duration bias
    size x range is added drift       a ramp from 0 to size x range is added; it ends with the fault
    noise       gaussian noise of rms size x range is added gain_step   the signal is multiplied by
    (1 + size) clock_slip  from its start the channel lags by `size` samples, `size` of which are
    repeated;
                at its end it catches up

All but the first two are silent: only the samples show them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from daq.chain.acquisition import Acquisition
from daq.chain.block import Block, Flag
from daq.chain.source import FloatArray

__all__ = ["KINDS", "BlockFault", "Faulted"]

KINDS = (
    "dropout",
    "cable_open",
    "stuck",
    "spike",
    "bias",
    "drift",
    "noise",
    "gain_step",
    "clock_slip",
)
FULL = 2**23  # codes at the end of the range
RAILS = np.uint16(Flag.OVERLOAD_HI | Flag.OVERLOAD_LO)

Codes = npt.NDArray[np.int32]


@dataclass(frozen=True)
class BlockFault:
    """One fault: `kind` of KINDS, in channel `row`, over the samples start..stop (stop excluded),
    with its `size`.
    """

    kind: str
    row: int
    start: int
    stop: int
    size: float = 0.0


class Faulted:
    """An acquisition with faults. Its output does not depend on the sizes of the reads.

    noise: one generator per fault, used by `noise` and `cable_open` only. floor: rms of each
    channel's own noise in codes, for `cable_open`. iepe: whether each input feeds its sensor.
    Faults are applied in the given order, clock slips first.
    """

    def __init__(
        self,
        acquisition: Acquisition,
        faults: Sequence[BlockFault],
        noise: Sequence[np.random.Generator],
        floor: Sequence[float],
        iepe: Sequence[bool],
    ) -> None:
        self._inner = acquisition
        # Slips first: they replace the codes by clean ones, and would undo any fault before them.
        order = sorted(range(len(faults)), key=lambda k: faults[k].kind != "clock_slip")
        self._faults = [(faults[k], noise[k]) for k in order]
        self._held: dict[BlockFault, float] = {}
        self._floor, self._iepe = tuple(floor), tuple(iepe)
        # Clean codes are kept as far back as the largest slip reaches, and at least one sample for
        # `stuck`.
        late = max(
            (round(abs(fault.size)) for fault in faults if fault.kind == "clock_slip"), default=0
        )
        self._before: Codes = np.zeros((len(acquisition.channels), max(late, 1)), dtype=np.int32)

    @property
    def channels(self) -> tuple[str, ...]:
        """Channel names in row order."""
        return self._inner.channels

    @property
    def rate(self) -> float:
        """Samples per second and channel, Hz."""
        return self._inner.rate

    def read(self, n: int) -> Block:
        """Return the next n samples of every channel, with the faults that overlap them."""
        block = self._inner.read(n)
        clean = np.concatenate([self._before, block.codes], axis=1)
        self._before = clean[:, -self._before.shape[1] :].copy()
        hit = [(fault, rng) for fault, rng in self._faults if _overlap(fault, block)]
        if not hit:
            return block
        # The inner acquisition may deliver the same arrays again.
        codes, flags, clipped = block.codes.copy(), block.flags.copy(), block.clipped.copy()
        for fault, rng in hit:
            first, last = max(fault.start - block.start, 0), min(fault.stop - block.start, n)
            row = codes[fault.row]
            row[first:last] = _rounded(
                self._faulty(fault, rng, row, clean[fault.row], first, last, block.start)
            )
            flags[fault.row] |= self._bit(fault)
        # A fault can push codes to a rail or away from it: overload is counted anew.
        for row in {fault.row for fault, _ in hit}:
            high, low = (int(np.count_nonzero(codes[row] == rail)) for rail in (FULL - 1, -FULL))
            flags[row] = (
                (flags[row] & ~RAILS) | Flag.OVERLOAD_HI * (high > 0) | Flag.OVERLOAD_LO * (low > 0)
            )
            clipped[row] = high + low
        return Block(block.start, codes, flags, clipped, block.settling)

    def _bit(self, fault: BlockFault) -> np.uint16:
        """Return the quality bit that shows the fault, 0 for a silent one."""
        if fault.kind == "dropout":
            return np.uint16(Flag.GAP)
        return np.uint16(
            Flag.IEPE_OPEN if fault.kind == "cable_open" and self._iepe[fault.row] else 0
        )

    def _faulty(
        self,
        fault: BlockFault,
        rng: np.random.Generator,
        row: Codes,
        clean: Codes,
        first: int,
        last: int,
        start: int,
    ) -> FloatArray:
        """Return the samples first..last of a block with the fault. clean: the channel without
        faults, preceded by `_before`.
        """
        seen, count, ahead = row[first:last].astype(np.float64), last - first, clean.size - row.size
        match fault.kind:
            case "dropout":
                return np.zeros(count)
            case "cable_open":
                return self._floor[fault.row] * rng.standard_normal(count)
            case "stuck":
                # The code before the fault, kept while the fault lasts over several blocks.
                held = self._held.setdefault(fault, float(clean[ahead + first - 1]))
                return np.full(count, held)
            case "spike" | "bias":
                return seen + fault.size * FULL
            case "drift":
                place = np.arange(start + first, start + last) - fault.start
                return seen + fault.size * FULL * (place / (fault.stop - fault.start))
            case "noise":
                return seen + fault.size * FULL * rng.standard_normal(count)
            case "gain_step":
                return seen * (1 + fault.size)
            case "clock_slip":
                late = round(fault.size)
                return clean[ahead + first - late : ahead + last - late].astype(np.float64)
            case _:
                raise ValueError(f"no fault {fault.kind!r}; there are {', '.join(KINDS)}")


def _overlap(fault: BlockFault, block: Block) -> bool:
    return fault.start < block.start + block.count and fault.stop > block.start


def _rounded(codes: FloatArray) -> FloatArray:
    """Return whole codes within the converter's rails."""
    return np.rint(np.clip(codes, -FULL, FULL - 1))
