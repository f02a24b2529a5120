"""The composition root: conditions on workers, recorded by one writer, analysed from the record, resumed.

Workers only compute: each takes the next run in order, streams its blocks into a bounded queue and never sees the
file. The calling thread writes what arrives and analyses each run as soon as it is recorded, so that memory does not
grow with the length of a record and nothing depends on the number of workers.
"""

import queue
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from analysis import RunEnergy, read_session, run_energy, write_report
from daq.acquisition import Emulated
from daq.block import Block
from daq.clock import Pacer
from daq.fir import OVERSAMPLING
from daq.frontend import FILTER_DELAY, FrontEnd
from daq.seeds import stream
from daq.session import Recorder, RunPlan, SessionPlan
from daq.transducer import Transduced
from rig.beds.stack import Filling, nominal, refill
from rig.catalog.entries import Rig
from rig.drive.exciter import Demand, demand
from rig.drive.waveform import Waveform, waveform
from rig.instruments import Instruments, instruments
from rig.ledger import COLUMNS
from rig.plan import Lengths, Run, condition_facts, lengths, prediction_document, predictions, runs
from rig.protocol import dump_protocol
from rig.provenance import now, provenance
from rig.scene import Condition, Protocol
from rig.stand import Stand

QUEUED_PARTS = 4
"""Parts of runs per worker that may wait for the writer."""

PASS_BAND = 0.45
"""Recorded band over the output rate: the anti-alias filter's pass band."""

SCALARS = tuple(Demand(*(0.0,) * 6).scalars())


@dataclass(frozen=True)
class Progress:
    """A run has been recorded and analysed, `done` of `total`."""

    run: Run
    done: int
    total: int
    energy: RunEnergy


@dataclass(frozen=True)
class Part:
    """What a worker hands the writer: a block of a run, with the ledger rows of the cycles simulated since the last."""

    run: Run
    block: Block
    ledger: np.ndarray[Any, np.dtype[np.float64]]
    demand: Demand | None = None


@dataclass(frozen=True)
class Campaign:
    """A protocol with every choice made and nothing computed yet. Seeds hang on content: (seed, condition, repeat)."""

    protocol: Protocol
    text: str
    rig: Rig
    conditions: tuple[Condition, ...]
    runs: tuple[Run, ...]
    lengths: dict[str, Lengths]
    instruments: Instruments

    @classmethod
    def of(cls, protocol: Protocol, rig: Rig, text: str = "") -> "Campaign":
        """Resolve a protocol. Raises InputError for what does not fit together."""
        conditions = protocol.conditions()
        tools = instruments(conditions, rig, protocol.seed)
        sizes = {c.id: lengths(c, tools.analyzer, FILTER_DELAY) for c in conditions}
        return cls(protocol, text, rig, conditions, runs(protocol, conditions), sizes, tools)

    @property
    def rig_time(self) -> float:
        """Seconds of motion that the whole protocol lasts."""
        once = sum((c.acquire.settle + c.acquire.record) / c.drive.frequency for c in self.conditions)
        return once * self.protocol.repeats.n

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
        front = FrontEnd(tools.analyzer, tools.channels, tools.states, size.rate, noise)
        acquisition = Emulated(Transduced(stand, tools.states), front)
        for number, samples in enumerate(size.blocks):
            block = acquisition.read(samples)
            last = number == len(size.blocks) - 1
            yield Part(run, block, stand.drain_ledger(), self.demand(run, stand) if last else None)

    def _stream(self, run: Run, word: str) -> np.random.Generator:
        return stream(self.protocol.seed, run.condition.seed_key, str(run.repeat), word)


def session_plan(campaign: Campaign, workers: int) -> SessionPlan:
    """Everything that a session file holds except the samples."""
    found = predictions(campaign.conditions, campaign.rig, workers)
    tools, protocol, created = campaign.instruments, campaign.protocol, now()
    facts = [
        condition_facts(c, campaign.rig, found[c.id][0], campaign.lengths[c.id].rate) for c in campaign.conditions
    ]
    rate = campaign.lengths[campaign.conditions[0].id].rate
    return SessionPlan(
        rate=rate,
        channels=tools.table(rate, FILTER_DELAY),
        runs=tuple(_run_plan(campaign, run, created) for run in campaign.runs),
        conditions=tuple(facts),
        protocol_text=campaign.text,
        protocol={"name": protocol.name, "question": protocol.question, "resolved": dump_protocol(protocol)},
        documents={
            "prediction": prediction_document(found),
            "rig": {"name": campaign.rig.name, "provenance": dict(campaign.rig.provenance),
                    "values": [asdict(value) for value in campaign.rig.values]},
            "provenance": provenance(campaign.text, protocol.seed, campaign.rig_time),
        },
        truth_documents={
            "instruments": {c.name: asdict(s) for c, s in zip(tools.channels, tools.states, strict=True)},
            "clock": {"error": tools.clock_error},
        },
        ledger_columns=COLUMNS,
        ledger_cycles=max(c.acquire.settle + c.acquire.record for c in campaign.conditions),
        scalars=SCALARS,
    )  # fmt: skip


def _run_plan(campaign: Campaign, run: Run, created: str) -> RunPlan:
    size, acquire = campaign.lengths[run.condition.id], run.condition.acquire
    return RunPlan(
        name=run.name,
        condition=run.condition.id,
        repeat=run.repeat,
        order=run.order,
        samples=size.samples,
        settle_samples=size.settle,
        blocks=len(size.blocks),
        t0=created,
        rate=size.rate,
        ledger_cycles=acquire.settle + acquire.record,
    )


def execute(
    campaign: Campaign,
    recorder: Recorder,
    workers: int,
    speed: float | None = None,
    progress: Callable[[Progress], None] = lambda _: None,
) -> dict[str, RunEnergy]:
    """Run everything that the recorder has not got yet; energies by run name, as read back from the record.

    `speed` is rig seconds per wall second (None: as fast as possible); a paced campaign runs one run after the other.
    """
    finished = recorder.completed()
    waiting = sorted((run for run in campaign.runs if run.name not in finished), key=lambda run: run.order)
    energies: dict[str, RunEnergy] = {}
    cycles: dict[str, int] = {}
    record = recorder.record()
    for part in _computed(campaign, waiting, workers if speed is None else 1, speed):
        name = part.run.name
        recorder.append(name, part.block)
        acquire = part.run.condition.acquire
        first = cycles.get(name, 0)
        wanted = part.ledger[: max(acquire.settle + acquire.record - first, 0)]
        recorder.write_ledger(name, first, wanted)
        cycles[name] = first + len(wanted)
        if part.demand is not None:
            recorder.finish(name, part.demand.scalars())
            energies[name] = run_energy(record, name)
            done = len(finished) + len(energies)
            progress(Progress(part.run, done, len(campaign.runs), energies[name]))
    return energies


def _computed(campaign: Campaign, waiting: list[Run], workers: int, speed: float | None) -> Iterator[Part]:
    """Parts of runs as workers deliver them; each run's parts in order. An error of a worker is raised here."""
    todo: queue.SimpleQueue[Run] = queue.SimpleQueue()
    for run in waiting:
        todo.put(run)
    ready: queue.Queue[Part | BaseException | None] = queue.Queue(maxsize=QUEUED_PARTS * workers)
    stop = threading.Event()

    def deliver(item: Part | BaseException | None) -> None:
        while not stop.is_set():
            with suppress(queue.Full):
                ready.put(item, timeout=0.1)
                return

    def work() -> None:
        try:
            while not stop.is_set():
                run = todo.get_nowait()
                pacer = Pacer(campaign.lengths[run.condition.id].rate, speed)
                for part in campaign.parts(run):
                    pacer.wait(part.block.start + part.block.count)
                    deliver(part)
                    if stop.is_set():
                        return
        except queue.Empty:
            deliver(None)
        except BaseException as error:  # noqa: BLE001  handed to the calling thread, which raises it
            deliver(error)

    with ThreadPoolExecutor(workers, "rig") as pool:
        try:
            for _ in range(workers):
                pool.submit(work)
            idle = 0
            while idle < workers:
                item = ready.get()
                if isinstance(item, BaseException):
                    raise item
                if item is None:
                    idle += 1
                else:
                    yield item
        finally:
            stop.set()


def run(
    campaign: Campaign,
    out: Path,
    workers: int = 2,
    speed: float | None = None,
    resume: bool = False,
    overwrite: bool = False,
    progress: Callable[[Progress], None] = lambda _: None,
) -> dict[str, Any]:
    """The main job: run a campaign into `out`/session.h5 and write its report there; returns the report."""
    path = out / "session.h5"
    if resume and path.exists():
        recorder = Recorder.resume(path)
    else:
        plan = session_plan(campaign, workers)
        out.mkdir(parents=True, exist_ok=True)
        recorder = Recorder.create(path, plan, overwrite)
    with recorder:
        energies = execute(campaign, recorder, workers, speed, progress)
        report = read_session(recorder.record(), energies)
    write_report(report, out)
    return report
