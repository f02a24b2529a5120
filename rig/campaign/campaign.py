"""A fully resolved protocol, before anything is computed."""

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
    from rig.fidelity.choice import FidelityChoice

Array = NDArray[np.float64]

LEVEL_OF = "acceleration"
"""The channel that is used for level control."""


@dataclass(frozen=True)
class Campaign:
    """A fully resolved protocol, before anything is computed. Seeds depend on content: (seed,
    condition, repeat).

    ablate : whether every run adds a ledger column with the energy of its bed in the exact waveform
    choices : results of `fidelity: auto` by condition, already applied to `conditions`
    """

    protocol: Protocol
    text: str
    rig: Rig
    conditions: tuple[Condition, ...]
    runs: tuple[Run, ...]
    lengths: dict[str, Lengths]
    instruments: Instruments
    ablate: bool = False
    choices: "Mapping[str, FidelityChoice]" = field(default_factory=dict)

    @property
    def averaged(self) -> dict[str, int]:
        """Cycles over which W_T averages rows without a period, by condition, if chosen."""
        return {name: choice.averaged for name, choice in self.choices.items()}

    @property
    def rig_time(self) -> float:
        """Total duration of motion of the whole protocol, s."""
        once = sum(
            c.acquire.settle / c.drive.frequency + c.drive.swept_time(c.acquire.record)
            for c in self.conditions
        )
        return once * self.protocol.repeats.n

    @property
    def ledger_columns(self) -> tuple[str, ...]:
        """Columns of the ledgers: those of shaker-coupled drive if any condition has it."""
        columns = COUPLED_COLUMNS if self.coupled else COLUMNS
        if not self.ablate:
            return columns
        from analysis.session.ledger_columns import EXACT

        return (*columns, EXACT)

    @property
    def coupled(self) -> bool:
        """Whether any condition is in shaker-coupled drive."""
        return any(condition.drive.mode == "shaker" for condition in self.conditions)

    @property
    def recorded(self) -> bool:
        """Whether W_T is also computed on the recorded waveform: in shaker-coupled drive,
        and for an ablation, which separates causes.
        """
        return self.ablate or self.coupled

    @property
    def triggered(self) -> bool:
        """Whether a trigger starts the record of any condition."""
        return any(condition.acquire.trigger.channel != "none" for condition in self.conditions)
