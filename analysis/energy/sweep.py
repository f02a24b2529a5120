"""A slow sweep of the drive: force and acceleration against frequency, cycle by cycle.

The phase of the drive is known: phi = 2 pi (f0 t + p t^2/2), p the sweep rate. A signal's
fundamental over the cycle from phi = 2 pi n to 2 pi (n + 1) is 2 mean(s e^(-j phi)) over the phase,
dphi = 2 pi f dt: samples count equally per unit of phase, wherever in the cycle they lie. Poles and
delays of the channels are corrected at each cycle's frequency.

A linear system answers a sweep with H - j (b/2) H'' + .., b = 2 pi p, derivatives by the angular
frequency. The error against the steady response, (b/2) |H''|, is estimated from the curve itself,
by a parabola through neighbouring points.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from analysis.energy.sweep_curve import SweepCurve
from analysis.session.record import AnalysisError, ChannelFacts, RecordedSession, RunFacts
from analysis.session.setting import Setting

__all__ = ["SweepSummary", "fundamentals", "shift", "summary", "sweep"]

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MOST_POINTS = 400  # of a curve in the report
PIECE = 1 << 20  # samples read at a time, so that memory does not grow with the record
NEIGHBOURS = 3  # points on either side of a parabola


@dataclass(frozen=True, slots=True)
class SweepSummary:
    """Largest and least acceleration of a sweep and its least force: (value, frequency) of each, SI
    units.
    """

    acceleration: tuple[float, float]
    acceleration_least: tuple[float, float]
    force_least: tuple[float, float]


def sweep(
    record: RecordedSession,
    run: RunFacts,
    flags: Sequence[str] = (),
    use: Mapping[str, float] | None = None,
) -> SweepCurve:
    """Return the sweep of one run, averaged over groups of cycles where there are more than
    MOST_POINTS.

    AnalysisError where the run is incomplete or a channel is missing.
    """
    setting = Setting.of(record.conditions[run.condition])
    if setting.sweep_to is None:
        raise AnalysisError(f"{run.name} is no sweep")
    if not run.complete:
        raise AnalysisError(f"{run.name} is not complete")
    missing = [name for name in ("force", "acceleration") if name not in record.channels]
    if missing:
        raise AnalysisError(
            f"the record has no channel {missing[0]!r}; it has {', '.join(record.channels)}"
        )
    frequency, force, acceleration = _cycles(record, run, setting)
    together = -(-frequency.size // MOST_POINTS)
    whole = frequency.size // together * together
    frequency = frequency[:whole].reshape(-1, together).mean(axis=1)
    force, acceleration = (
        x[:whole].reshape(-1, together).mean(axis=1) for x in (force, acceleration)
    )
    pace = _pace(setting)
    ratio = force * acceleration.conj()
    return SweepCurve(
        run=run.name,
        flags=tuple(flags),
        use=dict(use or {}),
        condition=run.condition,
        bed=setting.bed,
        fill=setting.fill,
        from_=setting.frequency,
        to=setting.sweep_to,
        rate=pace,
        cycles_each=together,
        frequency=tuple(frequency.tolist()),
        force=tuple(np.abs(force).tolist()),
        acceleration=tuple(np.abs(acceleration).tolist()),
        force_phase=tuple(np.angle(ratio).tolist()),
        M_eff=tuple((ratio.real / np.abs(acceleration) ** 2).tolist()),
        shift_force=shift(frequency, force, pace),
        shift_acceleration=shift(frequency, acceleration, pace),
    )


def _pace(setting: Setting) -> float:
    """Return the sweep rate, Hz/s: `record_cycles` cycles at the mean of both frequencies."""
    last = setting.frequency if setting.sweep_to is None else setting.sweep_to
    return (last**2 - setting.frequency**2) / (2.0 * setting.record_cycles)


def _cycles(
    record: RecordedSession, run: RunFacts, setting: Setting
) -> tuple[Array, Complex, Complex]:
    """Return the mean frequency of every cycle of the sweep, and the phasors of force and
    acceleration in it.
    """
    names = ("force", "acceleration")
    channels = [record.channels[name] for name in names]
    count, pace, f0 = int(setting.record_cycles), _pace(setting), setting.frequency
    edges = np.sqrt(f0**2 + 2.0 * pace * np.arange(count + 1))
    frequency = 0.5 * (edges[1:] + edges[:-1])
    found = []
    for name, channel in zip(names, channels, strict=True):
        start = (
            (setting.settle_cycles / f0) * run.rate + channel.filter_delay - channel.skew * run.rate
        )
        sums = np.zeros((2, count), np.complex128)
        for first in range(0, run.samples, PIECE):
            signal = record.signal(run.name, name, first, min(first + PIECE, run.samples)).samples
            time = (first + np.arange(signal.size) - start) / run.rate
            sums += fundamentals(signal, np.asarray(time, dtype=np.float64), f0, pace, count)
        phasor = sums[0] / sums[1].real
        found.append(phasor / _passed(channel, frequency))
    return frequency, found[0], found[1]


def fundamentals(signal: Array, time: Array, first: float, pace: float, cycles: int) -> Complex:
    """Return the sums over the samples of each cycle that give its fundamental's phasor (peak), (2,
    cycles).

    They are sum s e^(-j phi) dphi and sum dphi/2; the phasor is their ratio. time: s from the start
    of the sweep at `first` Hz; pace: Hz/s.
    """
    turns = (first + 0.5 * pace * time) * time
    inside = (time >= 0.0) & (turns < cycles)
    signal, turns, weight = signal[inside], turns[inside], first + pace * time[inside]
    cycle = np.floor(turns).astype(np.int64)
    turned = signal * weight * np.exp(-2j * np.pi * (turns - cycle))
    sums = np.empty((2, cycles), np.complex128)
    sums[0] = np.bincount(cycle, turned.real, cycles) + 1j * np.bincount(cycle, turned.imag, cycles)
    sums[1] = 0.5 * np.bincount(cycle, weight, cycles)
    return sums


def _passed(channel: ChannelFacts, frequency: Array) -> Complex:
    """Return the response of a channel's high-pass poles at each frequency (Hz)."""
    jw = 2j * np.pi * frequency
    passed = np.ones_like(jw)
    for tau in channel.time_constants:
        passed = passed * (jw * tau / (1.0 + jw * tau))
    return passed


def shift(frequency: Array, response: Complex, pace: float) -> float | None:
    """Return the largest sweep-rate error (b/2) |H''| of a curve, relative to the largest |H|.

    None for too few points.
    """
    if frequency.size < 2 * NEIGHBOURS + 1:
        return None
    second = []
    for k in range(NEIGHBOURS, frequency.size - NEIGHBOURS):
        near = slice(k - NEIGHBOURS, k + NEIGHBOURS + 1)
        place = 2.0 * np.pi * (frequency[near] - frequency[k])
        unit = float(np.abs(place).max())
        curve = np.polynomial.polynomial.polyfit(
            place / unit, np.stack([response[near].real, response[near].imag], 1), 2
        )
        second.append(2.0 * float(np.hypot(*curve[2])) / unit**2)
    return float(np.pi * abs(pace) * max(second) / np.abs(response).max())


def summary(one: SweepCurve) -> SweepSummary:
    """Return the largest and least points of a sweep."""
    acceleration, force = np.array(one.acceleration), np.array(one.force)

    def point(values: Array, place: int) -> tuple[float, float]:
        return float(values[place]), float(one.frequency[place])

    return SweepSummary(
        point(acceleration, int(acceleration.argmax())),
        point(acceleration, int(acceleration.argmin())),
        point(force, int(force.argmin())),
    )
