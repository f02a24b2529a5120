"""From a record to energies and to the report: one run at a time, in constant memory."""

import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from functools import cached_property

import numpy as np

from analysis.comparison.loop_back import LoopBack, loop_back
from analysis.comparison.offset_terms import actual_of
from analysis.comparison.whole_session import agreement
from analysis.energy.energy_and_phasors import AtBox, Energy
from analysis.energy.gauge_position import at_box
from analysis.energy.ledger_means import ledger_means
from analysis.energy.per_cycle import Total, harmonics, window_energy
from analysis.energy.sweep import sweep
from analysis.results.coil_current import coil_of
from analysis.results.deliberate_errors import misread
from analysis.results.report import LeftOutRun, Report, Resolved
from analysis.results.run import Coil, RunEnergy
from analysis.session.documents import document_as
from analysis.session.exciter import SessionExciter
from analysis.session.fidelity import Fidelity
from analysis.session.former_names import text_today
from analysis.session.protocol import SessionProtocol, SessionRig
from analysis.session.record import (
    AnalysisError,
    ChannelFacts,
    RecordedSession,
    RunFacts,
    Signal,
    Truth,
)
from analysis.session.run_flags import stated_flags, use_of
from analysis.session.setting import LOOP_BACK, Setting
from analysis.shared_work import ForEach, here
from analysis.signals.cycles import Window, clear_of, on_grid, whole_cycles
from analysis.signals.quality import Scrutiny
from analysis.uncertainty.budget import noise_of
from daq.chain.block import Flag, flag_names

__all__ = ["energies_of", "read_session", "run_energy"]

FORCE, ACCELERATION, CURRENT = "force", "acceleration", "current"
BROKEN = int(Flag.GAP | Flag.INVALID | Flag.OVERRUN | Flag.IEPE_OPEN | Flag.IEPE_SHORT)
"""Flags of samples that are missing or invalid: no energy can be stated."""
CLIPPED = int(Flag.OVERLOAD_HI | Flag.OVERLOAD_LO | Flag.SENSOR_CLIP)
SETTLED = ~int(Flag.NOT_SETTLED)
RECORDED = "W_T_recorded"  # scalar: J per cycle, W_T on the recorded waveform
TRIGGER = (
    "trigger_sample"  # scalar: samples from a start of the drive's cycle to the record's first
)

SignalOf = Callable[[str, str, int, int], Signal]
"""A function from run, channel, first sample and one past the last to the samples."""


def run_energy(
    record: RecordedSession,
    run: RunFacts | str,
    tolerate_gaps: bool = False,
    signal: SignalOf | None = None,
) -> RunEnergy:
    """Return the energies of one complete run of a record.

    Poles and delays are corrected with the certified channel table. run: a run of the record, or
    its name. signal: supplies the samples in place of `record.signal`. May be called from any
    thread, as soon as the run is complete, while others are still written.

    AnalysisError where the run is incomplete, has missing samples in the window (unless gaps are
    tolerated: then the whole cycles beside them are read), a dead or stuck channel, or no whole
    cycle.
    """
    return Reader(record, tolerate_gaps, signal).energy(
        record.run(run) if isinstance(run, str) else run
    )


def energies_of(
    record: RecordedSession, names: Iterable[str], tolerate_gaps: bool = False
) -> dict[str, RunEnergy]:
    """Return the energies of runs by name, as `run_energy` does, leaving out the runs that cannot
    be used.
    """
    reader, found = Reader(record, tolerate_gaps), {}
    for name in names:
        with suppress(AnalysisError):
            found[name] = reader.energy(record.run(name))
    return found


class Reader:
    """A reader of the runs of one record, which looks up and checks the facts of the record once."""

    def __init__(
        self, record: RecordedSession, tolerate_gaps: bool = False, signal: SignalOf | None = None
    ) -> None:
        self._record = record
        self._signal = signal or record.signal
        self._tolerate_gaps = tolerate_gaps
        self._settings: dict[str, Setting] = {}

    def setting(self, condition: str) -> Setting:
        """Return the setting of a condition."""
        if condition not in self._settings:
            self._settings[condition] = Setting.of(self._record.conditions[condition])
        return self._settings[condition]

    @cached_property
    def channels(self) -> tuple[ChannelFacts, ChannelFacts]:
        """Force and acceleration. AnalysisError where one of them is not recorded."""
        return _channel(self._record, FORCE), _channel(self._record, ACCELERATION)

    @cached_property
    def exciter(self) -> SessionExciter | None:
        """The exciter; None where the session has none."""
        return document_as(SessionExciter, "exciter", self._record.document("exciter"))

    @cached_property
    def truth(self) -> Truth | None:
        """The truth of a simulated session; None for any other."""
        return self._record.truth

    def energy(self, run: RunFacts) -> RunEnergy:
        """Return the energies of a run; see run_energy."""
        record = self._record
        if not run.complete:
            raise AnalysisError(f"{run.name} is not complete")
        setting = self.setting(run.condition)
        if setting.bed == LOOP_BACK:
            raise AnalysisError(f"{run.name} is a loop-back: there is no energy in it")
        if setting.sweep_to is not None:
            raise AnalysisError(
                f"{run.name} is a sweep: its cycles do not close, no energy is stated"
            )
        force, acceleration = self.channels
        scalars = record.scalars(run.name)
        window = _window(run, setting, force, scalars)
        delay = (
            (acceleration.filter_delay - force.filter_delay) / run.rate
            + force.skew
            - acceleration.skew
        )
        stretches = _stretches(record, run, window, self._tolerate_gaps)
        total, scrutiny = Total(), Scrutiny((force, acceleration), setting)
        bits = run.flags & SETTLED
        for part in (part for stretch in stretches for part in stretch.segments()):
            first, last = part.sample_range()
            signals = [self._signal(run.name, name, first, last) for name in (FORCE, ACCELERATION)]
            found = signals[0].flags | signals[1].flags
            if found & BROKEN:
                names = ", ".join(flag_names(found & BROKEN))
                raise AnalysisError(f"{run.name} has {names} in samples {first} to {last}")
            bits |= found & SETTLED
            F, a = (on_grid(signal.samples, first, part) for signal in signals)
            scrutiny.add(signals, (F, a), part.cycles)
            energy = window_energy(
                F, a, part.cycles, setting.frequency,
                time_constants=(force.time_constants, acceleration.time_constants), delay=delay,
                box_mass=setting.box_mass,
            )  # fmt: skip
            if setting.deliberate_error is not None:
                energy = misread(energy, setting.deliberate_error, F, a)
            total.add(energy)
        energy = total.energy()
        samples = round(energy.cycles * window.grid.period)
        wanted = int(setting.record_cycles)
        # Gaps cost cycles: fewer than the protocol asked for is a flag.
        short = (f"{energy.cycles}_of_{wanted}_cycles",) if energy.cycles < wanted else ()
        recorded = scalars.get(RECORDED, math.nan)
        return RunEnergy(
            run=run.name,
            condition=run.condition,
            repeat=run.repeat,
            order=run.order,
            energy=energy,
            u_noise=noise_of(energy, force, acceleration, samples),
            flags=(
                *flag_names(int(bits)),
                *scrutiny.flags(run.name),
                *short,
                *stated_flags(scalars),
            ),
            use=use_of(scalars),
            ledger=ledger_means(self.truth, run, setting, window, stretches),
            coil=_coil(record, run, window, energy, samples, self.exciter),
            at_box=_at_box(setting, energy, self.exciter),
            recorded=recorded if math.isfinite(recorded) else None,
            u_recorded=scalars.get(f"u_{RECORDED}", 0.0),
            clip_ratio=_clip_ratio(record, run) if bits & CLIPPED else 0.0,
        )


def _window(
    run: RunFacts, setting: Setting, force: ChannelFacts, scalars: Mapping[str, float]
) -> Window:
    """Return the whole cycles of a run after settling. AnalysisError where there are none."""
    # Samples from the record's first one to the next start of a cycle of the drive.
    phase = -scalars.get(TRIGGER, 0.0) % (run.rate / setting.frequency)
    try:
        return whole_cycles(
            run.samples,
            run.rate,
            setting.frequency,
            filter_delay=force.filter_delay + phase,
            settle=setting.settle_cycles,
            cycles=int(setting.record_cycles),
        )
    except ValueError as error:
        raise AnalysisError(f"{run.name}: {error}") from error


def window_range(record: RecordedSession, run: RunFacts) -> tuple[float, float]:
    """Return the first sample of the whole cycles that are analysed, and one past the last.

    Fractional where a cycle has no whole number of samples. Where there are no such cycles (a
    sweep, a loop-back, a record cut short), everything after the settling.
    """
    setting = Setting.of(record.conditions[run.condition])
    settled = min(setting.settle_cycles * run.rate / setting.frequency, run.samples / 2)
    if setting.sweep_to is not None or setting.bed == LOOP_BACK:
        return settled, float(run.samples)
    try:
        window = _window(run, setting, _channel(record, FORCE), record.scalars(run.name))
    except AnalysisError:
        return settled, float(run.samples)
    return window.start, window.start + window.cycles * window.grid.period


def _stretches(
    record: RecordedSession, run: RunFacts, window: Window, tolerate_gaps: bool
) -> tuple[Window, ...]:
    """Return the window, or where gaps are tolerated its whole cycles between broken blocks.

    No stretch crosses a broken block. AnalysisError where none remains.
    """
    if not tolerate_gaps or not run.flags & BROKEN:
        return (window,)
    blocks = record.blocks(run.name)
    broken = (np.bitwise_or.reduce(blocks["flags"], axis=1) & BROKEN) != 0
    bad = [(int(b["start"]), int(b["start"] + b["count"])) for b in blocks[broken]]
    left = clear_of(window, bad)
    if not left:
        raise AnalysisError(f"{run.name} has no whole cycle beside its gaps")
    return left


def _clip_ratio(record: RecordedSession, run: RunFacts) -> float:
    """Return the largest fraction of a channel's samples that lie at a rail."""
    blocks = record.blocks(run.name)
    return float(blocks["clipped"].sum(axis=0).max()) / max(int(blocks["count"].sum()), 1)


def _coil(
    record: RecordedSession,
    run: RunFacts,
    window: Window,
    energy: Energy,
    samples: int,
    exciter: SessionExciter | None,
) -> Coil | None:
    """Return the energy from the coil's current; None where it is not recorded or the exciter is
    not known.
    """
    channel = record.channels.get(CURRENT)
    if exciter is None or channel is None:
        return None
    force = _channel(record, FORCE)  # the phasors of the energies refer to its time
    lag = (channel.filter_delay - force.filter_delay) / run.rate + force.skew - channel.skew
    total = np.zeros_like(energy.acceleration)
    for part in window.segments():
        first, last = part.sample_range()
        current = on_grid(record.signal(run.name, CURRENT, first, last).samples, first, part)
        total += harmonics(current, part.cycles, current.size // part.cycles) * (
            part.cycles / window.cycles
        )
    orders = np.arange(1, total.size + 1)
    total *= np.exp(2j * np.pi * energy.frequency * lag * orders)
    return coil_of(total, energy, channel, exciter, samples)


def _at_box(setting: Setting, energy: Energy, exciter: SessionExciter | None) -> AtBox | None:
    """Return the run corrected to the box; None where the positions or the stinger are not known."""
    if setting.gauge is None or setting.accelerometer is None or exciter is None:
        return None
    return at_box(energy, setting.gauge, setting.accelerometer, setting.gauge_mass, exciter)


def read_session(
    record: RecordedSession,
    energies: Mapping[str, RunEnergy] | None = None,
    tolerate_gaps: bool = False,
    each: ForEach = here,
) -> Report:
    """Return the report of a session from its record alone.

    energies: results of run_energy by run name, where they exist already. tolerate_gaps: see
    run_energy. each: evaluates the conditions, here or in several processes. Runs that cannot be
    used are listed under `left_out` with the reason.
    """
    known, loop_backs, swept, left_out = dict(energies or {}), [], [], []
    reader = Reader(record, tolerate_gaps)
    for run in record.runs:
        if run.name not in known:
            try:
                setting = reader.setting(run.condition)
                if setting.bed == LOOP_BACK:
                    loop_backs.append(_loop_back(record, run))
                elif setting.sweep_to is not None:
                    scalars = record.scalars(run.name)
                    swept.append(sweep(record, run, _flags(run, scalars), use_of(scalars)))
                else:
                    known[run.name] = reader.energy(run)
            except AnalysisError as error:
                left_out.append(LeftOutRun(run.name, str(error)))
    protocol = (
        document_as(SessionProtocol, "protocol", record.document("protocol")) or SessionProtocol()
    )
    rig = document_as(SessionRig, "rig", record.document("rig")) or SessionRig()
    return agreement(
        [known[run.name] for run in record.runs if run.name in known],
        record.conditions,
        record.document("prediction"),
        record.channels,
        protocol=protocol.name,
        question=protocol.question,
        synthetic=record.synthetic,
        assumed=rig.values,
        left_out=left_out,
        expect=protocol.expect,
        actual=actual_of(record.truth),
        fidelity=document_as(Fidelity, "fidelity", record.document("fidelity")),
        resolved=_resolved(protocol, rig),
        loop_backs=loop_backs,
        sweeps=swept,
        each=each,
    )


def _flags(run: RunFacts, scalars: Mapping[str, float]) -> tuple[str, ...]:
    """Return the flags of a run whose samples are read as a whole.

    AnalysisError where samples are missing or invalid.
    """
    if run.flags & BROKEN:
        raise AnalysisError(f"{run.name} has {', '.join(flag_names(run.flags & BROKEN))}")
    return (*flag_names(run.flags & SETTLED), *stated_flags(scalars))


def _loop_back(record: RecordedSession, run: RunFacts) -> LoopBack:
    """Return the result of a loop-back run. AnalysisError where it is incomplete or lacks a
    channel.
    """
    if not run.complete:
        raise AnalysisError(f"{run.name} is not complete")
    setting, force = Setting.of(record.conditions[run.condition]), _channel(record, FORCE)
    _channel(record, ACCELERATION)
    return loop_back(
        record, run, _window(run, setting, force, record.scalars(run.name)), setting.frequency
    )


def _resolved(protocol: SessionProtocol, rig: SessionRig) -> Resolved | None:
    """Return protocol and rig file as written out in the session, with the names of today; None
    without either.
    """
    found = Resolved(text_today(protocol.resolved) or None, text_today(rig.resolved) or None)
    return found if found.files() else None


def _channel(record: RecordedSession, name: str) -> ChannelFacts:
    """Return a channel of the record. AnalysisError where it is missing."""
    if name not in record.channels:
        raise AnalysisError(
            f"the record has no channel {name!r}; it has {', '.join(record.channels)}"
        )
    return record.channels[name]
