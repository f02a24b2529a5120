"""Where the runs of a campaign are computed: the one interface, whatever computes them."""

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from typing import Protocol

from rig.campaign.campaign import Campaign
from rig.campaign.one_run.part import Part
from rig.protocol.schedule import Run


class Executor(Protocol):
    """Computes runs somewhere: in processes of this machine (`rig.campaign.workers`), or on other machines.

    What it gives hangs on the campaign and the runs alone. tests/conformance/test_executors.py holds every
    implementation to that.
    """

    def started(
        self, campaign: Campaign, waiting: Sequence[Run], speed: float | None
    ) -> AbstractContextManager[Iterator[Part]]:
        """Start on the waiting runs, in their order; give their parts, and end all work after the block.

        Every part comes once, each run's in order; the runs may come interleaved. A run whose worker is lost is
        computed again and goes on after the part that came last: it is the same run, to the byte. Raised from the
        iteration: what `paced` raises, as it was raised; WorkerLost where nothing is left that computes;
        WorkerFailed for a defect. Nothing that is lost is waited for.
        """
        ...
