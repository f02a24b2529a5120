"""Parts of a run, wherever it is computed: blocks with their ledger rows, and after the last block the
run's scalars.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from daq.chain.block import Block, Flag
from daq.chain.clock import NEVER_LATE, Overrun, Pacer, Punctuality

# Names of the scalars of a run, except the utilisation of the exciter's limits.
STOPS = ("force", "current", "voltage", "stroke", "jump", "time")
"""Reasons for not reaching a level: a limit of the exciter, a level that no command
holds, timeout.
"""

LEVEL_SCALARS = (
    "level_cycles",
    "level_jumps",
    "clipped",
    *(f"stopped_by_{name}" for name in STOPS),
)
"""Shaker-coupled drive: cycles of the level control; jumps of the level on the way; fraction
of the held cycles in which the amplifier was at a limit; and for each reason 1 if it stopped the
level, 0 otherwise.
"""

RECORDED_SCALARS = ("W_T_recorded", "W_f_recorded", "u_W_T_recorded")
"""The prediction on the recorded waveform, J per cycle, with the start of the run's own drive
(`predict_on_record`), and its standard uncertainty due to the bed's history: the difference to the
other start is taken as the width of a rectangular distribution.
"""

TRIGGER_SCALARS = ("trigger_sample",)
"""Samples from a start of the drive's cycle to the record's first sample."""


@dataclass(frozen=True)
class Part:
    """A block of a run, with its ledger rows.

    The last part of a run also has its scalars and flags, and the punctuality of its blocks.
    """

    run: str
    block: Block
    ledger: NDArray[np.float64]
    scalars: Mapping[str, float] | None = None
    flags: int = 0
    punctuality: Punctuality = NEVER_LATE

    @property
    def ends(self) -> bool:
        """Whether it is the last of its run."""
        return self.scalars is not None

    def ended(self, punctuality: Punctuality) -> "Part":
        """Return the part with the punctuality of the run's blocks, if it is the last
        of the run.
        """
        return self if self.scalars is None else replace(self, punctuality=punctuality)

    def late(self) -> "Part":
        """Return the part as recorded if it came too late: flagged, and the run not complete."""
        return replace(
            self,
            block=replace(self.block, flags=self.block.flags | np.uint16(Flag.OVERRUN)),
            scalars=None,
        )


def paced(parts: Iterable[Part], rate: float, speed: float | None) -> Iterator[Part]:
    """Pace the parts of a run at `rate` (S/s) to `speed`: rig seconds per wall second, None as fast
    as possible.

    Raises the exceptions of their computation, and Overrun after the part that came too late.
    """
    pacer = Pacer(rate, speed)
    for part in parts:
        try:
            pacer.wait(part.block.start + part.block.count)
        except Overrun:
            yield part.late()
            raise
        yield part.ended(pacer.punctuality)
