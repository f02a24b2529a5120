"""A protocol's faults, applied to the blocks of a run."""

import math
from dataclasses import replace

from daq.chain.acquisition import Acquisition
from daq.chain.frontend import FILTER_DELAY
from daq.faults.in_blocks import BlockFault, Faulted
from daq.random_streams import stream
from rig.protocol.faults import Fault as Asked
from rig.protocol.schedule import Lengths, Run
from rig.protocol.spec import Protocol
from rig.stand.channels import Instruments


def with_faults(
    acquisition: Acquisition,
    protocol: Protocol,
    run: Run,
    tools: Instruments,
    size: Lengths,
    lead: int,
) -> Acquisition:
    """Return the acquisition with the protocol's faults for this run; the acquisition itself if
    there are none.

    lead : number of samples read before the record, which have no faults

    Each fault has a random stream of its own, by kind, channel and start: an additional fault
    changes no other.
    """
    names, period = acquisition.channels, size.rate / run.condition.drive.frequency
    found: list[tuple[Asked, BlockFault]] = []
    for asked in protocol.faults:
        if asked.channel not in names or asked.repeat not in (None, run.repeat):
            continue
        fault = _placed(asked, names.index(asked.channel), period, size.samples)
        if fault.start < size.samples:
            found.append((asked, fault))
    if not found:
        return acquisition
    words = (run.condition.seed_key, str(run.repeat), "fault")
    noise = [stream(protocol.seed, *words, a.kind, a.channel, repr(a.start)) for a, _ in found]
    spec, channels = tools.analyzer, tools.channels
    late = [replace(fault, start=fault.start + lead, stop=fault.stop + lead) for _, fault in found]
    floor = [
        spec.noise_in_band(c.range_V, size.rate) / spec.volts_per_code(c.range_V) for c in channels
    ]
    iepe = [channel.coupling == "IEPE" for channel in channels]
    return Faulted(acquisition, late, noise, floor, iepe)


def _placed(asked: Asked, row: int, period: float, samples: int) -> BlockFault:
    """Return a fault in samples of the record: sample n shows drive time (n -
    FILTER_DELAY) / rate.
    """
    start = math.ceil(asked.start * period + FILTER_DELAY)
    if asked.duration is not None:
        stop = max(math.ceil((asked.start + asked.duration) * period + FILTER_DELAY), start + 1)
    else:
        stop = start + 1 if asked.kind == "spike" else samples
    return BlockFault(asked.kind, row, start, stop, asked.size)
