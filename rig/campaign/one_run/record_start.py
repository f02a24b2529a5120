"""Start of a record: with the motion, once the level is held, or at a trigger."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from daq.chain.acquisition import Acquisition
from daq.chain.block import Block
from daq.chain.trigger import NoTrigger, Triggered
from daq.faults.in_blocks import FULL
from rig.campaign.one_run.part import TRIGGER_SCALARS
from rig.errors import InputError, Mistake
from rig.protocol.schedule import Lengths, Run


class Beginning:
    """The blocks of a record, counted from 0, and the ledger from its first whole cycle on.

    lead : number of samples already read from the acquisition, whole cycles of the drive
    """

    def __init__(self, acquisition: Acquisition, run: Run, size: Lengths, lead: int) -> None:
        asked = run.condition.acquire.trigger
        self._period = size.rate / run.condition.drive.frequency
        self._lead = lead
        self._trigger: Triggered | None = None
        self._skip: int | None = 0
        self._acquisition = acquisition
        if asked.channel != "none":
            row = acquisition.channels.index(asked.channel)
            patience = math.ceil(asked.patience * self._period)
            self._trigger = Triggered(
                acquisition,
                row,
                asked.level * FULL,
                asked.slope,
                asked.kind,
                asked.before,
                patience,
            )
            self._acquisition, self._lead, self._skip = self._trigger, 0, None

    def read(self, samples: int) -> Block:
        """Return the next samples of the record. Raises InputError if it is never triggered."""
        try:
            block = self._acquisition.read(samples)
        except NoTrigger as error:
            found = f"a level that is not passed: {error}"
            raise InputError(
                Mistake("", "acquire.trigger", found, "a level that the channel reaches")
            ) from error
        return replace(block, start=block.start - self._lead) if self._lead else block

    def of_record(self, rows: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the ledger rows without those of cycles that started before the record."""
        if self._skip is None:
            self._skip = math.ceil(self.sample / self._period)
        dropped, self._skip = rows[: self._skip], max(self._skip - len(rows), 0)
        return rows[len(dropped) :]

    @property
    def sample(self) -> int:
        """Value of `TRIGGER_SCALARS`; 0 without a trigger."""
        return 0 if self._trigger is None or self._trigger.first is None else self._trigger.first

    def scalars(self) -> dict[str, float]:
        """Return the scalars that the analysis needs to find the drive's cycles."""
        return {TRIGGER_SCALARS[0]: float(self.sample)}
