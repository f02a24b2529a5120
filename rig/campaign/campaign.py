"""A protocol with every choice made, and nothing computed yet."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from rig.catalog.entries import Rig
from rig.protocol.schedule import Lengths, Run
from rig.protocol.spec import Condition, Protocol
from rig.stand.channels import Instruments
from rig.stand.ledger import COLUMNS, COUPLED_COLUMNS

if TYPE_CHECKING:
    from rig.fidelity.choice import Choice

Array = NDArray[np.float64]

LEVEL_OF = "acceleration"
"""The channel that the level control reads."""


@dataclass(frozen=True)
class Campaign:
    """A protocol with every choice made and nothing computed yet. Seeds hang on content: (seed, condition, repeat).

    ablate : let every run tell, in one more column of its ledger, what its bed would take in the exact waveform
    choices : what `fidelity: auto` chose, by condition; it stands in the conditions already
    """

    protocol: Protocol
    text: str
    rig: Rig
    conditions: tuple[Condition, ...]
    runs: tuple[Run, ...]
    lengths: dict[str, Lengths]
    instruments: Instruments
    ablate: bool = False
    choices: "Mapping[str, Choice]" = field(default_factory=dict)

    @property
    def averaged(self) -> dict[str, int]:
        """Cycles over which W_T averages rows without a period, where that was chosen, by condition."""
        return {name: choice.averaged for name, choice in self.choices.items()}

    @property
    def rig_time(self) -> float:
        """Seconds of motion that the whole protocol lasts."""
        once = sum(c.acquire.settle / c.drive.frequency + c.drive.swept_time(c.acquire.record) for c in self.conditions)
        return once * self.protocol.repeats.n

    @property
    def ledger_columns(self) -> tuple[str, ...]:
        """Columns of the ledgers: those of coupled drive where any condition has it."""
        columns = COUPLED_COLUMNS if self.coupled else COLUMNS
        if not self.ablate:
            return columns
        from analysis.session.ledger_columns import EXACT

        return (*columns, EXACT)

    @property
    def coupled(self) -> bool:
        """Whether any condition is in coupled drive."""
        return any(condition.drive.mode == "coupled" for condition in self.conditions)

    @property
    def recorded(self) -> bool:
        """Whether W_T is also computed on the recorded waveform: in coupled drive, and with an ablation, which takes
        causes apart."""
        return self.ablate or self.coupled

    @property
    def triggered(self) -> bool:
        """Whether a trigger starts the record of any condition."""
        return any(condition.acquire.trigger.channel != "none" for condition in self.conditions)
