"""The runs of a protocol's conditions: their order of execution and their numbers of samples."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from daq.chain.channel import AnalyzerSpec
from daq.random_streams import stream
from rig.protocol.spec import Condition, Protocol

BLOCK = 16384
"""Most samples per channel in one block."""


@dataclass(frozen=True)
class Run:
    """One run: its condition, its repeat and its position in the randomised order of execution,
    both counted from 1.
    """

    name: str
    condition: Condition
    repeat: int
    order: int


@dataclass(frozen=True)
class Lengths:
    """Size of a run's record.

    rate : output rate, Hz
    settle : samples per channel before the record
    samples : samples per channel in all
    blocks : samples per channel of each block, settling and record in blocks of their own
    """

    rate: float
    settle: int
    samples: int
    blocks: tuple[int, ...]


def runs(protocol: Protocol, conditions: Sequence[Condition]) -> tuple[Run, ...]:
    """Return a run for every condition and repeat, named in the order written.

    The order of execution is drawn from the protocol's seed, so that drift and wear of a session
    are not mistaken for an effect of the conditions.
    """
    count = len(conditions) * protocol.repeats.n
    order = stream(protocol.seed, "order").permutation(count) + 1
    pairs = [
        (condition, repeat)
        for condition in conditions
        for repeat in range(1, protocol.repeats.n + 1)
    ]
    return tuple(
        Run(f"run_{number:04d}", condition, repeat, int(order[number - 1]))
        for number, (condition, repeat) in enumerate(pairs, start=1)
    )


def lengths(condition: Condition, analyzer: AnalyzerSpec, filter_delay: float) -> Lengths:
    """Return rate and numbers of samples of a condition's record.

    The rate is the analyzer's slowest that gives the samples per cycle asked for. A triggered
    record gets one cycle more, because the trigger may come anywhere in a cycle.

    filter_delay : delay of the anti-alias filter, in samples
    """
    acquire, drive = condition.acquire, condition.drive
    rate = analyzer.rate_for(drive.fastest, acquire.samples_per_cycle)
    per_cycle = rate / drive.frequency
    settle = math.floor(acquire.settle * per_cycle + filter_delay)
    record = drive.swept_time(acquire.record) * drive.frequency  # in cycles of the first frequency
    samples = math.ceil((acquire.settle + record) * per_cycle + filter_delay) + 1
    if acquire.trigger.channel != "none":
        samples += math.ceil(per_cycle)  # whole cycles are read from the first that begins in it
    return Lengths(rate, settle, samples, (*_pieces(settle), *_pieces(samples - settle)))


def _pieces(samples: int) -> list[int]:
    """Return the sizes of the blocks that hold `samples` samples."""
    return [min(BLOCK, samples - start) for start in range(0, samples, BLOCK)]
