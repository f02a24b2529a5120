"""A protocol with every choice made: what each run is, and its road from the stand to blocks of codes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from analysis.offset import EXACT
from daq.acquisition import Emulated
from daq.conditioning import conditioned
from daq.fir import OVERSAMPLING
from daq.frontend import FILTER_DELAY, FrontEnd
from daq.seeds import stream
from daq.source import PhysicalSource
from daq.transducer import Transduced
from rig.beds.stack import Filling, nominal, refill
from rig.campaign.ablation import exact_energy
from rig.campaign.fidelity import chosen
from rig.campaign.practice import seen, spoiled
from rig.campaign.ranging import auto_ranged
from rig.campaign.recorded import Listener
from rig.campaign.recording import Part
from rig.catalog.entries import Rig
from rig.drive.channels import WithExciter
from rig.drive.exciter import Demand, demand
from rig.drive.waveform import Waveform, waveform
from rig.fidelity.choice import Choice
from rig.instruments import Instruments, instruments
from rig.ledger import COLUMNS
from rig.plan import Lengths, Run, lengths, runs
from rig.scene import Condition, Protocol
from rig.stand import Stand

PASS_BAND = 0.45
"""Recorded band over the output rate: the anti-alias filter's pass band."""


@dataclass(frozen=True)
class Campaign:
    """A protocol with every choice made and nothing computed yet. Seeds hang on content: (seed, condition, repeat).

    ablate : let every run tell, in one more column of its ledger, what its bed would take in the exact waveform
    choices : what `fidelity: auto` chose, by condition; it stands in the conditions already
    """

    protocol: Protocol
    text: str
    rig: Rig
    conditions: tuple[Condition, ...]
    runs: tuple[Run, ...]
    lengths: dict[str, Lengths]
    instruments: Instruments
    ablate: bool = False
    choices: Mapping[str, Choice] = field(default_factory=dict)

    @classmethod
    def of(cls, protocol: Protocol, rig: Rig, text: str = "") -> "Campaign":
        """Resolve a protocol. Raises InputError for what does not fit together."""
        conditions = protocol.conditions()
        tools = instruments(conditions, rig, protocol.seed)
        rates = {c.id: lengths(c, tools.analyzer, FILTER_DELAY).rate for c in conditions}
        choices = {}
        if protocol.fidelity == "auto":
            choices = chosen(protocol, conditions, rig, auto_ranged(tools, conditions, rig, rates))
            conditions = tuple(choices[c.id].applied(c) for c in conditions)
        sizes = {c.id: lengths(c, tools.analyzer, FILTER_DELAY) for c in conditions}
        tools = auto_ranged(tools, conditions, rig, rates)
        spoilt = spoiled(tools, protocol.mistake)
        return cls(protocol, text, rig, conditions, runs(protocol, conditions), sizes, spoilt, choices=choices)

    @property
    def averaged(self) -> dict[str, int]:
        """Cycles over which W_T averages rows without a period, where that was chosen, by condition."""
        return {name: choice.averaged for name, choice in self.choices.items()}

    @property
    def rig_time(self) -> float:
        """Seconds of motion that the whole protocol lasts."""
        once = sum((c.acquire.settle + c.acquire.record) / c.drive.frequency for c in self.conditions)
        return once * self.protocol.repeats.n

    @property
    def ledger_columns(self) -> tuple[str, ...]:
        """Columns of the ledger that a run hands over."""
        return (*COLUMNS, EXACT) if self.ablate else COLUMNS

    @property
    def recorded(self) -> bool:
        """Whether W_T is also computed on the recorded waveform: with an ablation, which takes causes apart."""
        return self.ablate

    def motion(self, run: Run) -> Waveform:
        """The motion that the servo reaches in a run, on the analyzer's clock."""
        drive = run.condition.drive
        rng = None if drive.imperfection == "none" else self._stream(run, "drive")
        clock = 1.0 + self.instruments.clock_error
        return waveform(drive, self.rig.level_error, self.rig.third_harmonic, rng, clock)

    def filling(self, run: Run) -> Filling:
        """The bed of a run: poured anew for each repeat, or the nominal one."""
        scene = run.condition.scene
        if not self.protocol.repeats.refill:
            return nominal(scene, self.rig)
        return refill(scene, self.rig, self._stream(run, "refill"))

    def stand(self, run: Run) -> Stand:
        """The stand at the start of a run, sampled at the analyzer's actual oversampled rate."""
        rate = OVERSAMPLING * self.lengths[run.condition.id].rate * (1.0 + self.instruments.clock_error)
        return Stand(run.condition.scene, self.rig, self.motion(run), self.filling(run), rate)

    def demand(self, run: Run, stand: Stand) -> Demand:
        """What the stand's latest cycles ask of the exciter, within the recorded band."""
        band = PASS_BAND * self.lengths[run.condition.id].rate
        return demand(self.rig.exciter, stand.latest_force, stand.rate, stand.motion, band)

    def parts(self, run: Run) -> Iterator[Part]:
        """A run, block by block: stand, transducers, front end."""
        tools, size = self.instruments, self.lengths[run.condition.id]
        stand = self.stand(run)
        noise = [self._stream(run, channel.name) for channel in tools.channels]
        front = FrontEnd(tools.analyzer, tools.channels, tools.states, size.rate, noise, size.samples)
        source = seen(self._source(run, stand), self.protocol.mistake, run.condition, self.rig, stand.motion)
        analog = conditioned(Transduced(source, tools.states), tools.channels, tools.states)
        acquisition = Emulated(analog, front)
        wanted = run.condition.acquire.settle + run.condition.acquire.record
        listener = self._listener(run)
        for number, samples in enumerate(size.blocks):
            block = acquisition.read(samples)
            if listener is not None:
                listener.hear(block)
            last = number == len(size.blocks) - 1
            rows = self._ledger(run, stand)[:wanted]
            wanted -= len(rows)
            yield Part(run.name, block, rows, self._scalars(run, stand, listener) if last else None)

    def _listener(self, run: Run) -> Listener | None:
        """What predicts from the record of a run, where that is wanted."""
        if not self.recorded:
            return None
        size, tools = self.lengths[run.condition.id], self.instruments
        row = [channel.name for channel in tools.channels].index("acceleration")
        return Listener(run.condition, self.rig, size, row, tools.table(size.rate, FILTER_DELAY)[row])

    def _scalars(self, run: Run, stand: Stand, listener: Listener | None) -> dict[str, float]:
        """What a run ends with."""
        return self.demand(run, stand).scalars() | ({} if listener is None else listener.scalars())

    def _source(self, run: Run, stand: Stand) -> PhysicalSource:
        """The channels that are recorded of a stand."""
        return WithExciter(stand, self.instruments.exciter) if run.condition.acquire.exciter_channels else stand

    def _ledger(self, run: Run, stand: Stand) -> NDArray[np.float64]:
        rows = stand.drain_ledger()
        if not self.ablate:
            return rows
        condition = run.condition
        exact = exact_energy(condition.scene, self.rig, stand.motion, self.filling(run), condition.acquire)
        return np.column_stack([rows, np.full(len(rows), exact)])

    def _stream(self, run: Run, word: str) -> np.random.Generator:
        return stream(self.protocol.seed, run.condition.seed_key, str(run.repeat), word)
