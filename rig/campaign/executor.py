"""Where the runs of a campaign are computed: the one interface, whatever computes them."""

from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager
from typing import Protocol

from daq.clock import Overrun, Pacer
from rig.campaign.recording import Part
from rig.campaign.setup import Campaign
from rig.plan import Run


class WorkerLost(Exception):
    """All that computed has been ended from outside; the message names the runs that were under way."""


class WorkerFailed(RuntimeError):
    """A defect: the message holds the worker's traceback."""


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
        iteration: what `computed` raises, as it was raised; WorkerLost where nothing is left that computes;
        WorkerFailed for a defect. Nothing that is lost is waited for.
        """
        ...


def computed(campaign: Campaign, run: Run, speed: float | None) -> Iterator[Part]:
    """Compute the parts of a run, held to `speed` (rig seconds per wall second, None: as fast as possible).

    Raises InputError, MemoryError, and Overrun after the part that came too late.
    """
    pacer = Pacer(campaign.lengths[run.condition.id].rate, speed)
    for part in campaign.parts(run):
        try:
            pacer.wait(part.block.start + part.block.count)
        except Overrun:
            yield part.late()
            raise
        yield part.ended(pacer.punctuality)
