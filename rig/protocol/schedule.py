"""From a protocol's conditions to its runs: their order, and the samples of each."""

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
    """One run: a condition, its repeat (from 1) and its place in the randomised order of execution
    (from 1).
    """

    name: str
    condition: Condition
    repeat: int
    order: int


@dataclass(frozen=True)
class Lengths:
    """A run's record: output rate in Hz, samples per channel before and in all, and the sizes of
    its blocks.
    """

    rate: float
    settle: int
    samples: int
    blocks: tuple[int, ...]


def runs(protocol: Protocol, conditions: Sequence[Condition]) -> tuple[Run, ...]:
    """Every condition x repeat, named in the order written; the order of execution is drawn from
    the seed.
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
    """Rate and samples of a condition: the slowest listed rate that gives the samples per cycle
    that were asked for; a cycle more where a trigger starts the record anywhere in one."""
    acquire, drive = condition.acquire, condition.drive
    rate = analyzer.rate_for(drive.fastest, acquire.samples_per_cycle)
    per_cycle = rate / drive.frequency
    settle = math.floor(acquire.settle * per_cycle + filter_delay)
    record = drive.swept_time(acquire.record) * drive.frequency  # in cycles of the first frequency
    samples = math.ceil((acquire.settle + record) * per_cycle + filter_delay) + 1
    if acquire.trigger.channel != "none":
        samples += math.ceil(per_cycle)  # whole cycles from the first that starts after the record
    return Lengths(rate, settle, samples, (*_pieces(settle), *_pieces(samples - settle)))


def _pieces(samples: int) -> list[int]:
    return [min(BLOCK, samples - start) for start in range(0, samples, BLOCK)]
