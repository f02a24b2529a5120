"""The signal chain of one run, link by link: stand, transducers, front end, ADC blocks."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from daq.chain.acquisition import Emulated
from daq.chain.conditioning import conditioned
from daq.chain.frontend import FILTER_DELAY, FrontEnd
from daq.chain.source import PhysicalSource
from daq.chain.transducer import Transduced
from rig.campaign.campaign import LEVEL_OF, Campaign
from rig.campaign.one_run.deliberate_errors import with_signal_error
from rig.campaign.one_run.faults import with_faults
from rig.campaign.one_run.loop_back import LoopBackSource, inputs_alone
from rig.campaign.one_run.part import RECORDED_SCALARS, Part
from rig.campaign.one_run.prescribed_run import PrescribedRun
from rig.campaign.one_run.record_start import Beginning
from rig.campaign.one_run.run_inputs import random_stream
from rig.protocol.schedule import Run
from rig.protocol.spec import LOOP_BACK

if TYPE_CHECKING:
    from rig.campaign.one_run.predict_on_record import Listener
    from rig.campaign.one_run.shaker_run import ShakerRun


def assemble(campaign: Campaign, run: Run) -> Iterator[Part]:
    """Yield the parts of a run, block by block."""
    protocol, condition, tools = campaign.protocol, run.condition, campaign.instruments
    size = campaign.lengths[condition.id]
    period = size.rate / condition.drive.frequency

    # The stand: force and acceleration of the box, oversampled.
    stand = _stand(campaign, run)
    source: PhysicalSource = stand.source

    # The input of the instruments: the stand's signals or, in a loop-back, one voltage at all
    # inputs.
    if condition.scene.bed == LOOP_BACK:
        source, tools = (
            LoopBackSource(source, tools, condition.drive.frequency, size.rate),
            inputs_alone(tools),
        )
    if isinstance(stand, PrescribedRun):
        source = with_signal_error(
            source, protocol.deliberate_error, condition, campaign.rig, stand.motion
        )

    # Transducers and conditioning convert it to volts, the front end to codes.
    noise = [random_stream(campaign, run, channel.name) for channel in tools.channels]
    volts = conditioned(Transduced(source, tools.states), tools.channels, tools.states)
    front = FrontEnd(tools.analyzer, tools.channels, tools.states, size.rate, noise, size.samples)
    analyzer = Emulated(volts, front)

    # The record starts when the level is held, or at a trigger; faults occur in the record only.
    lead = stand.lead(analyzer, period)
    faulty = with_faults(analyzer, protocol, run, campaign.instruments, size, lead)
    record = Beginning(faulty, run, size, lead)
    listener = _listener(campaign, run)

    cycles = condition.acquire.settle + condition.acquire.record
    for number, samples in enumerate(size.blocks, start=1):
        block = record.read(samples)
        if listener is not None:
            listener.hear(block)
        rows = record.of_record(stand.ledger())[:cycles]
        cycles -= len(rows)
        if number < len(size.blocks):
            yield Part(run.name, block, rows)
            continue
        scalars = stand.scalars()
        if campaign.triggered:
            scalars |= record.scalars()
        if listener is not None:
            scalars |= listener.scalars()
        elif campaign.recorded:
            scalars |= dict.fromkeys(RECORDED_SCALARS, float("nan"))
        yield Part(run.name, block, rows, scalars)


def _stand(campaign: Campaign, run: Run) -> "PrescribedRun | ShakerRun":
    """Return the stand of a run, by its drive."""
    if run.condition.drive.mode != "shaker":
        return PrescribedRun(campaign, run)
    from rig.campaign.one_run.shaker_run import (
        ShakerRun,
    )  # its kernels are loaded where a drive asks for them

    return ShakerRun(campaign, run)


def _listener(campaign: Campaign, run: Run) -> "Listener | None":
    """Return the predictor of W_T from the record of a run; None if it is not wanted."""
    if not campaign.recorded or run.condition.drive.sweep_to is not None:
        return None
    from rig.campaign.one_run.predict_on_record import Listener

    size, tools = campaign.lengths[run.condition.id], campaign.instruments
    row = [channel.name for channel in tools.channels].index(LEVEL_OF)
    return Listener(
        run.condition, campaign.rig, size, row, tools.table(size.rate, FILTER_DELAY)[row]
    )
