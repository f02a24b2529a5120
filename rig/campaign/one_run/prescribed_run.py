"""A run in prescribed motion: its stand, its ledger, and its utilisation of the exciter."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from daq.chain.acquisition import Acquisition
from daq.chain.source import PhysicalSource
from rig.campaign.campaign import Campaign
from rig.campaign.one_run.part import LEVEL_SCALARS
from rig.campaign.one_run.run_inputs import filling_of, motion_of, oversampled_rate
from rig.drive.exciter_limits import Demand
from rig.protocol.schedule import Run
from rig.stand.exact_waveform import exact_energy
from rig.stand.exciter_channels import WithExciter
from rig.stand.force_peaks import beyond, steady, use_of, with_peaks_of
from rig.stand.ledger import COLUMNS, COUPLED_COLUMNS
from rig.stand.prescribed import Stand

Array = NDArray[np.float64]


class PrescribedRun:
    """The stand of a run, in motion from its first sample.

    motion : of the box
    source : its signals, including those of the exciter if the condition records them
    """

    def __init__(self, campaign: Campaign, run: Run) -> None:
        self._campaign, self._run = campaign, run
        self.motion = motion_of(campaign, run)
        self._stand = stand_of(campaign, run)
        self.source: PhysicalSource = self._stand
        if run.condition.acquire.exciter_channels:
            self.source = WithExciter(self._stand, campaign.instruments.exciter)

    def lead(self, _acquisition: Acquisition, _period: float) -> int:
        """Return the number of samples before the record: 0, the motion is there from the start."""
        return 0

    def ledger(self) -> Array:
        """Return the ledger rows of the cycles simulated since the last call, in the campaign's
        columns.
        """
        campaign, rows = self._campaign, self._stand.drain_ledger()
        missing = np.zeros(
            (len(rows), len(COUPLED_COLUMNS) - len(COLUMNS) if campaign.coupled else 0)
        )
        exact = [np.full(len(rows), self._exact)] if campaign.ablate else []
        return np.column_stack([rows, missing, *exact]) if campaign.coupled or exact else rows

    def scalars(self) -> dict[str, float]:
        """Return the utilisation of the exciter's limits."""
        found = self._demand().scalars()
        return found | dict.fromkeys(LEVEL_SCALARS, 0.0) if self._campaign.coupled else found

    def _demand(self) -> Demand:
        """Return the utilisation of the exciter by the latest cycles, within the recorded band.

        If `fidelity: auto` chose few rows, which hit simultaneously, and their peaks exceed a
        limit, the peaks are those of the same filling with all its rows.
        """
        campaign, run, stand = self._campaign, self._run, self._stand
        use = use_of(campaign.rig, stand)
        if run.condition.id not in campaign.choices or not beyond(use):
            return use
        from rig.fidelity.scene_rows import (
            side_by_side,
        )  # only some protocols choose their fidelity

        scene = side_by_side(run.condition.scene)
        full = Stand(
            scene, campaign.rig, stand.motion, filling_of(campaign, run, scene), stand.rate
        )
        return with_peaks_of(use, use_of(campaign.rig, steady(full)))

    @cached_property
    def _exact(self) -> float:
        """Return the energy that the bed would dissipate on an exact sine of the level reached, J
        per cycle.
        """
        condition = self._run.condition
        filling = filling_of(self._campaign, self._run)
        return exact_energy(
            condition.scene, self._campaign.rig, self.motion, filling, condition.acquire
        )


def stand_of(campaign: Campaign, run: Run) -> Stand:
    """Return the stand at the start of a run with prescribed motion."""
    motion, filling = motion_of(campaign, run), filling_of(campaign, run)
    return Stand(
        run.condition.scene, campaign.rig, motion, filling, oversampled_rate(campaign, run)
    )
