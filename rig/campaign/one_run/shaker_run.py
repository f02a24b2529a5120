"""A run with the exciter in the loop: start-up, ledger, and how its level was reached."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from daq.chain.acquisition import Acquisition
from rig.campaign.campaign import LEVEL_OF, Campaign
from rig.campaign.one_run.coupled_dwell import Dwelling, Picked
from rig.campaign.one_run.run_inputs import filling_of, oversampled_rate
from rig.protocol.schedule import Run

Array = NDArray[np.float64]


class ShakerRun:
    """The dwell of a run, initially at rest. source : its signals."""

    def __init__(self, campaign: Campaign, run: Run) -> None:
        tools = campaign.instruments
        channel, state = next(
            (c, s) for c, s in zip(tools.channels, tools.states, strict=True) if c.name == LEVEL_OF
        )
        # The controller reads the same accelerometer with its certified sensitivity: its actual
        # errors enter.
        reading = state.sensitivity * state.gain / channel.transducer.sensitivity
        rate, clock = oversampled_rate(campaign, run), 1.0 + tools.clock_error
        rig = replace(campaign.rig, exciter=tools.exciter)
        self._ablate = campaign.ablate
        self._dwelling = Dwelling(
            run.condition, rig, filling_of(campaign, run), rate, clock, reading
        )
        self.source = Picked(self._dwelling.stand, len(tools.channels))

    def lead(self, acquisition: Acquisition, period: float) -> int:
        """Read cycle by cycle until the level is held, and return the number of samples read.

        The instruments have been on since the start-up. period : samples per cycle
        """
        dwell, cycles, done = self._dwelling.dwell, 0, 0
        while dwell.steady_from is None or cycles < dwell.steady_from:
            cycles += 1
            acquisition.read(round(cycles * period) - done)
            done = round(cycles * period)
        return done

    def ledger(self) -> Array:
        """Return the ledger rows of the held cycles simulated since the last call, in the
        campaign's columns.
        """
        rows = self._dwelling.ledger()
        return np.column_stack([rows, np.full(len(rows), np.nan)]) if self._ablate else rows

    def scalars(self) -> dict[str, float]:
        """Return the utilisation of the exciter's limits, and how the level was reached."""
        return self._dwelling.scalars()
