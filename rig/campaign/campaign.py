"""A protocol with every choice made: what each run is, and its road from the stand to blocks of codes.

What only some protocols need (exciter in the loop, choice of fidelity, W_T on the record) is loaded where it is used:
its kernels take a quarter of the time that the imports of a run in servo drive would take.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from daq.chain.acquisition import Emulated
from daq.chain.conditioning import conditioned
from daq.chain.fir import OVERSAMPLING
from daq.chain.frontend import FILTER_DELAY, FrontEnd
from daq.chain.source import PhysicalSource
from daq.chain.transducer import Transduced
from daq.random_streams import stream
from rig.beds.janssen_stack import Filling, nominal, refill
from rig.campaign.one_run.deliberate_errors import seen
from rig.campaign.one_run.faults import with_faults
from rig.campaign.one_run.loop_back import LoopBack, inputs_alone
from rig.campaign.one_run.part import Part
from rig.campaign.one_run.record_start import Beginning
from rig.catalog.entries import Rig
from rig.drive.exciter_limits import Demand
from rig.drive.waveform import Waveform, waveform
from rig.protocol.schedule import Lengths, Run
from rig.protocol.spec import LOOP_BACK, Condition, Protocol, Scene
from rig.stand.channels import Instruments
from rig.stand.exact_waveform import exact_energy
from rig.stand.exciter_channels import WithExciter
from rig.stand.force_peaks import beyond, steady, use_of, with_peaks_of
from rig.stand.ledger import COLUMNS, COUPLED_COLUMNS
from rig.stand.prescribed import Stand

if TYPE_CHECKING:
    from rig.campaign.one_run.coupled_dwell import Dwelling
    from rig.campaign.one_run.predict_on_record import Listener
    from rig.fidelity.choice import Choice

Array = NDArray[np.float64]

LEVEL_OF = "acceleration"
"""The channel that the level control reads."""


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
    choices: "Mapping[str, Choice]" = field(default_factory=dict)

    @property
    def averaged(self) -> dict[str, int]:
        """Cycles over which W_T averages rows without a period, where that was chosen, by condition."""
        return {name: choice.averaged for name, choice in self.choices.items()}

    @property
    def rig_time(self) -> float:
        """Seconds of motion that the whole protocol lasts."""
        once = sum(c.acquire.settle / c.drive.frequency + c.drive.swept_time(c.acquire.record) for c in self.conditions)
        return once * self.protocol.repeats.n

    @property
    def ledger_columns(self) -> tuple[str, ...]:
        """Columns of the ledgers: those of coupled drive where any condition has it."""
        columns = COUPLED_COLUMNS if self.coupled else COLUMNS
        if not self.ablate:
            return columns
        from analysis.session.ledger_columns import EXACT

        return (*columns, EXACT)

    @property
    def coupled(self) -> bool:
        """Whether any condition is in coupled drive."""
        return any(condition.drive.mode == "coupled" for condition in self.conditions)

    @property
    def recorded(self) -> bool:
        """Whether W_T is also computed on the recorded waveform: in coupled drive, and with an ablation, which takes
        causes apart."""
        return self.ablate or self.coupled

    @property
    def triggered(self) -> bool:
        """Whether a trigger starts the record of any condition."""
        return any(condition.acquire.trigger.channel != "none" for condition in self.conditions)

    def motion(self, run: Run) -> Waveform:
        """The motion that the servo reaches in a run, on the analyzer's clock."""
        drive = run.condition.drive
        rng = None if drive.imperfection == "none" else self._stream(run, "drive")
        clock = 1.0 + self.instruments.clock_error
        return waveform(drive, self.rig.level_error, self.rig.third_harmonic, rng, clock)

    def filling(self, run: Run, scene: Scene | None = None) -> Filling:
        """The bed of a run: poured anew for each repeat, or the nominal one. `scene` : with other rows."""
        scene = scene or run.condition.scene
        if not self.protocol.repeats.refill:
            return nominal(scene, self.rig)
        return refill(scene, self.rig, self._stream(run, "refill"))

    def stand(self, run: Run) -> Stand:
        """The stand at the start of a run, sampled at the analyzer's actual oversampled rate."""
        rate = OVERSAMPLING * self.lengths[run.condition.id].rate * (1.0 + self.instruments.clock_error)
        return Stand(run.condition.scene, self.rig, self.motion(run), self.filling(run), rate)

    def demand(self, run: Run, stand: Stand) -> Demand:
        """What the stand's latest cycles ask of the exciter, within the recorded band.

        Where `fidelity: auto` found few rows, which hit together, and their peaks exceed a limit, those of the same
        filling with all its rows are told instead.
        """
        use = use_of(self.rig, stand)
        if run.condition.id not in self.choices or not beyond(use):
            return use
        from rig.fidelity.scene_rows import side_by_side

        scene = side_by_side(run.condition.scene)
        full = Stand(scene, self.rig, stand.motion, self.filling(run, scene), stand.rate)
        return with_peaks_of(use, use_of(self.rig, steady(full)))

    def dwelling(self, run: Run) -> "Dwelling":
        """The dwell of a run in coupled drive, at rest."""
        from rig.campaign.one_run.coupled_dwell import Dwelling

        tools, clock = self.instruments, 1.0 + self.instruments.clock_error
        channel, state = next((c, s) for c, s in zip(tools.channels, tools.states, strict=True) if c.name == LEVEL_OF)
        rate = OVERSAMPLING * self.lengths[run.condition.id].rate * clock
        reading = state.sensitivity * state.gain / channel.transducer.sensitivity
        rig = replace(self.rig, exciter=tools.exciter)
        return Dwelling(run.condition, rig, self.filling(run), rate, clock, reading)

    def parts(self, run: Run) -> Iterator[Part]:
        """A run, block by block: stand, transducers, front end."""
        size = self.lengths[run.condition.id]
        road: Servo | Coupled = Coupled(self, run) if run.condition.drive.mode == "coupled" else Servo(self, run)
        steady = self._acquisition(run, road.source)
        lead = road.lead(steady, size.rate / run.condition.drive.frequency)
        faulty = with_faults(steady, self.protocol, run, self.instruments, size, lead)
        beginning = Beginning(faulty, run, size, lead)
        wanted = run.condition.acquire.settle + run.condition.acquire.record
        listener = self._listener(run)
        silent = self._not_heard() if self.recorded else {}
        for number, samples in enumerate(size.blocks):
            block = beginning.read(samples)
            if listener is not None:
                listener.hear(block)
            rows = beginning.of_record(road.ledger())[:wanted]
            wanted -= len(rows)
            if number < len(size.blocks) - 1:
                yield Part(run.name, block, rows)
            else:
                found = [road.scalars(), beginning.scalars() if self.triggered else {}]
                yield Part(
                    run.name, block, rows, {**found[0], **found[1], **(listener.scalars() if listener else silent)}
                )

    def led(self, run: Run, source: PhysicalSource) -> PhysicalSource:
        """What is led to the instruments: the stand's signals, or in a loop-back the generator's voltage."""
        if run.condition.scene.bed != LOOP_BACK:
            return source
        rate = self.lengths[run.condition.id].rate
        return LoopBack(source, self.instruments, run.condition.drive.frequency, rate)

    def _acquisition(self, run: Run, source: PhysicalSource) -> Emulated:
        """Transducers and front end of a run."""
        tools, size = self.instruments, self.lengths[run.condition.id]
        if run.condition.scene.bed == LOOP_BACK:
            tools = inputs_alone(tools)
        noise = [self._stream(run, channel.name) for channel in tools.channels]
        front = FrontEnd(tools.analyzer, tools.channels, tools.states, size.rate, noise, size.samples)
        return Emulated(conditioned(Transduced(source, tools.states), tools.channels, tools.states), front)

    def _listener(self, run: Run) -> "Listener | None":
        """What predicts from the record of a run, where that is wanted."""
        if not self.recorded or run.condition.drive.sweep_to is not None:
            return None
        from rig.campaign.one_run.predict_on_record import Listener

        size, tools = self.lengths[run.condition.id], self.instruments
        row = [channel.name for channel in tools.channels].index(LEVEL_OF)
        return Listener(run.condition, self.rig, size, row, tools.table(size.rate, FILTER_DELAY)[row])

    def _not_heard(self) -> dict[str, float]:
        """Scalars of a run that nothing listened to."""
        from rig.campaign.one_run.predict_on_record import NAMES

        return dict.fromkeys(NAMES, float("nan"))

    def exact(self, run: Run, motion: Waveform) -> float:
        """J per cycle that the bed of a run would take on an exact sine of the level reached."""
        condition = run.condition
        return exact_energy(condition.scene, self.rig, motion, self.filling(run), condition.acquire)

    def _stream(self, run: Run, word: str) -> np.random.Generator:
        return stream(self.protocol.seed, run.condition.seed_key, str(run.repeat), word)


class Servo:
    """A run in servo drive: what is recorded, its ledger, and what it ends with."""

    def __init__(self, campaign: Campaign, run: Run) -> None:
        self._campaign, self._run = campaign, run
        self._stand = campaign.stand(run)
        stand, rig = self._stand, campaign.rig
        four = run.condition.acquire.exciter_channels
        source = WithExciter(stand, campaign.instruments.exciter) if four else stand
        self.source = seen(campaign.led(run, source), campaign.protocol.mistake, run.condition, rig, stand.motion)

    def lead(self, _acquisition: Emulated, _period: float) -> int:
        """Samples before the record: none, the motion is there from the start."""
        return 0

    def ledger(self) -> Array:
        """Rows of the cycles simulated since the last call."""
        rows = self._stand.drain_ledger()
        campaign = self._campaign
        missing = np.zeros((len(rows), len(COUPLED_COLUMNS) - len(COLUMNS) if campaign.coupled else 0))
        exact = [np.full(len(rows), campaign.exact(self._run, self._stand.motion))] if campaign.ablate else []
        return np.column_stack([rows, missing, *exact]) if campaign.coupled or exact else rows

    def scalars(self) -> dict[str, float]:
        """Use of the exciter's limits."""
        found = self._campaign.demand(self._run, self._stand).scalars()
        if not self._campaign.coupled:
            return found
        from rig.campaign.one_run.coupled_dwell import LEVEL_SCALARS

        return found | dict.fromkeys(LEVEL_SCALARS, 0.0)


class Coupled:
    """A run in coupled drive: what is recorded, its ledger, and what it ends with."""

    def __init__(self, campaign: Campaign, run: Run) -> None:
        from rig.campaign.one_run.coupled_dwell import Picked

        self._campaign, self._run = campaign, run
        self._dwelling = campaign.dwelling(run)
        self.source = campaign.led(run, Picked(self._dwelling.stand, len(campaign.instruments.channels)))

    def lead(self, acquisition: Emulated, period: float) -> int:
        """Reads on, cycle by cycle, until the level is held; gives the samples read. The instruments have been on since
        the start-up; `period` : samples per cycle."""
        dwell, cycles, done = self._dwelling.dwell, 0, 0
        while dwell.steady_from is None or cycles < dwell.steady_from:
            cycles += 1
            acquisition.read(round(cycles * period) - done)
            done = round(cycles * period)
        return done

    def ledger(self) -> Array:
        """Rows of the held cycles simulated since the last call."""
        rows = self._dwelling.ledger()
        return np.column_stack([rows, np.full(len(rows), np.nan)]) if self._campaign.ablate else rows

    def scalars(self) -> dict[str, float]:
        """Use of the exciter's limits, and how the level was reached."""
        return self._dwelling.scalars()
