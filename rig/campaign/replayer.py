"""Replay of a recorded session: its blocks take the road of `run`, from the acquisition to the
report.
"""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from analysis.pipeline import read_session
from analysis.report.files import write_report
from analysis.results.report import Report
from analysis.results.run import RunEnergy
from daq.chain.block import Block
from daq.chain.clock import Pacer
from daq.chain.replay import Replayed
from daq.session.copy import plan_of
from daq.session.plan import RunInfo
from daq.session.record import Record, SessionTruth, open_session
from daq.session.writer import Recorder
from rig.campaign.incoming_signals import IncomingSignals
from rig.campaign.one_run.live import LiveUpdate, Watcher
from rig.campaign.one_run.part import Part
from rig.campaign.one_run.recorder import Analysis, Watch, record_parts
from rig.campaign.provenance import replay_provenance

NO_LEDGER = np.empty((0, 0))


def replay(
    session: Path,
    out: Path | None = None,
    speed: float | None = None,
    overwrite: bool = False,
    progress: Watch = lambda _: None,
    patience: float | None = None,
    live: Callable[[LiveUpdate], None] | None = None,
) -> Report:
    """Feed a session's blocks through recorder and analysis; returns the report.

    out : folder for a second session and its report: the same codes and the same report, byte for
        byte
    speed : rig seconds per wall second (None: as fast as possible)
    progress : called after every run; live : called after every block
    patience : as for `daq.open_session`

    Predictions and truth are those of the session.
    """
    with open_session(session, patience) as record:
        if out is None:
            return read_session(record, analysed(record, speed, progress, live))
        plan = plan_of(record, replay=replay_provenance(speed))
        out.mkdir(parents=True, exist_ok=True)
        with Recorder.create(out / "session.h5", plan, overwrite) as recorder:
            energies = record_parts(recorder, recorded(record, speed), progress, live)
            report = read_session(recorder.record(), energies)
    write_report(report, out)
    return report


def analysed(
    record: Record,
    speed: float | None = None,
    progress: Watch = lambda _: None,
    live: Callable[[LiveUpdate], None] | None = None,
) -> dict[str, RunEnergy]:
    """Return the energies of a record's complete runs, in order of execution, computed while their
    blocks arrive.
    """
    analysis = Analysis(record, progress, done=0)
    watcher = None if live is None else Watcher(record, live)
    for info in sorted(record.runs, key=lambda run: run.order):
        ended: list[Part] = []

        # Bound by default arguments: the generator must keep the run of this pass of the loop.
        def blocks(info: RunInfo = info, ended: list[Part] = ended) -> Iterator[Block]:
            for part in recorded_run(record, info, speed, None):
                if watcher is not None:
                    watcher.hear(part.run, part.block)
                if part.scalars is not None:
                    ended.append(part)
                yield part.block

        incoming = IncomingSignals(record, info.name, blocks())
        if info.complete:
            analysis.read(info.name, incoming.signal)
        incoming.drain()
        for part in ended:
            analysis.tell(part)
    return analysis.energies


def recorded(record: Record, speed: float | None) -> Iterator[Part]:
    """Yield the parts of a record, runs in order of execution, paced; incomplete runs as far as
    they go.
    """
    truth = record.truth if record.ledger_columns else None
    for info in sorted(record.runs, key=lambda run: run.order):
        yield from recorded_run(record, info, speed, truth)


def recorded_run(
    record: Record, info: RunInfo, speed: float | None, truth: SessionTruth | None
) -> Iterator[Part]:
    """Yield the parts of one run, each with its part of the ledger; without ledger if no truth is
    given.
    """
    acquisition, pacer = Replayed(record, info.name), Pacer(info.rate, speed)
    count, cycles = len(acquisition.sizes), record.ledger_cycles(info.name)
    for number, samples in enumerate(acquisition.sizes):
        block = acquisition.read(samples)
        pacer.wait(block.start + block.count)
        last = info.complete and block.start + block.count == info.samples
        rows = NO_LEDGER
        if truth is not None:
            # The ledger has cycles, not samples: spread evenly over the blocks.
            rows = truth.ledger(
                info.name, number * cycles // count, (number + 1) * cycles // count
            )[1]
        part = Part(
            info.name,
            block,
            rows,
            record.scalars(info.name) if last else None,
            info.flags if last else 0,
        )
        yield part.ended(pacer.punctuality)
